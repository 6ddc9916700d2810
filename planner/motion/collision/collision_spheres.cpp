#include "planner/motion/collision/collision_spheres.hpp"

#include <algorithm>
#include <cmath>
#include <random>

namespace colift::planner {
namespace {

using hal::LinkShape;
using hal::Vec3;

constexpr int kMostPerShape = 32;  // bounds the time of each check; see cover_with_spheres()
/// Against rounding: a sphere is larger by this (m).
constexpr double kHair = 1e-6;

/// Division of a box of these half sizes into the fewest equal parts whose balls stand out of no side by more
/// than `excess_m`.
Eigen::Vector3i division(const Vec3& half, double excess_m) {
  for (double allowed = excess_m;; allowed *= 1.2) {
    Eigen::Vector3i best(0, 0, 0);
    int fewest = kMostPerShape + 1;
    for (int x = 1; x <= kMostPerShape; ++x) {
      for (int y = 1; x * y <= kMostPerShape; ++y) {
        for (int z = 1; x * y * z <= kMostPerShape; ++z) {
          const Vec3 part(half.x() / x, half.y() / y, half.z() / z);
          if (part.norm() - part.minCoeff() > allowed || x * y * z >= fewest) continue;
          fewest = x * y * z;
          best = {x, y, z};
        }
      }
    }
    if (fewest <= kMostPerShape) return best;
  }
}

void cover_box(const Vec3& size, double excess_m, std::vector<std::pair<Vec3, double>>& out) {
  const Vec3 half = 0.5 * size;
  const Eigen::Vector3i n = division(half, excess_m);
  const Vec3 part = half.cwiseQuotient(n.cast<double>());
  for (int z = 0; z < n.z(); ++z) {
    for (int y = 0; y < n.y(); ++y) {
      for (int x = 0; x < n.x(); ++x) {
        const Vec3 at(2 * x + 1, 2 * y + 1, 2 * z + 1);
        out.emplace_back(part.cwiseProduct(at) - half, part.norm() + kHair);
      }
    }
  }
}

void cover_cylinder(double radius, double length, double excess_m,
                    std::vector<std::pair<Vec3, double>>& out) {
  const double part = std::sqrt(excess_m * (2.0 * radius + excess_m));  // half length within the excess
  const int n = std::clamp(static_cast<int>(std::ceil(0.5 * length / part)), 1, kMostPerShape);
  const double half = 0.5 * length / n;
  for (int i = 0; i < n; ++i) {
    out.emplace_back(Vec3(0, 0, (2 * i + 1) * half - 0.5 * length), std::hypot(radius, half) + kHair);
  }
}

/// Spheres of a link and one around them all.
struct LinkCover {
  std::vector<std::pair<Vec3, double>> spheres;
  Vec3 middle = Vec3::Zero();
  double reach_m = 0.0;
};

std::vector<LinkCover> cover_links(const hal::RobotModel& model, double excess_m) {
  std::vector<LinkCover> links(model.links.size());
  for (std::size_t l = 0; l < links.size(); ++l) {
    LinkCover& link = links[l];
    for (const LinkShape& shape : model.links[l].shapes) cover_shape(shape, excess_m, link.spheres);
    if (link.spheres.empty()) continue;
    hal::Aabb box;
    for (const auto& [center, radius] : link.spheres) box.extend(center);
    link.middle = box.center();
    for (const auto& [center, radius] : link.spheres) {
      link.reach_m = std::max(link.reach_m, (center - link.middle).norm() + radius);
    }
  }
  return links;
}

bool near(const LinkCover& a, const hal::Pose& X_WA, const LinkCover& b, const hal::Pose& X_WB,
          double gap_m) {
  const double reach = a.reach_m + b.reach_m + gap_m;
  if ((X_WA * a.middle - X_WB * b.middle).squaredNorm() > reach * reach) return false;
  const hal::Pose X_AB = X_WA.inverse() * X_WB;
  for (const auto& [center_b, radius_b] : b.spheres) {
    const Vec3 p = X_AB * center_b;
    for (const auto& [center_a, radius_a] : a.spheres) {
      const double sum = radius_a + radius_b + gap_m;
      if ((p - center_a).squaredNorm() < sum * sum) return true;
    }
  }
  return false;
}

/// Uniform within limits, one in eight exactly at one of them: links meet first there.
class Postures {
 public:
  explicit Postures(const hal::RobotModel& model) : lower_(model.lower_rad()), upper_(model.upper_rad()) {}

  hal::JointVector arm() {
    hal::JointVector q;
    for (int i = 0; i < hal::kArmJoints; ++i) {
      const double t = unit();
      q[i] = lower_[i] + (upper_[i] - lower_[i]) * std::clamp(8.0 / 7.0 * t - 1.0 / 14.0, 0.0, 1.0);
    }
    return q;
  }
  hal::HandPosture hand() {
    constexpr double kClosed = 2.44, kHalfTurn = 3.1416;  // ranges of finger (140 deg) and spread (180 deg)
    const double inner = kClosed * unit();
    return hal::coupled_posture(inner, kHalfTurn * unit());
  }

 private:
  double unit() { return static_cast<double>(random_() >> 11) * 0x1p-53; }

  hal::JointVector lower_, upper_;
  std::mt19937_64 random_{1};
};

std::vector<std::pair<int, int>> find_self_pairs(const hal::RobotModel& model,
                                                 const std::vector<LinkCover>& cover) {
  // Drawn once per robot model, with the ends of the joints' ranges drawn more often; margins stand for what
  // lies between the draws.
  constexpr int kPostures = 10000;
  constexpr double kGap = 0.03;  // what was never nearer than this in any posture does not meet
  // Links with one body between them have two joints to move against each other: the samples are dense, and
  // the loose spheres would often overlap where the links do not.
  constexpr double kTightExcess = 0.003, kTightGap = 0.003;
  const std::vector<LinkCover> tight = cover_links(model, kTightExcess);
  const std::vector<int> body = arm_body(model);
  std::vector<std::pair<int, int>> open, met;
  for (std::size_t a = 0; a < cover.size(); ++a) {
    for (std::size_t b = a + 1; b < cover.size(); ++b) {
      const auto la = static_cast<int>(a), lb = static_cast<int>(b);
      if (cover[a].spheres.empty() || cover[b].spheres.empty() || !may_meet(model, body, la, lb)) continue;
      open.emplace_back(la, lb);
    }
  }
  Postures postures(model);
  std::vector<hal::Pose> X_WL;
  for (int i = 0; i < kPostures && !open.empty(); ++i) {
    const hal::JointVector q = postures.arm();
    hal::link_poses(model, q, postures.hand(), X_WL);
    std::erase_if(open, [&](const std::pair<int, int>& pair) {
      const auto a = static_cast<std::size_t>(pair.first), b = static_cast<std::size_t>(pair.second);
      const bool close = std::abs(body[a] - body[b]) == 2
                             ? near(tight[a], X_WL[a], tight[b], X_WL[b], kTightGap)
                             : near(cover[a], X_WL[a], cover[b], X_WL[b], kGap);
      if (close) met.push_back(pair);
      return close;
    });
  }
  std::sort(met.begin(), met.end());
  return met;
}

}  // namespace

void cover_shape(const LinkShape& shape, double excess_m, std::vector<std::pair<Vec3, double>>& out) {
  const std::size_t first = out.size();
  if (shape.kind == LinkShape::Kind::Box) cover_box(shape.size, excess_m, out);
  if (shape.kind == LinkShape::Kind::Cylinder) cover_cylinder(shape.size[0], shape.size[1], excess_m, out);
  if (shape.kind == LinkShape::Kind::Sphere) out.emplace_back(Vec3::Zero(), shape.size[0] + kHair);
  for (std::size_t i = first; i < out.size(); ++i) out[i].first = shape.X_LS * out[i].first;
}

std::vector<int> arm_body(const hal::RobotModel& model) {
  std::vector<int> body(model.links.size(), 0);
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    const int parent = model.links[l].parent;
    if (parent >= 0) body[l] = body[static_cast<std::size_t>(parent)];
    for (int joint = 0; joint < hal::kArmJoints; ++joint) {
      if (model.arm[static_cast<std::size_t>(joint)] == static_cast<int>(l)) body[l] = joint + 1;
    }
  }
  return body;
}

bool may_meet(const hal::RobotModel& model, const std::vector<int>& body, int a, int b) {
  const int apart = std::abs(body[static_cast<std::size_t>(a)] - body[static_cast<std::size_t>(b)]);
  return apart > 2 || (apart == 2 && (model.in_hand(a) || model.in_hand(b)));
}

SphereModel cover_with_spheres(const hal::RobotModel& model, double excess_m) {
  const std::vector<LinkCover> cover = cover_links(model, excess_m);
  SphereModel out;
  for (std::size_t l = 0; l < cover.size(); ++l) {
    for (const auto& [center, radius] : cover[l].spheres) {
      out.spheres.push_back({static_cast<int>(l), center, radius});
    }
  }
  out.self_pairs = find_self_pairs(model, cover);
  return out;
}

}  // namespace colift::planner
