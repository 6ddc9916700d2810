#include "sim_hal/emulator/hand/hand_wire.hpp"

#include <algorithm>
#include <initializer_list>
#include <numeric>

#include "sim_hal/emulator/hand/hand_property.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint16_t kGroup = 0x400;
constexpr int kOfPosition = 3, kOfValue = 6, kOfJoint = 7, kOfTop = 8, kOfRows = 9;

std::uint16_t to_group(int puck, int group) {
  return static_cast<std::uint16_t>(kGroup | puck << 5 | group);
}

void put(hal::CanFrame& f, std::uint32_t byte) {
  f.data[f.length++] = static_cast<std::uint8_t>(byte & 0xff);
}

void put22(hal::CanFrame& f, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  put(f, 0x80 | (bits >> 16 & 0x3f));
  put(f, bits >> 8);
  put(f, bits);
}

}  // namespace

std::optional<HandRequest> read_hand_request(const hal::CanFrame& frame) {
  if (frame.id > 0x7ff || frame.length == 0 || frame.length > 8) return std::nullopt;
  HandRequest r;
  r.group = (frame.id & kGroup) != 0;
  r.from = frame.id >> 5 & 0x1f;
  r.to = frame.id & 0x1f;
  r.property = frame.data[0] & 0x7f;
  if ((frame.data[0] & 0x80) == 0) {
    if (frame.length > 2) return std::nullopt;
    return r;
  }
  if (frame.length == 8 && r.property == prop::kT) {
    r.kind = HandRequest::Kind::PackedTorque;
    std::uint64_t bits = 0;
    for (std::size_t i = 1; i < 8; ++i) bits = bits << 8 | frame.data[i];
    for (std::size_t k = 0; k < 4; ++k) {
      const auto raw = static_cast<std::int32_t>(bits >> (42 - 14 * k) & 0x3fff);
      r.torque[k] = static_cast<std::int16_t>(raw >= 0x2000 ? raw - 0x4000 : raw);
    }
    return r;
  }
  if ((frame.length != 4 && frame.length != 6) || frame.data[1] != 0) return std::nullopt;
  r.kind = HandRequest::Kind::Set;
  std::uint32_t bits = (frame.data[frame.length - 1U] & 0x80) != 0 ? 0xffffffffU : 0U;
  for (std::size_t i = frame.length - 1U; i >= 2; --i) bits = bits << 8 | frame.data[i];
  r.value = static_cast<std::int32_t>(bits);
  return r;
}

hal::CanFrame hand_value(int puck, int asked_by, int property, bool wide, std::int32_t value) {
  hal::CanFrame f;
  f.id = asked_by == 0 ? to_group(puck, kOfValue) : static_cast<std::uint16_t>(puck << 5 | asked_by);
  put(f, 0x80U | static_cast<std::uint32_t>(property));
  put(f, 0);
  const auto bits = static_cast<std::uint32_t>(value);
  for (std::uint32_t i = 0; i < (wide ? 4U : 2U); ++i) put(f, bits >> (8 * i));
  return f;
}

hal::CanFrame hand_position(int puck, std::int32_t motor, std::optional<std::int32_t> joint) {
  hal::CanFrame f;
  f.id = to_group(puck, kOfPosition);
  put22(f, motor);
  if (joint) put22(f, *joint);
  return f;
}

hal::CanFrame hand_joint(int puck, std::int32_t joint) {
  hal::CanFrame f;
  f.id = to_group(puck, kOfJoint);
  put22(f, joint);
  return f;
}

hal::CanFrame hand_pad_row(int puck, int row, const HandCells& cells) {
  hal::CanFrame f;
  f.id = to_group(puck, kOfRows);
  std::uint64_t bits = static_cast<std::uint64_t>(row);
  for (std::size_t i = 0; i < 5; ++i) {
    const std::size_t cell = 5 * static_cast<std::size_t>(row) + i;
    bits = bits << 12 | (cell < cells.size() ? cells[cell] & 0xfffU : 0U);
  }
  for (int shift = 56; shift >= 0; shift -= 8) put(f, static_cast<std::uint32_t>(bits >> shift & 0xff));
  return f;
}

hal::CanFrame hand_pad_top(int puck, const HandCells& cells) {
  std::array<std::size_t, kHandCells> order{};
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return cells[a] > cells[b]; });
  std::sort(order.begin(), order.begin() + 10);
  std::uint32_t map = 0;
  std::uint64_t values = 0;
  for (std::size_t i = 0; i < 10; ++i) {
    map |= 1U << order[i];
    values = values << 4 | std::min<unsigned>(cells[order[i]] / 256U, 15U);
  }
  hal::CanFrame f;
  f.id = to_group(puck, kOfTop);
  for (int shift = 16; shift >= 0; shift -= 8) put(f, map >> shift);
  for (int shift = 32; shift >= 0; shift -= 8) put(f, static_cast<std::uint32_t>(values >> shift & 0xff));
  return f;
}

hal::Duration hand_frame_time(const hal::CanFrame& frame) {
  const int bits = 47 + 8 * frame.length;  // with the gap to the next one
  return std::chrono::microseconds(bits + bits / 10);
}

}  // namespace colift::sim_hal
