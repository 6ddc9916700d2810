#pragma once

#include <vector>

#include "hal/types/geometry.hpp"
#include "planner/motion/collision/distance_field.hpp"

namespace colift::planner {

struct CollisionScene;

/// The target's cells as they move with the hand. What a cell touched before the lift (what the target stands
/// on or leans against) is excused while the cell has only risen.
class CarriedTarget {
 public:
  /// The scene has to outlive it.
  explicit CarriedTarget(const CollisionScene& scene);
  void set_origin(const hal::Pose& X_WH);

  /// Motion from the pose of the palm now back to the one before the lift.
  [[nodiscard]] Eigen::Isometry3f before_lift(const Eigen::Isometry3f& X_WH) const {
    return X_WH_before_ * X_WH.inverse();
  }
  /// By how much the worst cell comes too near to an obstacle or goes down to the ground (m); 0: nothing.
  [[nodiscard]] float depth_m(const Eigen::Isometry3f& X_WH) const;

 private:
  const CollisionScene& scene_;
  Eigen::Isometry3f X_WH_before_ = Eigen::Isometry3f::Identity();
  float cover_m_ = 0.0f;        // half the diagonal of a cell
  std::vector<bool> touching_;  // before the lift, by cell
};

}  // namespace colift::planner
