#include "planner/load_sharing/load_sharing.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <limits>

namespace colift::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

hal::Result<> check_weight(const char* name, double value, bool zero_allowed) {
  const auto refuse = [&](std::string detail) {
    return hal::failure(hal::ErrorCode::BadInput, fmt::format("weights.{}", name), std::move(detail));
  };
  if (!std::isfinite(value)) return refuse(fmt::format("is {}, expected a finite number", value));
  if (value < 0) return refuse(fmt::format("is {}, expected a number that is not negative", value));
  if (value == 0) {
    if (zero_allowed) return {};
    return refuse(
        "is 0, expected a number above 0: with 0 the robot's effort costs nothing and all grasps are equal");
  }
  if (value < kSmallestWeight || value > kLargestWeight) {
    return refuse(fmt::format("is {}, expected {} to {}", value, kSmallestWeight, kLargestWeight));
  }
  return {};
}

}  // namespace

hal::Result<double> epsilon_for_share(double share) {
  if (!(share > 0.0 && share < 1.0)) {
    return hal::failure(
        hal::ErrorCode::BadInput, "share",
        fmt::format("is {}, expected more than 0 and less than 1 (the robot's share of the load)", share));
  }
  return std::sqrt((1.0 - share) / share);
}

hal::Result<LoadSharing> LoadSharing::create(const SharingWeights& weights) {
  if (auto ok = check_weight("epsilon", weights.epsilon, false); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_weight("omega1", weights.omega1_per_m, true); !ok) return tl::unexpected(ok.error());
  if (auto ok = check_weight("omega2", weights.omega2_per_m, true); !ok) return tl::unexpected(ok.error());
  return LoadSharing(weights);
}

LoadSharing::LoadSharing(const SharingWeights& weights)
    : epsilon_(weights.epsilon), omega1_(weights.omega1_per_m), omega2_(weights.omega2_per_m) {
  const double e2 = epsilon_ * epsilon_;
  partner_part_ = e2 / (1.0 + e2);
  robot_part_ = 1.0 / (1.0 + e2);
  force_weight_ = partner_part_;  // 1/(u+v) = e2/(1+e2)
  partner_give_ = omega1_ == 0.0 ? kInfinity : 1.0 / (omega1_ * omega1_);
  robot_give_ = omega2_ == 0.0 ? kInfinity : 1.0 / (epsilon_ * omega2_) / (epsilon_ * omega2_);
  give_ = partner_give_ + robot_give_;
  stiffness_ratio_ = robot_part_ / give_;
  if (std::isfinite(give_)) {
    partner_torque_part_ = partner_give_ / give_;
  } else if (std::isfinite(partner_give_)) {
    partner_torque_part_ = 0.0;
  } else {
    partner_torque_part_ = std::isfinite(robot_give_) ? 1.0 : partner_part_;
  }
}

double LoadSharing::cost(const Vec3& p_partner, const Vec3& p_robot, std::span<const Wrench> tasks) const {
  const Lever l = lever(p_partner, p_robot);
  double sum = 0.0;
  for (const Wrench& task : tasks) sum += force_weight_ * task.force.squaredNorm() + torque_cost(l, task);
  return sum;
}

AgentWrenches LoadSharing::wrenches(const Vec3& p_partner, const Vec3& p_robot, const Wrench& task) const {
  const Lever l = lever(p_partner, p_robot);
  const Vec3 rest = task.torque - l.middle.cross(task.force);
  // the multiplier of the torque balance; zero where torque is free, because inv_across is
  const Vec3 multiplier = (rest + stiffness_ratio_ * l.arm.dot(rest) * l.arm) * l.inv_across;
  const Vec3 couple = robot_part_ * l.arm.cross(multiplier);
  const Vec3 torque = std::isfinite(give_) ? Vec3(give_ * multiplier) : rest;
  AgentWrenches w;
  w.partner.force = partner_part_ * task.force - couple;
  w.robot.force = robot_part_ * task.force + couple;
  w.partner.torque = partner_torque_part_ * torque;
  w.robot.torque = (1.0 - partner_torque_part_) * torque;
  if (std::isfinite(give_))
    w.robot.torque = robot_give_ * multiplier;  // no cancellation where its part is small
  return w;
}

double LoadSharing::cost_weight(const AgentWrenches& w) const {
  const double e2 = epsilon_ * epsilon_;
  return w.partner.force.squaredNorm() + (omega1_ * w.partner.torque).squaredNorm() +
         e2 * (w.robot.force.squaredNorm() + (omega2_ * w.robot.torque).squaredNorm());
}

void LoadSharing::costs(const Vec3& p_partner, std::span<const double> x_m, std::span<const double> y_m,
                        std::span<const double> z_m, std::span<const Wrench> tasks,
                        std::span<double> out) const {
  const std::size_t n = out.size();
  assert(x_m.size() == n && y_m.size() == n && z_m.size() == n);
  const double* __restrict xs = x_m.data();
  const double* __restrict ys = y_m.data();
  const double* __restrict zs = z_m.data();
  double* __restrict sum = out.data();

  double force_cost = 0.0;
  for (const Wrench& task : tasks) force_cost += force_weight_ * task.force.squaredNorm();
  for (std::size_t i = 0; i < n; ++i) sum[i] = force_cost;

  // Everything constant leaves the loop, so that the compiler can run two candidates per instruction.
  const double px = p_partner.x(), py = p_partner.y(), pz = p_partner.z();
  const double robot_part = robot_part_, give = give_, ratio = stiffness_ratio_;
  for (const Wrench& task : tasks) {
    const double fx = task.force.x(), fy = task.force.y(), fz = task.force.z();
    const double tx = task.torque.x(), ty = task.torque.y(), tz = task.torque.z();
    const double mx = partner_part_ * px, my = partner_part_ * py, mz = partner_part_ * pz;
    for (std::size_t i = 0; i < n; ++i) {
      const double cx = mx + robot_part * xs[i], cy = my + robot_part * ys[i], cz = mz + robot_part * zs[i];
      const double dx = px - xs[i], dy = py - ys[i], dz = pz - zs[i];
      const double rx = tx - (cy * fz - cz * fy), ry = ty - (cz * fx - cx * fz),
                   rz = tz - (cx * fy - cy * fx);
      const double along = dx * rx + dy * ry + dz * rz;
      sum[i] += (rx * rx + ry * ry + rz * rz + ratio * along * along) /
                (robot_part * (dx * dx + dy * dy + dz * dz) + give);
    }
  }
}

}  // namespace colift::planner
