#pragma once

#include "hal/drivers/barrett_can/hand_config.hpp"
#include "tools/bring_up/cmd_hal.hpp"

namespace colift::tools {

/// `hal hand calibrate`: asks at the terminal, measures, and keeps the scales in HalOptions::out. 0 measured,
/// 2 bad request or file, 3 the hand is not there or what it shows is no line, 130 interrupted.
[[nodiscard]] int cmd_calibrate_finger(const CommonOptions& common, const HalOptions& options,
                                       const hal::BarrettHandConfig& config);

}  // namespace colift::tools
