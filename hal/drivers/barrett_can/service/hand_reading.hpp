#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// What one puck answered.
struct PuckReading {
  struct Value {
    barrett::Property property{};
    std::optional<std::int32_t> value;  ///< Nullopt: it did not answer about it.
  };
  bool answers = false;
  /// In the order of kReadOfAll and, of a puck that is awake, kReadOfAwake.
  std::vector<Value> values;
  std::optional<std::int32_t> joint;  ///< Of a finger: came with P.

  [[nodiscard]] std::optional<std::int32_t> of(barrett::Property property) const;
  [[nodiscard]] bool awake() const;
  /// Its zero was found since its last reset, by this driver.
  [[nodiscard]] bool zero_known() const;
};

/// The whole hand.
struct HandReading {
  std::array<PuckReading, 4> pucks;
  Duration round_trip{0};  ///< The slowest answer.
  [[nodiscard]] int answering() const;
};

/// Asks every puck what it is and how it is. Read-only: nothing is set, woken or energised; of a puck in its
/// monitor only what the monitor answers is asked. Waits for each answer 0.1 s at most, three times. Errors:
/// LinkLost (the bus does not open, or nobody answers).
[[nodiscard]] Result<HandReading> read_hand(CanBus& bus, const Clock& clock, const BarrettHandConfig& config);

}  // namespace colift::hal
