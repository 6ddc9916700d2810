#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "fake_krc.hpp"
#include "hal/drivers/kuka_fri/fri_driver.hpp"

namespace colift::test {

using hal::ErrorCode;
using hal::FriDrop;
using hal::FriReason;
using hal::FriSession;
using hal::JointVector;

inline constexpr double kT = 0.002;

/// A driver in command mode whose user moves A1 and A4 to and fro, from the measured pose, as a good user
/// does: one period's step for each state, anew from the measured pose whenever commands were not allowed.
struct Moving {
  FakeKrc krc;
  std::unique_ptr<hal::FriArm> arm;
  JointVector q = JointVector::Zero();
  double phase = 0.0, speed = 0.2;
  bool running = false;
  int timeouts = 0, refusals = 0, allowed = 0, lost = 0;

  explicit Moving(const hal::FriConfig& config = FakeKrc::quick()) {
    arm = krc.arm(config);
    REQUIRE(arm->configure());
    REQUIRE(arm->activate());
    cycles(50);
  }
  ~Moving() {
    krc.tamper = nullptr;  // what they refer to is gone before the arm is
    krc.after = nullptr;
  }

  void cycles(int n) {
    for (int i = 0; i < n; ++i) cycle();
  }
  void cycle() {
    const auto s = arm->wait_cycle();
    if (!s) {
      timeouts += s.error().code == ErrorCode::Timeout;
      lost += s.error().code == ErrorCode::LinkLost;
      CHECK(s.error().where.size() <= 15);
      CHECK(s.error().detail.size() <= 15);
      if (s.error().code != ErrorCode::Timeout) running = false;
      return;
    }
    if (!s->may_command) {
      running = false;
      return;
    }
    ++allowed;
    if (!running) {
      q = s->q_rad;
      phase = 0.0;
      running = true;
    } else {
      phase += kT;
      const double v = speed * std::min(1.0, phase / 0.1);
      q[0] += v * std::sin(3.0 * phase) * kT;
      q[3] += v * kT * std::sin(2.0 * phase);
    }
    hal::ImpedanceCommand c;
    c.q_rad = q;
    if (!arm->command(c)) ++refusals;
  }
  void note_device(int n) {
    krc.silent = true;
    const auto until = krc.clock.now() + std::chrono::nanoseconds(static_cast<std::int64_t>(n * kT * 1e9));
    while (krc.clock.now() < until) cycle();
    krc.silent = false;
  }
  [[nodiscard]] FriReason reason() const { return arm->status().reason; }
};

inline std::vector<std::byte> good_bytes(const hal::FriMeasurement& m) {
  std::vector<std::byte> bytes(hal::kFriMeasurementBytes);
  hal::encode(m, std::span<std::byte, hal::kFriMeasurementBytes>(bytes));
  return bytes;
}

}  // namespace colift::test
