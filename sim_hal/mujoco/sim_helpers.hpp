#pragma once

#include <array>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::sim_hal {

using hal::Pose;
using hal::Vec3;

/// People beside the partner who take the object off the robot's hand, and keep it where it is then: four
/// hands around the palm, each a spring with damping (1500 N/m, 80 Ns/m, at most 250 N). Within a second or
/// two they bear what the palm bore. They can pull it away from the hand.
class SimHelpers {
 public:
  static constexpr int kHands = 4;

  /// They take hold now, around the palm.
  void take(const Pose& X_WT, const Vec3& palm_W);
  /// From now on they move the object by this (W), with 0.1 m/s.
  void pull(const Vec3& by_W) { pull_W_ = by_W; }
  [[nodiscard]] bool hold() const { return !hands_.empty(); }

  struct Hand {
    Vec3 at_W, force_W;
  };
  /// One step of 1 ms: the forces on the object. `v_W` is the velocity of T's origin, `w_W` its turning;
  /// force and torque about the palm are those of the robot's hand on the object.
  [[nodiscard]] std::array<Hand, kHands> tick(const Pose& X_WT, const Vec3& v_W, const Vec3& w_W,
                                              const Vec3& robot_force_W, const Vec3& robot_torque_W);

 private:
  struct Place {
    Vec3 at_T, start_W, arm_W;  // where it holds; from the palm to it
    Vec3 borne_W = Vec3::Zero();
  };
  std::vector<Place> hands_;
  Vec3 pull_W_ = Vec3::Zero();  // what is left of it
};

}  // namespace colift::sim_hal
