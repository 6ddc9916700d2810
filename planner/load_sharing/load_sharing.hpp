#pragma once

#include <span>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"

namespace colift::planner {

using hal::Vec3;
using hal::Wrench;

/// Torque weight of `fast` (1/m): one over the effective contact radius of a hand, about 5 cm for a person's
/// hand and for the BH8-282. With the thesis's 1 /m, torque is as cheap as force on a 1 m lever and the
/// ranking is flat.
inline constexpr double kHandOmega_per_m = 20.0;

/// Coefficients of thesis eq. 4.5: |f1|^2 + omega1^2 |tau1|^2 + epsilon^2 |f2|^2 + epsilon^2 omega2^2
/// |tau2|^2. Agent 1 is the partner, agent 2 the robot.
struct SharingWeights {
  double epsilon = 1.0;  ///< Price of the robot's effort against the partner's; below 1 it takes more.
  double omega1_per_m =
      kHandOmega_per_m;  ///< Price of the partner's torque against force; 0 = torque is free.
  double omega2_per_m = kHandOmega_per_m;  ///< The same for the robot.

  /// Thesis chapter 4 and 6: all coefficients one (section 4.3, with metres).
  [[nodiscard]] static constexpr SharingWeights thesis() { return {1.0, 1.0, 1.0}; }

  template <class Visitor>
  void visit(Visitor& v) {
    v("epsilon", epsilon, hal::kPositive,
      "Cost of the robot's effort relative to the partner's; 1 shares equally.");
    v("omega1_per_m", omega1_per_m, hal::kNotNegative,
      "Cost of the partner's torque relative to force (1/m); 0 is free.");
    v("omega2_per_m", omega2_per_m, hal::kNotNegative,
      "Cost of the robot's torque relative to force (1/m); 0 is free.");
  }
};

/// Weights are accepted within these bounds (omegas also at 0), so that no square of them leaves the doubles.
inline constexpr double kSmallestWeight = 1e-70;
inline constexpr double kLargestWeight = 1e70;

/// The epsilon with which the robot carries the fraction `share` of a load lifted at its best place:
/// sqrt(1/share - 1). Errors: BadInput unless 0 < share < 1 (at either end one agent's effort would be free).
[[nodiscard]] hal::Result<double> epsilon_for_share(double share);

/// What each agent does to the object. Torques are about each agent's own grasp point.
struct AgentWrenches {
  Wrench partner;
  Wrench robot;
};

/// The quadratic program of thesis 4.4 in closed form; the derivation is docs/decisions/0002.
/// Positions are relative to the centre of gravity (m); the task wrench is taken about it (N, N m).
/// Costs are those of eq. 4.5, without the 1/2 of 4.7. All functions are pure, allocate nothing and run in
/// any thread.
class LoadSharing {
 public:
  /// Errors: BadInput for a weight that is negative, not finite or out of bounds, and for epsilon 0
  /// (the robot's effort would be free, and every grasp as good as any other).
  [[nodiscard]] static hal::Result<LoadSharing> create(const SharingWeights& weights);

  /// Smallest cost of one pose.
  [[nodiscard]] double cost(const Vec3& p_partner, const Vec3& p_robot, const Wrench& task) const {
    return force_weight_ * task.force.squaredNorm() + torque_cost(lever(p_partner, p_robot), task);
  }

  /// Smallest cost of a sequence of poses, each with its own wrench (eq. 4.6).
  [[nodiscard]] double cost(const Vec3& p_partner, const Vec3& p_robot, std::span<const Wrench> tasks) const;

  /// The wrenches that reach cost(). Where neither agent's torque costs anything, they are not unique; then
  /// torque is split as force is, which is the limit of equal omegas going to zero.
  [[nodiscard]] AgentWrenches wrenches(const Vec3& p_partner, const Vec3& p_robot, const Wrench& task) const;

  /// cost() of many robot positions at once, given as three arrays. All spans have the same length.
  void costs(const Vec3& p_partner, std::span<const double> x_m, std::span<const double> y_m,
             std::span<const double> z_m, std::span<const Wrench> tasks, std::span<double> out) const;

  /// Cost of given wrenches by eq. 4.5, whether or not they are the best.
  [[nodiscard]] double cost_weight(const AgentWrenches& w) const;

  /// The robot position without torque for a pure lift: on the line from the partner through the centre of
  /// gravity.
  [[nodiscard]] Vec3 best_robot_position(const Vec3& p_partner) const {
    return -(epsilon_ * epsilon_) * p_partner;
  }

  [[nodiscard]] double epsilon() const { return epsilon_; }
  /// Part of the task force that each agent takes where no lever asks for more.
  [[nodiscard]] double partner_part() const { return partner_part_; }
  [[nodiscard]] double robot_part() const { return robot_part_; }
  /// Torque per unit of multiplier, 1/omega1^2 and 1/(epsilon omega2)^2 (infinite where torque is free), and
  /// their sum.
  [[nodiscard]] double partner_give() const { return partner_give_; }
  [[nodiscard]] double robot_give() const { return robot_give_; }
  [[nodiscard]] double give() const { return give_; }

 private:
  struct Lever {
    Vec3 middle;        ///< Where a shared force acts: weighted mean of both positions.
    Vec3 arm;           ///< From the robot to the partner.
    double inv_across;  ///< One over the resistance to a torque across the arm; 0 where torque is free.
  };

  explicit LoadSharing(const SharingWeights& weights);

  [[nodiscard]] Lever lever(const Vec3& p1, const Vec3& p2) const {
    const Vec3 arm = p1 - p2;
    return {partner_part_ * p1 + robot_part_ * p2, arm, 1.0 / (robot_part_ * arm.squaredNorm() + give_)};
  }

  // spelled out: gcc 12 packs Eigen's three-vectors into pairs and back, which costs as much as the sum
  // itself
  [[nodiscard]] double torque_cost(const Lever& l, const Wrench& task) const {
    const double fx = task.force.x(), fy = task.force.y(), fz = task.force.z();
    const double cx = l.middle.x(), cy = l.middle.y(), cz = l.middle.z();
    const double rx = task.torque.x() - (cy * fz - cz * fy), ry = task.torque.y() - (cz * fx - cx * fz),
                 rz = task.torque.z() - (cx * fy - cy * fx);
    const double along = l.arm.x() * rx + l.arm.y() * ry + l.arm.z() * rz;
    return (rx * rx + ry * ry + rz * rz + stiffness_ratio_ * along * along) * l.inv_across;
  }

  double epsilon_, omega1_, omega2_;
  double partner_part_,
      robot_part_;       // u/(u+v), v/(u+v) with u = 1, v = 1/epsilon^2; mu = u v/(u+v) is robot_part_ too
  double force_weight_;  // 1/(u+v)
  double partner_give_, robot_give_, give_;
  double stiffness_ratio_;      // mu/s
  double partner_torque_part_;  // the partner's part of the torque that forces leave over
};

}  // namespace colift::planner
