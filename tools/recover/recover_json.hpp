#pragma once

#include <string>

#include "control/recovery/recovery.hpp"

namespace colift::tools {

/// `colift.recover/1`: what was found, each step, how it ended.
[[nodiscard]] std::string recover_document(const control::RecoveryRecord& record);

}  // namespace colift::tools
