#pragma once

#include "tools/cli/shipped_files.hpp"

namespace colift::tools {

/// `colift scenarios`, `robots`, `scenes`: the shipped files of one kind, with what they are for; with `json`
/// the document colift.shipped/1. 0 listed, 2 there are none beside the program.
[[nodiscard]] int cmd_shipped(ShippedKind kind, bool json);

}  // namespace colift::tools
