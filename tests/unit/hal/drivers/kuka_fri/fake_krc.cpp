#include "fake_krc.hpp"

#include <algorithm>
#include <cmath>

namespace colift::test {

using hal::FriQuality;
using hal::FriState;

FakeKrc::FakeKrc(double period_s) : period_s_(period_s) {
  clock.advance(std::chrono::seconds(3));
  next_at_ = clock.now();
  m.state = FriState::Monitor;
  m.quality = FriQuality::Perfect;
  m.control = hal::FriControl::JointImpedance;
  m.power = 0x7F;
  m.measurement_period_s = m.command_period_s = static_cast<float>(period_s);
  m.safety_limits = 1.0f;
  m.answer_rate = 1.0f;
  m.temperature_c.fill(30.0f);
  m.cart_measured = m.cart_commanded = {1, 0, 0, 0.4f, 0, 1, 0, 0.1f, 0, 0, 1, 0.7f};
  end_ = wire.end(own);
  (void)end_->open();
}

std::unique_ptr<hal::DatagramLink> FakeKrc::link() {
  return wire.end(pc, [this](hal::Timestamp until) { return run(until); });
}

hal::FriConfig FakeKrc::quick() {
  hal::FriConfig c;
  c.script = "none";
  c.first_s = 0.5;
  c.ready_s = 2.0;
  c.script_s = 0.5;
  c.stop_s = 1.0;
  return c;
}

std::unique_ptr<hal::FriArm> FakeKrc::arm(const hal::FriConfig& config) {
  return std::make_unique<hal::FriArm>(config, link(), clock);
}

std::array<float, 7> FakeKrc::followed() const {
  std::array<float, 7> sum{};
  for (std::size_t i = 0; i < 7; ++i) sum[i] = krl_rad[i] + offset_rad[i];
  return sum;
}

void FakeKrc::command_mode() {
  m.state = FriState::Command;
  speed_.fill(0.0);
  missing_ = 0;
  flags_.reset();
}

void FakeKrc::monitor_mode() {
  m.state = FriState::Monitor;
  speed_.fill(0.0);
  good = 0;
  start_when_good = false;
}

void FakeKrc::reboot() {
  monitor_mode();
  send_ = reflect_ = 0;
  answered_.reset();
}

void FakeKrc::count_back(int by) {
  send_ = static_cast<std::uint16_t>(send_ - by);
}

void FakeKrc::hear() {
  std::array<std::byte, 512> bytes{};
  int count = 0;
  for (;;) {
    const hal::Datagram got = end_->receive(bytes, hal::Duration::zero());
    if (got.kind != hal::Datagram::Kind::Data) break;
    FriCommand c;
    if (deaf || hal::decode(std::span(bytes).first(got.size), c) != hal::FriRefusal::None) continue;
    if (answered_ && *answered_ == c.head.reflected) ++twice;
    answered_ = c.head.reflected;
    reflect_ = c.head.send;
    heard.push_back(c);
    ++count;
    if (told.empty()) continue;
    // judged by the datagram that it answers
    const auto question = std::find_if(
        told.rbegin(), told.rend(), [&](const FriMeasurement& t) { return t.head.send == c.head.reflected; });
    if (question == told.rend()) continue;
    const auto mirrors = [](const FriMeasurement& t) {
      return t.state != FriState::Command || (t.power & 0x7F) != 0x7F;
    };
    if (mirrors(*question)) {
      for (std::size_t i = 0; i < 7; ++i)
        not_mirrored += c.q_rad[i] != question->q_commanded_rad[i] + question->q_commanded_fri_rad[i];
      for (const float t : c.tau_nm) torque_outside += t != 0.0f;
      for (const float f : c.wrench) torque_outside += f != 0.0f;
      continue;
    }
    if (mirrors(m)) continue;
    if (flags_ && *flags_ != c.flags) ++flags_changed;
    flags_ = c.flags;
    for (std::size_t i = 0; i < 7; ++i) {
      const double step = static_cast<double>(c.q_rad[i]) - static_cast<double>(followed()[i]);
      worst_step_rad = std::max(worst_step_rad, std::abs(step));
      worst_dv_rad_s = std::max(worst_dv_rad_s, std::abs(step / period_s_ - speed_[i]));
      speed_[i] = step / period_s_;
      offset_rad[i] = c.q_rad[i] - krl_rad[i];
    }
  }
  good = count > 0 ? good + 1 : 0;
  missing_ = count > 0 ? 0 : missing_ + 1;
  if (count == 0 && m.state == FriState::Command && extrapolates) {
    if (missing_ > 3) speed_.fill(0.0);
    for (std::size_t i = 0; i < 7; ++i) offset_rad[i] += static_cast<float>(speed_[i] * period_s_);
  }
}

void FakeKrc::play_script() {
  if (!script_colift || heard.empty()) return;
  auto& to = m.krl.integer;
  const auto& from = heard.back().krl.integer;
  if (to[0] == 0) {
    to[3] = from[3];
    to[0] = 10001;
    to[1] = 1;
  }
  to[4] = from[4];
  if (to[1] == 3 && m.state != FriState::Command) {
    to[1] = 1;
    to[5] = 5;
  }
  if (from[3] != to[3]) {
    to[5] = 0;
    to[3] = from[3];
    if (from[1] == 1) {
      to[1] = 2;
      to[2] = from[2];
      script_wait_s_ = 0.0;
    } else if (from[1] == 2) {
      monitor_mode();
      to[1] = 1;
      to[5] = 1;
    }
  }
  if (to[1] != 2) return;
  script_wait_s_ += period_s_;
  if (m.quality >= FriQuality::Ok && good >= 100) {
    command_mode();
    to[1] = 3;
    to[5] = 1;
  } else if (script_wait_s_ > 5.0) {
    to[1] = 1;
    to[5] = 2;
  }
}

void FakeKrc::send() {
  ++send_;
  m.head.send = send_;
  m.head.reflected = reflect_;
  m.timestamp_s = static_cast<float>(hal::seconds(clock.now()));
  m.q_commanded_rad = krl_rad;
  m.q_commanded_fri_rad = offset_rad;
  if (!frozen)
    for (std::size_t i = 0; i < 7; ++i) m.q_measured_rad[i] = followed()[i] + sag_rad[i];
  FriMeasurement out = m;
  if ((tamper && !tamper(out)) || silent) return;
  told.push_back(out);
  std::vector<std::byte> bytes(hal::kFriMeasurementBytes);
  hal::encode(out, std::span<std::byte, hal::kFriMeasurementBytes>(bytes));
  (void)end_->send(pc, bytes);
  if (after) after(bytes);
}

bool FakeKrc::run(hal::Timestamp until) {
  if (next_at_ > until) {
    clock.advance(until - clock.now());
    return true;
  }
  if (next_at_ > clock.now()) clock.advance(next_at_ - clock.now());
  hear();
  play_script();
  if (!script_colift && start_when_good && m.state == FriState::Monitor && good >= 20) command_mode();
  send();
  next_at_ += std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 * period_s_));
  return true;
}

}  // namespace colift::test
