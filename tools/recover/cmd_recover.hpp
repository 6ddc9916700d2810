#pragma once

#include "control/recovery/recovery.hpp"
#include "tools/cli/options.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/back_ends.hpp"

namespace colift::tools {

struct RecoverOptions {
  std::optional<std::filesystem::path> robot, scenario;
  bool yes = false;  ///< Simulated and emulated rigs only.
};

/// After a stop: what state arm, hand and load are in, and in confirmed steps to lowered, released, home. 0
/// at home, hand open; 1 held, with the reason; 2 bad usage; 3 a device is not there; 130 interrupted.
[[nodiscard]] int cmd_recover(const CommonOptions& common, const RecoverOptions& options,
                              const WiredDevices* wired);

/// The same on a rig whose run has just stopped.
[[nodiscard]] control::RecoveryRecord recover_rig(Rig& rig, const Setup& setup, std::uint64_t seed,
                                                  const control::RecoveryHooks& hooks);

}  // namespace colift::tools
