#pragma once

#include <optional>
#include <string>

#include "hal/drivers/barrett_can/service/finger_motion.hpp"

namespace colift::tools {

/// "F2", "f2" or "2"; nullopt for anything else.
[[nodiscard]] std::optional<hal::barrett::Puck> parse_finger(const std::string& text);

/// The motion of a verb (finger, step, velocity, torque): degrees, degrees a second, N m. Nullopt for another
/// verb.
[[nodiscard]] std::optional<hal::FingerMotion> finger_motion_of(const std::string& verb,
                                                                hal::barrett::Puck finger, double value);

[[nodiscard]] std::string finger_text(hal::barrett::Puck finger, const hal::FingerMotionEnd& end);
/// Document colift.hal.hand/1.
[[nodiscard]] std::string finger_document(const std::string& verb, hal::barrett::Puck finger,
                                          const hal::FingerMotionEnd& end);

}  // namespace colift::tools
