#include "planner/load_sharing/several_agents.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <cassert>
#include <cmath>

namespace colift::planner {

hal::Result<SeveralAgents> SeveralAgents::create(std::vector<CarryingAgent> agents) {
  const auto refuse = [](std::string where, std::string detail) {
    return hal::failure(hal::ErrorCode::BadInput, std::move(where), std::move(detail));
  };
  if (agents.empty()) return refuse("agents", "there is none, expected at least one");
  for (std::size_t i = 0; i < agents.size(); ++i) {
    const CarryingAgent& a = agents[i];
    const std::string where = fmt::format("agents[{}]", i);
    for (const double cost_weight : {a.force_weight, a.omega_per_m})
      if (!(cost_weight >= kSmallestWeight && cost_weight <= kLargestWeight))
        return refuse(where, fmt::format("a weight is {}, expected {} to {}", cost_weight, kSmallestWeight,
                                         kLargestWeight));
    if (!a.position.allFinite()) return refuse(where, "its position is not a number");
  }
  return SeveralAgents(std::move(agents));
}

SeveralAgents::SeveralAgents(std::vector<CarryingAgent> agents) : agents_(std::move(agents)) {
  renew();
}

void SeveralAgents::renew() {
  give_force_ = give_torque_ = 0.0;
  middle_.setZero();
  for (const CarryingAgent& a : agents_) {
    give_force_ += 1.0 / a.force_weight;
    give_torque_ += 1.0 / (a.force_weight * a.omega_per_m * a.omega_per_m);
    middle_ += a.position / a.force_weight;
  }
  middle_ /= give_force_;
  Eigen::Matrix3d m = give_torque_ * Eigen::Matrix3d::Identity();
  for (const CarryingAgent& a : agents_) {
    const Vec3 q = a.position - middle_;
    m += (q.squaredNorm() * Eigen::Matrix3d::Identity() - q * q.transpose()) / a.force_weight;
  }
  inverse_ = m.inverse();
}

double SeveralAgents::cost(std::span<const Wrench> tasks) const {
  double sum = 0.0;
  for (const Wrench& task : tasks) {
    const Vec3 rest = task.torque - middle_.cross(task.force);
    sum += task.force.squaredNorm() / give_force_ + rest.dot(inverse_ * rest);
  }
  return sum;
}

void SeveralAgents::wrenches(const Wrench& task, std::span<Wrench> out) const {
  assert(out.size() == agents_.size());
  const Vec3 multiplier = inverse_ * (task.torque - middle_.cross(task.force));
  for (std::size_t i = 0; i < agents_.size(); ++i) {
    const CarryingAgent& a = agents_[i];
    const double give = 1.0 / a.force_weight;
    out[i].force = give * (task.force / give_force_ + multiplier.cross(a.position - middle_));
    out[i].torque = give / (a.omega_per_m * a.omega_per_m) * multiplier;
  }
}

double SeveralAgents::share(std::size_t agent, const Wrench& task) const {
  const CarryingAgent& a = agents_[agent];
  const Vec3 multiplier = inverse_ * (task.torque - middle_.cross(task.force));
  const Vec3 force = (task.force / give_force_ + multiplier.cross(a.position - middle_)) / a.force_weight;
  return force.dot(task.force) / task.force.squaredNorm();
}

void SeveralAgents::move(std::size_t agent, const Vec3& position) {
  agents_[agent].position = position;
  renew();
}

}  // namespace colift::planner
