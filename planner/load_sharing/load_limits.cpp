#include "planner/load_sharing/load_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/load_sharing/load_limits_problem.hpp"

namespace colift::planner {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::array<const char*, 3> kAxis = {"x", "y", "z"};

double clamp_to(double value, double limit) {
  return std::clamp(value, -limit, limit);
}

}  // namespace

std::string Shortfall::text() const {
  const double sum = partner + robot;
  if (kind == Kind::Force) {
    int axis = 0;
    direction.cwiseAbs().maxCoeff(&axis);
    return fmt::format("needs {:.4g} N along {}; partner {:.4g} N and robot {:.4g} N give {:.4g} N", needed,
                       kAxis[axis], partner, robot, sum);
  }
  const std::string line = [&]() -> std::string {
    if (kind == Kind::TorqueOfHands) return "the line through both hands";
    int axis = 0;
    if (direction.cwiseAbs().maxCoeff(&axis) == 1.0) return kAxis[axis];
    return fmt::format("the direction ({:.3g}, {:.3g}, {:.3g})", direction.x(), direction.y(), direction.z());
  }();
  const char* beyond = kind == Kind::TorqueOfHands ? "" : " beyond what the forces of both can do";
  return fmt::format("needs {:.4g} N m about {}{}; partner {:.4g} N m and robot {:.4g} N m give {:.4g} N m",
                     needed, line, beyond, partner, robot, sum);
}

hal::Result<LimitedSharing> LimitedSharing::create(const LoadSharing& sharing, const SharingLimits& limits) {
  const auto check = [](const char* name, double value) -> hal::Result<> {
    if (value >= 0.0) return {};
    return hal::failure(hal::ErrorCode::BadInput, fmt::format("limits.{}", name),
                        fmt::format("is {}, expected a number that is not negative", value));
  };
  if (auto ok = check("partner.force", limits.partner.force_n); !ok) return tl::unexpected(ok.error());
  if (auto ok = check("partner.torque", limits.partner.torque_nm); !ok) return tl::unexpected(ok.error());
  if (auto ok = check("robot.force", limits.robot.force_n); !ok) return tl::unexpected(ok.error());
  if (auto ok = check("robot.torque", limits.robot.torque_nm); !ok) return tl::unexpected(ok.error());
  return LimitedSharing(sharing, limits);
}

LimitedSharing::LimitedSharing(const LoadSharing& sharing, const SharingLimits& limits)
    : sharing_(sharing), limits_(limits), torque_sum_(limits.partner.torque_nm + limits.robot.torque_nm) {
  const double a1 = sharing.partner_give(), a2 = sharing.robot_give();
  const double t1 = limits.partner.torque_nm, t2 = limits.robot.torque_nm;
  // the multiplier at which each agent's torque meets its limit; free torque is used up at once
  const double m1 = std::isinf(t1) ? kInfinity : t1 / a1, m2 = std::isinf(t2) ? kInfinity : t2 / a2;
  const bool free1 = std::isinf(a1), free2 = std::isinf(a2);
  if (free1 || free2) {
    knee_m_ = 0.0;
    knee_torque_ = (free1 ? t1 : 0.0) + (free2 ? t2 : 0.0);
    first_limit_ = knee_torque_;
    second_give_ = free1 ? a2 : a1;
    wall_m_ = free1 && free2 ? 0.0 : (free1 ? m2 : m1);
  } else {
    const bool partner_first = m1 <= m2;
    knee_m_ = partner_first ? m1 : m2;
    first_limit_ = partner_first ? t1 : t2;
    second_give_ = partner_first ? a2 : a1;
    knee_torque_ = std::isinf(knee_m_) ? kInfinity : first_limit_ + second_give_ * knee_m_;
    wall_m_ = partner_first ? m2 : m1;
  }
}

bool LimitedSharing::within(const AgentWrenches& w) const {
  return w.partner.force.cwiseAbs().maxCoeff() <= limits_.partner.force_n &&
         w.robot.force.cwiseAbs().maxCoeff() <= limits_.robot.force_n &&
         w.partner.torque.cwiseAbs().maxCoeff() <= limits_.partner.torque_nm &&
         w.robot.torque.cwiseAbs().maxCoeff() <= limits_.robot.torque_nm;
}

std::optional<Shortfall> LimitedSharing::shortfall(const Vec3& p_partner, const Vec3& p_robot,
                                                   const Wrench& task) const {
  const double force_sum = limits_.partner.force_n + limits_.robot.force_n;
  std::optional<Shortfall> worst;
  double worst_ratio = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double needed = std::abs(task.force[k]);
    if (needed <= force_sum * (1.0 + kTouch)) continue;
    const double ratio = needed / force_sum;
    if (worst && ratio <= worst_ratio) continue;
    worst_ratio = ratio;
    worst = Shortfall{Shortfall::Kind::Force, Vec3::Unit(k), needed, limits_.partner.force_n,
                      limits_.robot.force_n};
  }
  if (worst || std::isinf(torque_sum_)) return worst;

  const Problem q(*this, p_partner, p_robot, task);
  const double lever_noise =
      kTouch * (task.torque.cwiseAbs().maxCoeff() +
                2.0 * p_robot.cwiseAbs().maxCoeff() * task.force.cwiseAbs().maxCoeff());

  // For a line `l` and forces z, the wrists must give l . need - (l x arm) . z; infeasible if even the best z
  // asks for more than their sum. `couple` is l x arm, passed in so that its zeros are exact.
  const auto test = [&](Shortfall::Kind kind, const Vec3& line, const Vec3& couple) {
    const double demand = line.dot(q.need);
    double helped_up = 0.0, helped_down = 0.0, noise = 0.0;
    for (int k = 0; k < 3; ++k) {
      if (couple[k] == 0.0) continue;
      const double a = couple[k] * q.low[k], b = couple[k] * q.high[k];
      helped_up += std::max(a, b);
      helped_down += std::min(a, b);
      noise += kTouch * std::max(std::abs(a), std::abs(b));
    }
    const double size = line.cwiseAbs().sum();
    const double capacity = size * torque_sum_;
    const double missing = std::max(demand - helped_up, helped_down - demand);
    if (!(missing > capacity + noise + size * lever_noise + kTouch * capacity)) return;
    const double ratio = missing / capacity;
    if (worst && ratio <= worst_ratio) return;
    worst_ratio = ratio;
    const double length = line.norm();
    worst = Shortfall{kind, line / length, missing / length, size / length * limits_.partner.torque_nm,
                      size / length * limits_.robot.torque_nm};
  };

  // of lines that miss equally much the first is named, so the one with the most familiar name comes first
  const Vec3& d = q.arm;
  if (!d.isZero(0.0)) test(Shortfall::Kind::TorqueOfHands, d, Vec3::Zero());
  const std::array<Vec3, 3> axis_couple = {Vec3(0.0, -d.z(), d.y()), Vec3(d.z(), 0.0, -d.x()),
                                           Vec3(-d.y(), d.x(), 0.0)};
  for (int c = 0; c < 3; ++c) test(Shortfall::Kind::Torque, Vec3::Unit(c), axis_couple[c]);
  for (int c = 0; c < 3; ++c) {
    Vec3 line = d;
    line[c] = 0.0;
    if (line.isZero(0.0)) continue;
    test(Shortfall::Kind::Torque, line, -d[c] * axis_couple[c]);
  }
  return worst;
}

AgentWrenches LimitedSharing::split(const Wrench& task, const Vec3& partner_force, const Vec3& torque) const {
  AgentWrenches w;
  const double t1 = limits_.partner.torque_nm, t2 = limits_.robot.torque_nm;
  const double a1 = sharing_.partner_give(), a2 = sharing_.robot_give();
  for (int c = 0; c < 3; ++c) {
    w.partner.force[c] = partner_force[c];
    w.robot.force[c] = clamp_to(task.force[c] - partner_force[c], limits_.robot.force_n);
    double part = sharing_.partner_part();
    if (std::isfinite(a1) || std::isfinite(a2)) part = std::isinf(a1) ? 1.0 : a1 / (a1 + a2);
    // what one cannot take, the other does
    double mine = clamp_to(part * torque[c], t1);
    const double other = clamp_to(torque[c] - mine, t2);
    mine = clamp_to(torque[c] - other, t1);
    w.partner.torque[c] = mine;
    w.robot.torque[c] = other;
  }
  return w;
}

std::optional<AgentWrenches> LimitedSharing::wrenches(const Vec3& p_partner, const Vec3& p_robot,
                                                      const Wrench& task) const {
  const AgentWrenches unlimited = sharing_.wrenches(p_partner, p_robot, task);
  if (within(unlimited)) return unlimited;
  if (shortfall(p_partner, p_robot, task)) return std::nullopt;
  const Problem q(*this, p_partner, p_robot, task);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  solve(q, unlimited, force, torque);
  // scales beyond what doubles can balance (a lever of 1e12 m, say) must not pass for an answer
  const double terms =
      q.need.cwiseAbs().maxCoeff() + q.arm.cwiseAbs().maxCoeff() * force.cwiseAbs().maxCoeff();
  if (!((q.need - q.arm.cross(force) - torque).cwiseAbs().maxCoeff() <= 1e-9 * terms)) return std::nullopt;
  return split(task, force, torque);
}

AgentWrenches LimitedSharing::wrenches_by_enumeration(const Vec3& p_partner, const Vec3& p_robot,
                                                      const Wrench& task) const {
  const Problem q(*this, p_partner, p_robot, task);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  enumerate(q, force, torque);
  return split(task, force, torque);
}

}  // namespace colift::planner
