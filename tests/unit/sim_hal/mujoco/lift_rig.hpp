#pragma once

#include <functional>
#include <memory>

#include "hal/robot_model/robot_model.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// A pose of the hand by where it looks (Hz) and closes (Hy), both unit vectors in W.
[[nodiscard]] Pose hand_at(const Vec3& p_W, const Vec3& approach, const Vec3& closing);

/// Joint positions that put the palm there, found numerically from many starts; fails the test when there
/// are none within the limits.
[[nodiscard]] hal::JointVector reach(const Pose& X_WH);

/// A world whose hand is led along straight lines by joint commands every 5 ms, as a client of the arm does
/// it.
class LiftRig {
 public:
  LiftRig(const Scenario& scenario, const Pose& X_WH_start, std::uint64_t seed = 1);

  SimWorld& world() { return *world_; }
  /// To a pose in a time (min-jerk), with `load_n` that the arm is to bear at the end; commanded ahead as
  /// J^T f.
  void move(const Vec3& p_W, double time_s, double load_n = 0.0);
  /// The same, with a look at the world after every millisecond.
  void move_watched(const Vec3& p_W, double time_s, std::function<void()> each_ms);
  void wait(double time_s);
  /// Closes until the hand says that it has ended; false after 4 s.
  bool close(double torque_nm = 0.75);
  /// Mean of the truth over a time while the arm holds still; forces and torques only.
  SimTruth mean(double time_s);

 private:
  void cycle();

  std::unique_ptr<SimWorld> world_;
  hal::ImpedanceCommand command_;
  Pose X_WH_;
  double load_n_ = 0.0;
  std::function<void()> each_ms_;
};

/// The built-in robot's scene: a table of 0.8 x 0.6 x 0.45 m, 4 kg, whose near edge is at x = 0.8 m, and a
/// partner at the middle of the far one.
[[nodiscard]] Scenario table_scenario();
/// The hand before and around that edge, F1 and F2 below.
[[nodiscard]] Pose before_edge();
[[nodiscard]] Vec3 around_edge();

}  // namespace colift::sim_hal
