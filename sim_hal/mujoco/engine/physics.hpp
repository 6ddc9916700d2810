#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/mujoco/hand_drive.hpp"

namespace colift::sim_hal {

using hal::Pose;
using hal::Vec3;

/// The arm as its controller sees it.
struct ArmReading {
  hal::JointVector q_rad, dq_rad_s;
  hal::JointVector bias_nm;      ///< Gravity, Coriolis and centrifugal torque.
  hal::JointVector inertia;      ///< Diagonal of the mass matrix (kg m^2).
  hal::JointVector external_nm;  ///< Of contacts on arm and hand (not of joint limits), in the step before.
};

/// Sums over the contacts of the last step.
struct ContactReading {
  Vec3 robot_force_W = Vec3::Zero(), robot_torque_W = Vec3::Zero();  ///< Hand on object; about the palm.
  Vec3 static_force_W = Vec3::Zero();                                ///< Floor and clutter on object.
  Vec3 support_force_W = Vec3::Zero();                               ///< Support block on object.
  std::optional<Vec3> grip_W;  ///< Middle of the hand's contacts on the object, weighted by their force.
  bool robot_touches_object = false;
  bool robot_hit = false;  ///< Arm on anything, palm on anything but the object, or anything on a person.
  std::array<double, hal::kFingers> strain_nm{}, tip_force_n{}, link_force_n{};
};

/// How deep things stand in each other before anything moved (m), 0 when nowhere.
struct Overlap {
  double object_static_m = 0.0, robot_object_m = 0.0, robot_static_m = 0.0;
};

/// MuJoCo behind a narrow door: the generated model, its state, steps of 1 ms.
class Physics {
 public:
  /// Errors: BadConfig with MuJoCo's words when it refuses the model.
  [[nodiscard]] static hal::Result<std::unique_ptr<Physics>> make(const std::string& xml,
                                                                  const hal::RobotModel& model,
                                                                  const hal::JointVector& q_rad);
  ~Physics();
  Physics(const Physics&) = delete;
  Physics& operator=(const Physics&) = delete;

  void read(ArmReading& arm, HandReading& hand) const;
  void set_torque(const hal::JointVector& arm_nm, const HandTorque& hand);
  /// Force at a point and torque on the object; replaces the one before.
  void set_object_load(const Vec3& at_W, const Vec3& force_W, const Vec3& torque_W);
  /// Force at a point of a link, or of the object, in the coming step alone: of a person. `normal_n` is what
  /// a finger's pads measure of it (N, positive).
  void push_link(int link, const Vec3& at_W, const Vec3& force_W, double normal_n);
  void push_object(const Vec3& at_W, const Vec3& force_W);
  /// Somebody's force on a link of the arm or on the palm, at its origin, in the coming step alone, without a
  /// body that touches.
  void pull_link(int link, const Vec3& force_W);
  /// 1 ms: contact forces and acceleration under these loads, the new state, and all that follows from it.
  void step();
  /// Contacts of the step that has just ended.
  [[nodiscard]] const ContactReading& contacts() const;

  [[nodiscard]] Pose link_pose(int link) const;
  [[nodiscard]] Pose object_pose() const;
  [[nodiscard]] Vec3 object_velocity_W() const;  ///< Of the origin of T.
  [[nodiscard]] Vec3 object_turning_W() const;
  /// Of the point of a link, or of the object, that is there now (m/s).
  [[nodiscard]] Vec3 link_velocity_W(int link, const Vec3& at_W) const;
  [[nodiscard]] Vec3 object_velocity_W(const Vec3& at_W) const;

  void place_support(const Vec3& center_W);
  /// A piece of clutter that has moves.
  void place_clutter(std::size_t index, const Vec3& center_W);
  [[nodiscard]] Overlap overlap() const;
  /// Times that MuJoCo met numbers that cannot be (and reset the state) or had no room for contacts.
  [[nodiscard]] int divergences() const;

 private:
  struct Impl;
  explicit Physics(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::sim_hal
