#include "hal/os/can_error.hpp"

#include <linux/can/error.h>

namespace colift::hal {
namespace {

using State = CanHealth::State;

// what the controller says of its counters' levels, in byte 1
void note_level(std::uint8_t level, CanHealth& health) {
  if (level & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) {
    health.state = State::Passive;
  } else if (level & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) {
    health.state = State::Warning;
  } else if (level & CAN_ERR_CRTL_ACTIVE) {
    health.state = State::Active;
  }
  if (level & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) ++health.dropped;
}

}  // namespace

void note_can_error(std::uint32_t error_class, std::span<const std::uint8_t> data,
                    CanHealth& health) noexcept {
  ++health.error_frames;
  if (error_class & CAN_ERR_ACK) ++health.not_acknowledged;
  if (error_class & (CAN_ERR_PROT | CAN_ERR_TRX)) ++health.bus_errors;
  if (error_class & CAN_ERR_CRTL) {
    if (data.size() > 1)
      note_level(data[1], health);
    else if (health.state == State::Active)
      health.state = State::Warning;  // the class alone does not tell how bad it is
  }
  if (error_class & CAN_ERR_RESTARTED) health.state = State::Active;
  if (error_class & CAN_ERR_BUSOFF) {
    if (health.state != State::BusOff) ++health.bus_offs;
    health.state = State::BusOff;
  }
  // kernels before 6.0 send the counters without saying so
  if (data.size() > 7 && (error_class & (CAN_ERR_CRTL | 0x200U /* CAN_ERR_CNT */))) {
    health.send_errors = data[6];
    health.receive_errors = data[7];
  }
}

}  // namespace colift::hal
