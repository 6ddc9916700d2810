#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// What became of one finger.
struct FingerOpening {
  bool answers = false;
  std::int32_t from = 0, to = 0;  ///< Counts of the motor, before and after.
  bool rests = false;             ///< MODE was read back as idle at the end.
  [[nodiscard]] double opened_deg() const;
};

/// Opens whatever finger still answers, in any process, without configuring the hand: no identity, no zero,
/// no working values are needed, and a puck that is silent or refuses keeps nobody else from opening. A
/// finger goes towards its open stop, by its own counts, until it meets it or `move_s` has passed; then its
/// motor rests. The spread stays as it is. What the hand holds falls. It waits, at most wake_s + boot_s +
/// move_s + 1 s. Errors: LinkLost (the bus does not open, or no finger answers). \param interrupted  Asked
/// every millisecond; true ends it with resting motors.
[[nodiscard]] Result<std::array<FingerOpening, 3>> emergency_open(
    CanBus& bus, const Clock& clock, const BarrettHandConfig& config,
    const std::function<bool()>& interrupted = [] { return false; });

/// One sentence a finger.
[[nodiscard]] std::string describe(const std::array<FingerOpening, 3>& fingers);

}  // namespace colift::hal
