#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/can_bus.hpp"
#include "sim_hal/emulator/hand/hand_gear.hpp"

namespace colift::sim_hal {

/// What a frame wishes of the pucks. Identifier: bit 10 group, bits 9 to 5 sender, bits 4 to 0 receiver.
struct HandRequest {
  enum class Kind { Get, Set, PackedTorque };
  Kind kind = Kind::Get;
  int from = 0, to = 0;
  bool group = false;
  int property = 0;
  std::int32_t value = 0;                ///< Of a Set, sign-extended from the last byte that was there.
  std::array<std::int16_t, 4> torque{};  ///< Of PackedTorque: four times 14 bits.
};

/// As a puck reads it: a question has 1 or 2 bytes, a setting 4 or 6 and a zero between number and value,
/// packed torque 8. Nullopt: a puck ignores such a frame.
[[nodiscard]] std::optional<HandRequest> read_hand_request(const hal::CanFrame& frame);

/// The answer to a question of node 0 goes to group 6, to any other node to that node itself. Little endian.
[[nodiscard]] hal::CanFrame hand_value(int puck, int asked_by, int property, bool wide, std::int32_t value);

/// To group 3: 22 bits each, big endian, bit 7 of the first byte of each set. The spread has no joint.
[[nodiscard]] hal::CanFrame hand_position(int puck, std::int32_t motor, std::optional<std::int32_t> joint);

/// The joint encoder alone, to group 7.
[[nodiscard]] hal::CanFrame hand_joint(int puck, std::int32_t joint);

/// Cells in 1/256 N/cm2, 12 bits.
using HandCells = std::array<std::uint16_t, kHandCells>;

/// To group 9: row 0 to 4 of five cells each, the last one of four.
[[nodiscard]] hal::CanFrame hand_pad_row(int puck, int row, const HandCells& cells);

/// To group 8: the ten cells with the highest pressure in whole N/cm2; bit 0 of the map is the first cell.
[[nodiscard]] hal::CanFrame hand_pad_top(int puck, const HandCells& cells);

/// How long a frame keeps the bus busy at 1 Mbit/s, with some stuffing.
[[nodiscard]] hal::Duration hand_frame_time(const hal::CanFrame& frame);

}  // namespace colift::sim_hal
