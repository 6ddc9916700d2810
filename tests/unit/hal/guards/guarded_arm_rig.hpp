#pragma once

#include <catch2/catch.hpp>
#include <chrono>
#include <limits>
#include <memory>
#include <optional>

#include "hal/guards/guarded_arm.hpp"
#include "judged_arm.hpp"

namespace guards {

inline constexpr double kPeriod_s = 0.005;

/// The error's code; nullopt when all went well.
template <class T>
std::optional<ErrorCode> code(const Result<T>& result) {
  if (result) return std::nullopt;
  return result.error().code;
}

/// A guarded arm on a judged wire, one cycle at a time.
struct Rig {
  GuardConfig config;
  Limits limits;
  JudgedArm* wire = nullptr;
  std::unique_ptr<GuardedArm> arm;
  ArmState state;

  explicit Rig(const GuardConfig& c = {}) : config(c), limits(built_in_robot(), c) {
    auto owned = std::make_unique<JudgedArm>(limits);
    wire = owned.get();
    arm = std::make_unique<GuardedArm>(std::move(owned), built_in_robot(), config);
    state.may_command = true;
    state.measured_at = std::chrono::hours(1);
    state.q_rad << 0.3, 0.5, -0.2, -1.1, 0.4, 0.7, -0.5;
    REQUIRE(arm->configure());
    REQUIRE(arm->activate());
  }

  Result<ArmState> cycle(double step_s = kPeriod_s) {
    state.measured_at += Timestamp(static_cast<std::int64_t>(step_s * 1e9 + 0.5));
    wire->state = state;
    return arm->wait_cycle();
  }

  Result<> send(const JointVector& q_rad) {
    ImpedanceCommand c;
    c.q_rad = q_rad;
    return arm->command(c);
  }

  /// The arm moves in A1 with this velocity, as a good caller lets it.
  void run_up_to(double velocity_rad_s) {
    REQUIRE(cycle());
    REQUIRE(send(state.q_rad));
    JointVector q = state.q_rad;
    for (double v = 0.0; v < velocity_rad_s;) {
      v = std::min(velocity_rad_s, v + 10.0 * kPeriod_s);
      q[0] += v * kPeriod_s;
      REQUIRE(cycle());
      REQUIRE(send(q));
      state.q_rad = q;
    }
  }

  void check_judge() const { CHECK(wire->broken == ""); }
};

inline const double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace guards
