#pragma once

#include <optional>
#include <string>
#include <vector>

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
/// The document of a hand's motion with those of its fingers after it, as `fingers`.
[[nodiscard]] std::string with_fingers(const std::string& hand, const std::vector<std::string>& fingers);

}  // namespace colift::tools
