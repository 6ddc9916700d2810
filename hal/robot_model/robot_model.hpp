#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/hand.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/joints.hpp"
#include "hal/types/result.hpp"

namespace colift::hal {

/// A solid of a link in the link's frame L. Sizes: box = full lengths x, y, z; cylinder = radius, length
/// along Sz, unused; sphere = radius, unused, unused.
struct LinkShape {
  enum class Kind { Box, Cylinder, Sphere };
  Kind kind = Kind::Box;
  Pose X_LS = Pose::Identity();
  Vec3 size = Vec3::Zero();
};

/// A rigid body and the joint that carries it.
struct RobotLink {
  std::string name, joint;
  int parent = -1;                ///< Index of the parent link; -1: fixed to W.
  Pose X_PL0 = Pose::Identity();  ///< Pose of L in the parent at joint position 0.
  bool revolute = false;          ///< Else fixed.
  Vec3 axis = Vec3::UnitZ();      ///< In L, unit vector.
  double lower_rad = 0, upper_rad = 0, velocity_rad_s = 0, effort_nm = 0;
  double mass_kg = 0;
  Vec3 com_m = Vec3::Zero();                          ///< Centre of mass in L.
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< About the centre of mass, axes of L (kg m^2).
  std::vector<LinkShape> shapes;                      ///< Collision geometry.
};

/// Joint positions of the hand: inner and outer joint of F1 to F3, and the spread of F1 and F2 (rad).
struct HandPosture {
  std::array<double, kFingers> inner_rad{}, outer_rad{};
  double spread_rad = 0.0;
};
[[nodiscard]] HandPosture posture_of(const HandState& state);
/// Fingers at `inner_rad` with the outer links at a third of it, as the gears drive them before breakaway.
[[nodiscard]] HandPosture coupled_posture(double inner_rad, double spread_rad = 0.0);

/// Arm and hand as read from the one URDF: what simulation, planning and the self filter all use. Frames: W =
/// base of the robot, z up, floor at z = 0; F = flange; H = hand as planner/hand/hand_model.hpp says.
struct RobotModel {
  std::string name;
  std::vector<RobotLink> links;       ///< Parents before children.
  std::array<int, kArmJoints> arm{};  ///< Links carried by A1 to A7.
  int flange = -1;                    ///< Link F (fixed to A7's link).
  int palm = -1;                      ///< Link whose frame is H.
  int hand_base = -1;                 ///< First link that belongs to the hand.
  std::array<int, kFingers> inner{}, outer{};
  std::array<int, 2> spread{};  ///< Links turned by the spread: roots of F1 and F2.
  Pose X_FH = Pose::Identity();

  [[nodiscard]] bool in_hand(int link) const { return in_hand_[static_cast<std::size_t>(link)]; }
  /// For each link.
  std::vector<bool> in_hand_;
  /// For each link, which position turns it: -1 none, A1 to A7 from 0, then inner, outer, spread joints.
  std::vector<int> turned_by_;
  /// Links from the root to the palm.
  std::vector<int> palm_chain_;

  [[nodiscard]] JointVector lower_rad() const;
  [[nodiscard]] JointVector upper_rad() const;
  [[nodiscard]] JointVector velocity_rad_s() const;
  [[nodiscard]] JointVector effort_nm() const;
};

/// Reads a URDF. Errors: BadInput (file, XML with line), BadConfig (joints missing that the LWR with a
/// BarrettHand has, no limits, masses not positive, shapes that are meshes).
[[nodiscard]] Result<RobotModel> load_robot(const std::filesystem::path& file);
/// The same from text; `name` stands in errors.
[[nodiscard]] Result<RobotModel> parse_robot(const std::string& urdf, const std::string& name);
/// config/robot/lwr_bhand.urdf, compiled in.
[[nodiscard]] const RobotModel& built_in_robot();

/// Pose of every link in W. `X_WL` is resized once and then reused.
void link_poses(const RobotModel& model, const JointVector& q_rad, const HandPosture& hand,
                std::vector<Pose>& X_WL);
/// Pose of the palm frame H in W.
[[nodiscard]] Pose hand_pose(const RobotModel& model, const JointVector& q_rad);
/// Geometric Jacobian of a point fixed to the hand, p in H: rows linear (m/rad), then angular, in W.
using ArmJacobian = Eigen::Matrix<double, 6, kArmJoints>;
[[nodiscard]] ArmJacobian jacobian(const RobotModel& model, const JointVector& q_rad, const Vec3& p_H);

}  // namespace colift::hal
