#include "perception/ground/plane_vote.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

class Voter {
 public:
  Voter(const std::vector<BlockPlane>& blocks, const NoiseModel& noise, const PlaneTolerance& tolerance,
        double max_normal_angle_deg)
      : blocks_(blocks), min_cosine_(std::cos(max_normal_angle_deg * hal::kRadPerDeg)) {
    reach_.reserve(blocks.size());
    weight_.reserve(blocks.size());
    for (const BlockPlane& b : blocks) {
      reach_.push_back(static_cast<float>(tolerance.at(noise, b.depth_m)));
      const double s = noise.sigma(b.depth_m);
      weight_.push_back(1e-6 / (s * s));
    }
  }

  [[nodiscard]] bool votes(std::size_t i, const Plane& plane) const {
    const Eigen::Vector3f n = plane.normal.cast<float>();
    const float offset = static_cast<float>(plane.offset);
    return std::abs(n.dot(blocks_[i].center) + offset) <= reach_[i] &&
           n.dot(blocks_[i].normal) >= static_cast<float>(min_cosine_);
  }

  // least squares over the centres of the voting blocks, weighted by their precision
  [[nodiscard]] Plane refit(const Plane& plane) const {
    double total = 0.0;
    Vec3 mean = Vec3::Zero();
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    const Vec3 origin = plane.foot(Vec3::Zero());
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      if (!votes(i, plane)) continue;
      const Vec3 p = blocks_[i].center.cast<double>() - origin;
      total += weight_[i];
      mean += weight_[i] * p;
      second += weight_[i] * p * p.transpose();
    }
    if (total <= 0.0) return plane;
    mean /= total;
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
    solver.computeDirect(second / total - mean * mean.transpose());
    if (solver.eigenvalues()(1) < 1e-4)
      return plane;  // m^2: blocks on a line (within 1 cm) do not define a plane
    Vec3 n = solver.eigenvectors().col(0);
    if (n.dot(plane.normal) < 0) n = -n;
    return {n, -n.dot(origin + mean)};
  }

 private:
  const std::vector<BlockPlane>& blocks_;
  double min_cosine_;
  std::vector<float> reach_;
  std::vector<double> weight_;
};

}  // namespace

std::vector<VotedPlane> vote_planes(const std::vector<BlockPlane>& blocks,
                                    const std::function<bool(const Vec3&)>& wanted, const NoiseModel& noise,
                                    const PlaneTolerance& tolerance, const PlaneVoteConfig& config) {
  std::vector<std::size_t> proposers;
  for (std::size_t i = 0; i < blocks.size(); ++i)
    if (wanted(blocks[i].normal.cast<double>())) proposers.push_back(i);

  const Voter voter(blocks, noise, tolerance, config.max_normal_angle_deg);
  std::vector<VotedPlane> found;
  const std::size_t stride =
      std::max<std::size_t>(1, proposers.size() / static_cast<std::size_t>(config.proposals));
  for (std::size_t k = stride / 2; k < proposers.size(); k += stride) {
    const std::size_t i = proposers[k];
    const bool known =
        std::any_of(found.begin(), found.end(), [&](const VotedPlane& f) { return voter.votes(i, f.plane); });
    if (known) continue;

    // one block's normal is a weak proposal: let the blocks near it mend it before the count
    const Vec3 n = blocks[i].normal.cast<double>();
    Plane plane{n, -n.dot(blocks[i].center.cast<double>())};
    for (int round = 0; round < config.refits; ++round) plane = voter.refit(plane);
    if (!wanted(plane.normal)) continue;  // a wall that grew out of one crooked block
    const bool again = std::any_of(found.begin(), found.end(), [&](const VotedPlane& f) {
      return f.plane.normal.dot(plane.normal) > std::cos(config.same_plane_angle_deg * hal::kRadPerDeg) &&
             std::abs(f.plane.height(plane.foot(blocks[i].center.cast<double>()))) <
                 config.same_plane_distance_m;
    });
    if (again) continue;

    VotedPlane voted{plane, 0.0, {}};
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      if (!voter.votes(b, plane)) continue;
      voted.area_m2 += blocks[b].area_m2;
      voted.blocks.push_back(&blocks[b]);
    }
    if (voted.blocks.size() >= static_cast<std::size_t>(config.min_blocks)) found.push_back(std::move(voted));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.area_m2 > b.area_m2; });
  return found;
}

}  // namespace colift::perception
