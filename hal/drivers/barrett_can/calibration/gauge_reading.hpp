#pragma once

#include <cstdint>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// What a finger's strain gauge shows over a while.
struct GaugeReading {
  std::int32_t serial = 0;    ///< Of its puck.
  double counts = 0.0;        ///< Mean.
  double noise_counts = 0.0;  ///< Standard deviation.
  double shown_nm = 0.0;      ///< Torque about the outer joint by the maker's curve, from its own zero.
  int readings = 0;
};

/// Asks a finger's puck for its gauge for `for_s`. Nothing is set and nothing moves. Errors: LinkLost (bus,
/// no answer), NotReady (asleep), DeviceFault (no gauge, or one that shows no 12 bits).
[[nodiscard]] Result<GaugeReading> read_gauge(CanBus& bus, const Clock& clock,
                                              const BarrettHandConfig& config, barrett::Puck finger,
                                              double for_s);

}  // namespace colift::hal
