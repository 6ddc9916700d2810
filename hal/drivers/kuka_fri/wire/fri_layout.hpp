#pragma once

#include "hal/drivers/kuka_fri/wire/fri_packets.hpp"

namespace colift::hal {

/// Hands every field with its byte offset to `field`: the table of both datagrams.
template <class Header, class Field>
constexpr void fri_head_layout(Header& h, Field& field) {
  field(0, h.send);
  field(2, h.reflected);
  field(4, h.size);
  field(6, h.id);
}

template <class Channels, class Field>
constexpr void fri_krl_layout(Channels& k, Field& field) {
  field(8, k.real);
  field(72, k.integer);
  field(136, k.boolean);
  field(138, k.fill);
}

/// `m` is a FriMeasurement, const or not.
template <class Measurement, class Field>
requires requires(Measurement& m) {
  m.q_measured_rad;
}
constexpr void fri_layout(Measurement& m, Field& field) {
  fri_head_layout(m.head, field);
  fri_krl_layout(m.krl, field);
  field(140, m.timestamp_s);
  field(144, m.state);
  field(146, m.quality);
  field(148, m.measurement_period_s);
  field(152, m.command_period_s);
  field(156, m.safety_limits);
  field(160, m.answer_rate);
  field(164, m.latency_s);
  field(168, m.jitter_s);
  field(172, m.miss_rate);
  field(176, m.misses);
  field(180, m.power);
  field(182, m.control);
  field(184, m.error);
  field(186, m.warning);
  field(188, m.temperature_c);
  field(216, m.q_measured_rad);
  field(244, m.cart_measured);
  field(292, m.q_commanded_rad);
  field(320, m.q_commanded_fri_rad);
  field(348, m.cart_commanded);
  field(396, m.cart_commanded_fri);
  field(444, m.tau_measured_nm);
  field(472, m.tau_external_nm);
  field(500, m.wrench_external);
  field(524, m.jacobian);
  field(692, m.mass_matrix);
  field(888, m.gravity_nm);
}

/// `c` is a FriCommand, const or not.
template <class Command, class Field>
requires requires(Command& c) {
  c.flags;
}
constexpr void fri_layout(Command& c, Field& field) {
  fri_head_layout(c.head, field);
  fri_krl_layout(c.krl, field);
  field(140, c.flags);
  field(144, c.q_rad);
  field(172, c.cart);
  field(220, c.tau_nm);
  field(248, c.wrench);
  field(272, c.stiffness_nm_rad);
  field(300, c.damping);
  field(328, c.cart_stiffness);
  field(352, c.cart_damping);
}

}  // namespace colift::hal
