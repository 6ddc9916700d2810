#pragma once

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <memory>
#include <vector>

#include "control/arm/setpoint_generator.hpp"

namespace colift::control::test {

using hal::ImpedanceCommand;
using hal::JointVector;
using planner::Trajectory;

inline const hal::RobotModel& robot() {
  return hal::built_in_robot();
}

inline JointVector home() {
  return (JointVector() << 0.3, 0.6, -0.2, -1.3, 0.4, 0.9, -0.5).finished();
}

inline JointVector there() {
  return (JointVector() << -0.5, 0.9, 0.3, -0.7, -0.2, 1.2, 0.4).finished();
}

inline JointVector beyond() {
  return there() + (JointVector() << 0.3, -0.4, 0.5, -0.3, 0.6, -0.5, 0.2).finished();
}

inline std::shared_ptr<const Trajectory> way(std::vector<JointVector> path) {
  auto made = planner::make_trajectory(path, planner::MotionLimits{}, 0.0);
  REQUIRE(made);
  return std::make_shared<const Trajectory>(*made);
}

/// How far q is from the nearest point of the way (rad).
inline double off_path(const Trajectory& t, const JointVector& q) {
  const auto off = [&](double s) { return (t.sample(s).q_rad - q).norm(); };
  double best_s = 0.0;
  for (double s = 0.0; s <= t.duration_s(); s += 0.01)
    if (off(s) < off(best_s)) best_s = s;
  for (double step = 0.01; step > 1e-9;) {
    const double better = off(best_s - step) < off(best_s + step) ? best_s - step : best_s + step;
    if (off(better) < off(best_s))
      best_s = better;
    else
      step *= 0.5;
  }
  return off(best_s);
}

/// An arm that is where it was commanded one cycle ago, and a strict look at every command.
struct Rig {
  double period_s = 0.001;
  TaskConfig task;
  SetpointLimits limits;
  SetpointGenerator cycle{robot(), task, limits};
  hal::ArmState state;
  ImpedanceCommand last;
  JointVector v = JointVector::Zero();
  double fastest = 0.0, hardest = 0.0;

  Rig() {
    state.may_command = true;
    state.q_rad = home();
    step();
  }

  void step() {
    state.measured_at += hal::Timestamp(static_cast<std::int64_t>(period_s * 1e9 + 0.5));
    const std::uint32_t starts = cycle.starts();
    const ImpedanceCommand c = cycle.step(state);
    REQUIRE(c.q_rad.allFinite());
    if (cycle.starts() == starts && state.may_command) {
      const JointVector now = (c.q_rad - last.q_rad) / period_s;
      fastest = std::max(fastest, now.cwiseAbs().maxCoeff());
      hardest = std::max(hardest, ((now - v) / period_s).cwiseAbs().maxCoeff());
      v = now;
    } else {
      v.setZero();
    }
    last = c;
    state.q_rad = c.q_rad;
  }

  void steps(int n) {
    for (int i = 0; i < n; ++i) step();
  }

  /// Steps until done; returns the time that it took (s).
  double run(double most_s = 20.0) {
    double t = 0.0;
    do {
      step();
      t += period_s;
    } while (!cycle.done() && t < most_s);
    CHECK(cycle.done());
    return t;
  }
};

inline const double kNan = std::numeric_limits<double>::quiet_NaN();
}  // namespace colift::control::test
