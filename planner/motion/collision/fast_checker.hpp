#pragma once

#include <memory>

#include "hal/robot_model/robot_model.hpp"
#include "planner/motion/collision/collision_spheres.hpp"
#include "planner/motion/collision/touch.hpp"

namespace colift::planner {

struct CollisionScene;

/// Conservative and fast: spheres against distance fields, self collision by sphere pairs, joint limits. Base
/// links, which do not move, meet nothing but the robot itself; the link that A1 turns does not meet the
/// ground. Keeps buffers: one checker, one thread.
class FastChecker {
 public:
  FastChecker(const hal::RobotModel& model, const SphereModel& spheres,
              std::shared_ptr<const CollisionScene> scene);
  ~FastChecker();
  FastChecker(FastChecker&&) noexcept;

  /// Posture of the hand for what follows (all fingers at 0 by default), and what it may touch.
  void set_hand(const hal::HandPosture& hand);
  void allow(Contacts contacts);
  /// For Carrying: where the palm holds the target, in W, before the lift. Places where the target touches
  /// something there are excused as long as they only rise.
  void set_carry_origin(const hal::Pose& X_WH);

  [[nodiscard]] bool is_free(const hal::JointVector& q_rad);
  /// The straight motion between two joint positions, ends included, at steps of at most `step_rad` in any
  /// joint; batched, the middle first. False as soon as one is not free.
  [[nodiscard]] bool is_free(const hal::JointVector& from, const hal::JointVector& to, double step_rad);
  /// The worst thing that is touched, for words. Nothing exactly where is_free() is true.
  [[nodiscard]] Touch what_touches(const hal::JointVector& q_rad);
  [[nodiscard]] std::size_t checks() const;  ///< States looked at so far.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::planner
