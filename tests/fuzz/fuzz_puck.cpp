// Any identifier, length and bytes as an answer of the hand, and as an error frame of the bus: read or
// refused, and what was read lies in its range and is read the same from the frame that it stands for.

#include <algorithm>
#include <cstdint>
#include <span>
#include <variant>

#include "hal/drivers/barrett_can/hand_units.hpp"
#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"
#include "hal/os/can_error.hpp"
#include "tests/fuzz/demand.hpp"

namespace {

using colift::fuzz::demand;
using namespace colift::hal;
using namespace colift::hal::barrett;

void judge(const CanFrame& frame) {
  const auto reply = decode_reply(frame);
  if (!reply) {
    demand(!to_string(reply.error()).empty());
    return;
  }
  if (const auto* value = std::get_if<ValueReply>(&*reply)) {
    demand(property_info(value->property).readable);
    if ((frame.id & 0x1f) != 6) return;
    CanFrame again = encode_set(0, value->property, value->value, SetForm::Long);
    again.id = frame.id;
    const auto second = decode_reply(again);
    demand(second && std::get<ValueReply>(*second).value == value->value);
  } else if (const auto* position = std::get_if<PositionReply>(&*reply)) {
    demand(position->motor >= -2'097'152 && position->motor <= 2'097'151);
    const auto angles = finger_angles(position->motor, position->joint);
    demand(std::isfinite(angles.inner_rad) && std::isfinite(angles.outer_rad));
  } else if (const auto* row = std::get_if<TactileRow>(&*reply)) {
    demand(row->row < kTactileRows);
    for (const auto cell : row->cells) demand(cell < 4096);
  } else if (const auto* top = std::get_if<TactileTop>(&*reply)) {
    demand(std::count_if(top->cells.begin(), top->cells.end(), [](auto c) { return c != 0; }) <= 10);
    demand(pad_force_n(top->puck, top->cells) >= 0.0);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  CanHealth health;
  health.state = CanHealth::State::Active;
  // frames of eleven bytes: identifier, length, data
  for (std::span<const std::uint8_t> left(data, size); left.size() >= 3;) {
    CanFrame frame;
    frame.id = static_cast<std::uint16_t>(left[0] << 8 | left[1]);
    frame.length = left[2];
    left = left.subspan(3);
    const std::size_t n = std::min<std::size_t>(left.size(), 8);
    std::copy_n(left.begin(), n, frame.data.begin());
    judge(frame);
    note_can_error(frame.id | static_cast<std::uint32_t>(frame.length) << 16, left.first(n), health);
    left = left.subspan(n);
  }
  return 0;
}
