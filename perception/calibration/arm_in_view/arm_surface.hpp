#pragma once

#include <vector>

#include "hal/robot_model/robot_model.hpp"

namespace colift::perception {

/// Surface of arm and hand in one posture, from the solids of the robot model, in the arm's base frame B.
/// Immutable after construction.
class ArmSurface {
 public:
  ArmSurface(const hal::RobotModel& robot, const hal::JointVector& q_rad, const hal::HandPosture& hand);

  struct Nearest {
    double distance_m = 1e9;                  ///< To the surface, negative inside.
    hal::Vec3 normal_B = hal::Vec3::UnitZ();  ///< Of the surface there, outwards, unit.
    int body = -1;                            ///< 0 to bodies() - 1.
  };
  [[nodiscard]] Nearest nearest(const hal::Vec3& p_B) const;

  /// Box around the middles of all solids, padded on all sides (m).
  [[nodiscard]] hal::Aabb around(double padding_m) const;
  /// Links of the arm with solids, and the hand, which counts as one.
  [[nodiscard]] int bodies() const { return bodies_; }

 private:
  struct Solid {
    hal::LinkShape::Kind kind;
    hal::Pose X_SB;
    hal::Vec3 half;  // box: half lengths; cylinder: radius, half length; sphere: radius
    hal::Vec3 middle_B;
    double radius_m;  // of a sphere around it
    int body;
  };
  static double distance_to(const Solid& solid, const hal::Vec3& p_B, hal::Vec3& normal_B);

  std::vector<Solid> solids_;
  int bodies_ = 0;
};

}  // namespace colift::perception
