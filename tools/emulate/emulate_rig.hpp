#pragma once

#include <filesystem>
#include <optional>

#include "tools/emulate/emulate.hpp"

namespace colift::tools {

struct EmulateRigOptions {
  EmulateOptions common;
  std::optional<std::filesystem::path> robot;  ///< Whose wires; unset: those of config/emulated.yaml.
};

/// The far ends of all three wires on one simulated world, for one `run` in another program. 0 the clients
/// broke no rule, 1 they did, 2 bad options, 3 a port or an address is not to be had.
[[nodiscard]] int cmd_emulate_rig(const CommonOptions& common, const EmulateRigOptions& options);

}  // namespace colift::tools
