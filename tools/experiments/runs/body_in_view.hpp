#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "sim_hal/mujoco/sim_world.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::experiments {

/// How much of the scenario's people the camera truly sees, and how fast the robot was when it first touched
/// one of them. From the world alone; a body behind the object, the robot or the image's border is not in
/// view. One thread.
class BodyInView {
 public:
  /// Pixels of 160 x 120 that have to show him: 160 of a whole depth image, a forearm at 2.5 m.
  static constexpr int kMinPixels = 10;

  explicit BodyInView(const sim_hal::SimWorld& world);

  /// Once for each frame: counts.
  void frame(const sim_hal::SimWorld& world);
  /// Once for each millisecond: finds the first touch.
  void tick(const sim_hal::TickReport& report);

  /// Of the robot with one of the scenario's people (s of the scenario); unset: none.
  [[nodiscard]] std::optional<double> touched_s() const { return touched_s_; }
  /// Fastest joint of the arm (rad/s) just before that, or before he pushed it through what it holds.
  [[nodiscard]] double joint_rad_s() const { return joint_rad_s_; }
  /// The arm was at rest then: slower than 0.02 rad/s; or than 0.05 rad/s, and its set point had been still
  /// for 0.1 s, so that it only swayed with what it holds.
  [[nodiscard]] bool rested() const { return rested_; }
  /// Pixels that showed him in the frame at or before a time; 0 without one.
  [[nodiscard]] int pixels_at(double t_s) const;

 private:
  struct Count {
    double t_s = 0.0;
    int pixels = 0;
  };
  sim_hal::RayCaster camera_;
  std::vector<Count> counts_;
  std::optional<double> touched_s_;
  double joint_rad_s_ = 0.0, last_rad_s_ = 0.0;
  double pushed_s_ = -INFINITY, before_rad_s_ = 0.0;  // last touch of robot or held object; speed before it
  bool rested_ = false;
  double driven_s_ = 0.0;  // its set point moved last
  hal::JointVector set_point_rad_ = hal::JointVector::Zero();
};

}  // namespace colift::experiments
