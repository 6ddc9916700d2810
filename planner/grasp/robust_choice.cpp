#include "planner/grasp/robust_choice.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <numbers>

namespace colift::planner {
namespace {

// SplitMix64 (Steele, Lea, Flood 2014): the same bits on every machine, unlike the standard's distributions
class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : state_(seed) {}
  double next() {
    std::uint64_t h = (state_ += 0x9e3779b97f4a7c15ULL);
    h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9ULL;
    h = (h ^ (h >> 27)) * 0x94d049bb133111ebULL;
    h ^= h >> 31;
    return (static_cast<double>(h >> 11) + 0.5) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

// a root of a covariance; of one that is not quite positive, of the nearest that is
Eigen::Matrix3d root_of(const Eigen::Matrix3d& covariance) {
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(covariance);
  const Vec3 d = ldlt.vectorD().cwiseMax(0.0).cwiseSqrt();
  const Eigen::Matrix3d lower = ldlt.matrixL();
  return ldlt.transpositionsP().transpose() * Eigen::Matrix3d(lower * d.asDiagonal());
}

// a frame whose z axis is up
Eigen::Matrix3d level_frame(const Vec3& up) {
  const Vec3 z = up.normalized();
  const Vec3 x = (std::abs(z.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitY()).cross(z).normalized();
  Eigen::Matrix3d R;
  R.row(0) = x;
  R.row(1) = z.cross(x);
  R.row(2) = z;
  return R;
}

}  // namespace

hal::Result<RobustChoice> RobustChoice::create(const SharingWeights& weights, std::size_t most_candidates,
                                               int what_ifs, std::uint64_t seed) {
  const auto sharing = LoadSharing::create(weights);
  if (!sharing) return tl::unexpected(sharing.error());
  if (what_ifs < 1 || most_candidates < 1)
    return hal::failure(hal::ErrorCode::BadInput, "robust_choice",
                        fmt::format("{} what-ifs of {} candidates, expected at least one of each", what_ifs,
                                    most_candidates));
  return RobustChoice(*sharing, weights, most_candidates, what_ifs, seed);
}

RobustChoice::RobustChoice(const LoadSharing& sharing, const SharingWeights& weights,
                           std::size_t most_candidates, int what_ifs, std::uint64_t seed)
    : sharing_(sharing),
      force_weight_(sharing.partner_part()),  // 1/(u+v)
      alone_torque_weight_(weights.omega1_per_m * weights.omega1_per_m),
      normal_(6 * static_cast<std::size_t>(what_ifs)),
      bx_(most_candidates),
      by_(most_candidates),
      ex_(most_candidates),
      ey_(most_candidates),
      ez_(most_candidates),
      limit_(most_candidates),
      sum_(most_candidates),
      worst_(most_candidates),
      points_(most_candidates),
      costs_(most_candidates) {
  Uniform uniform(seed);
  const std::size_t pairs = static_cast<std::size_t>(what_ifs) / 2;
  for (std::size_t i = 0; i < pairs; ++i)
    for (std::size_t k = 0; k < 6; k += 2) {  // Box and Muller 1958
      const double r = std::sqrt(-2.0 * std::log(uniform.next())),
                   a = 2.0 * std::numbers::pi * uniform.next();
      const double n[] = {r * std::cos(a), r * std::sin(a)};
      for (std::size_t j = 0; j < 2; ++j) {
        normal_[12 * i + k + j] = n[j];
        normal_[12 * i + 6 + k + j] = -n[j];
      }
    }
  // of an odd number the last is the belief itself: zeros
}

void RobustChoice::evaluate(const UncertainScene& scene, std::span<const Vec3> points,
                            std::span<RobustCost> out, std::span<const double> holds_n) {
  const std::size_t n = points.size();
  assert(n <= bx_.size() && out.size() == n && (holds_n.empty() || holds_n.size() == n));
  const Eigen::Matrix3d R = level_frame(scene.up);
  const Vec3 p = R * (scene.partner - scene.cog);
  const double part1 = sharing_.partner_part(), part2 = sharing_.robot_part();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 r = R * (points[i] - scene.cog);
    bx_[i] = part1 * p.x() + part2 * r.x();
    by_[i] = part1 * p.y() + part2 * r.y();
    ex_[i] = p.x() - r.x();
    ey_[i] = p.y() - r.y();
    ez_[i] = p.z() - r.z();
    limit_[i] = holds_n.empty() ? std::numeric_limits<double>::infinity() : holds_n[i] / scene.weight_n;
    sum_[i] = worst_[i] = 0.0;
  }
  const Eigen::Matrix3d of_cog = R * root_of(scene.cog_covariance),
                        of_partner = R * root_of(scene.partner_covariance);
  const double give = sharing_.give(), ratio = std::isfinite(give) ? part2 / give : 0.0;
  const double* __restrict bx = bx_.data();
  const double* __restrict by = by_.data();
  const double* __restrict ex = ex_.data();
  const double* __restrict ey = ey_.data();
  const double* __restrict ez = ez_.data();
  const double* __restrict limit = limit_.data();
  double* __restrict sum = sum_.data();
  double* __restrict worst = worst_.data();
  const std::size_t what_ifs = normal_.size() / 6;
  for (std::size_t k = 0; k < what_ifs; ++k) {
    const Vec3 dc = of_cog * Eigen::Map<const Vec3>(&normal_[6 * k]);
    const Vec3 dp = of_partner * Eigen::Map<const Vec3>(&normal_[6 * k + 3]);
    const double sx = part1 * dp.x() - dc.x(), sy = part1 * dp.y() - dc.y();
    const double px = dp.x(), py = dp.y(), pz = dp.z();
    const double lx = p.x() + dp.x() - dc.x(), ly = p.y() + dp.y() - dc.y();
    const double alone = 1.0 - force_weight_ + alone_torque_weight_ * (lx * lx + ly * ly);
    for (std::size_t i = 0; i < n; ++i) {
      // with f = z, c x f = (c_y, -c_x, 0); signs drop out of the squares
      const double cx = bx[i] + sx, cy = by[i] + sy;
      const double dx = ex[i] + px, dy = ey[i] + py, dz = ez[i] + pz;
      const double along = dx * cy - dy * cx;
      const double ease = 1.0 / (part2 * (dx * dx + dy * dy + dz * dz) + give);
      const double shared = (cx * cx + cy * cy + ratio * along * along) * ease;
      const double carried = part2 * (1.0 + (dx * cx + dy * cy) * ease);
      const double cost = carried <= limit[i] ? shared : alone;
      sum[i] += cost;
      worst[i] = worst[i] < cost ? cost : worst[i];
    }
  }
  for (std::size_t i = 0; i < n; ++i)
    out[i] = {force_weight_ + sum_[i] / static_cast<double>(what_ifs), force_weight_ + worst_[i]};
}

std::optional<std::size_t> RobustChoice::choose(const UncertainScene& scene,
                                                std::span<const GraspCandidate> candidates, Aim aim,
                                                std::span<const double> holds_n) {
  std::optional<std::size_t> best;
  double best_cost = 0.0;
  // as many at a time as there is room for
  for (std::size_t begin = 0; begin < candidates.size(); begin += most_candidates()) {
    const std::size_t n = std::min(most_candidates(), candidates.size() - begin);
    for (std::size_t i = 0; i < n; ++i) {
      const GraspCandidate& c = candidates[begin + i];
      points_[i] = load_point(c);
    }
    const std::span<RobustCost> costs(costs_.data(), n);
    evaluate(scene, {points_.data(), n}, costs, holds_n.empty() ? holds_n : holds_n.subspan(begin, n));
    for (std::size_t i = 0; i < n; ++i) {
      const Verdict v = candidates[begin + i].verdict;
      if (v != Verdict::Ok && v != Verdict::Chosen) continue;
      const double cost = aim == Aim::Expected ? costs[i].expected : costs[i].worst;
      const bool as_good = best && cost == best_cost && v == Verdict::Chosen;
      if (!best || cost < best_cost || as_good) best = begin + i, best_cost = cost;
    }
  }
  return best;
}

}  // namespace colift::planner
