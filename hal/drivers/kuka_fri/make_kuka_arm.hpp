#pragma once

#include <memory>

#include "hal/arm.hpp"
#include "hal/drivers/kuka_fri/fri_config.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// A KUKA LWR 4+ behind its controller's Fast Research Interface, over UDP. Not open yet: configure() opens
/// it. `clock` is the machine's steady clock and outlives the arm. Errors: BadConfig (addresses).
[[nodiscard]] Result<std::unique_ptr<Arm>> make_kuka_arm(const FriConfig& config, const Clock& clock);

}  // namespace colift::hal
