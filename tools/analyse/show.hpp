#pragma once

#include "control/session/decide.hpp"
#include "tools/analyse/recorded_scene.hpp"

namespace colift::tools {

/// Writes the picture and the report that the options ask for. `outcome` is null for `look`. Errors: BadInput
/// when a file cannot be written.
[[nodiscard]] hal::Result<> show(const Seen& seen, const control::Outcome* outcome,
                                 const LookOptions& options, const CommonOptions& common, const Setup& setup);

}  // namespace colift::tools
