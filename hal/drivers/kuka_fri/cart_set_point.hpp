#pragma once

#include "hal/drivers/kuka_fri/joint_set_point.hpp"
#include "hal/types/geometry.hpp"

namespace colift::hal {

using SixVector = Eigen::Matrix<double, 6, 1>;

/// x y z rx ry rz from the wire's X Y Z Rz Ry Rx, and back.
[[nodiscard]] SixVector from_wire_order(const FriSix& v);
[[nodiscard]] FriSix to_wire_order(const SixVector& v);
/// A frame of the wire as a pose, and back. The rotation is taken as it is.
[[nodiscard]] Pose from_wire_frame(const FriFrame& f);
[[nodiscard]] FriFrame to_wire_frame(const Pose& p);

/// The frame that goes over the wire in Cartesian impedance control. Outside of command mode it is the
/// measured one of the same datagram: what the controller asks for at its start.
class CartSetPoint {
 public:
  struct Limits {
    double velocity_m_s = 0.5, velocity_rad_s = 1.5;
    double acceleration_m_s2 = 1.0, acceleration_rad_s2 = 3.0;  ///< Of stops.
  };
  explicit CartSetPoint(const Limits& limits) : limits_(limits) {}

  void mirror(const FriFrame& measured);
  /// The next command is a first one; `measured` is where it has to be.
  void expect_first(const FriFrame& measured);
  /// `X`: of the tool in the base that `$STIFFNESS` names. `period_s`: the shortest that a cycle may be.
  FriLimit command(const Pose& X, int steps, double period_s, double safety_limits);
  void repeat();
  void brake(double period_s);

  [[nodiscard]] const FriFrame& wire() const { return wire_; }
  [[nodiscard]] bool at_rest() const { return by_.isZero() && turn_.isZero(); }

 private:
  Limits limits_;
  FriFrame wire_{};
  Pose X_ = Pose::Identity(), first_X_ = Pose::Identity();
  Vec3 by_ = Vec3::Zero(), turn_ = Vec3::Zero();  ///< The last cycle's step (m, rad), in the base.
  bool first_ = false;
};

}  // namespace colift::hal
