#pragma once

#include <span>
#include <vector>

#include "hal/types/result.hpp"
#include "planner/load_sharing/load_sharing.hpp"

namespace colift::planner {

/// One of those who carry: a person or a robot, at a grasp point relative to the centre of gravity (m).
struct CarryingAgent {
  Vec3 position = Vec3::Zero();
  double force_weight = 1.0;              ///< Of |f|^2; a strong agent is cheap.
  double omega_per_m = kHandOmega_per_m;  ///< Price of torque against force; above 0.
};

/// Load sharing of thesis eq. 4.5 for any number of agents: minimise the sum of
/// price_i (|f_i|^2 + omega_i^2 |tau_i|^2) so that all together exert the task wrench.
///
/// With a_i = 1/price_i, b_i = a_i/omega_i^2, A and B their sums, p the mean of the positions weighted by
/// a_i, q_i = p_i - p, and m the multiplier of the torque balance:
///   f_i = a_i (F/A + m x q_i),   tau_i = b_i m,   (sum a_i (|q_i|^2 1 - q_i q_i^T) + B 1) m = T - p x F,
/// so any number of agents costs one symmetric 3 x 3 solve. For two agents it is LoadSharing.
class SeveralAgents {
 public:
  /// Errors: BadInput (no agent, prices or omegas that are not positive and finite; positions not finite).
  [[nodiscard]] static hal::Result<SeveralAgents> create(std::vector<CarryingAgent> agents);

  /// Smallest cost of the tasks, one wrench per pose (about the centre of gravity).
  [[nodiscard]] double cost(std::span<const Wrench> tasks) const;
  /// What each agent does, about his own grasp point. `out` is as long as agents().
  void wrenches(const Wrench& task, std::span<Wrench> out) const;
  /// Part of the task's force that an agent bears, along it.
  [[nodiscard]] double share(std::size_t agent, const Wrench& task) const;

  [[nodiscard]] std::span<const CarryingAgent> agents() const { return agents_; }
  /// The same with one agent elsewhere.
  void move(std::size_t agent, const Vec3& position);

 private:
  explicit SeveralAgents(std::vector<CarryingAgent> agents);
  void renew();

  std::vector<CarryingAgent> agents_;
  double give_force_ = 0.0, give_torque_ = 0.0;  ///< A and B.
  Vec3 middle_ = Vec3::Zero();
  Eigen::Matrix3d inverse_ = Eigen::Matrix3d::Zero();  ///< Of the matrix above.
};

}  // namespace colift::planner
