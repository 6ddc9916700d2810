#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::planner {

/// What a point belongs to, in a refusal's words.
enum class ObstacleKind : std::uint8_t { Object, Surroundings };

/// Points that a hand must not touch and the ground under them, frame W. Buckets of 2 cm hold the points,
/// sorted by bucket, so that a hand looks only at the buckets around it.
class Obstacles {
 public:
  static constexpr double kCell = 0.02;

  /// Radius of the ball around a bucket's middle that holds the bucket.
  static constexpr double kCellRadius = 0.01732051;

  void add(const Eigen::Vector3f& p, ObstacleKind kind);
  void set_ground(const hal::Plane& plane) { ground_ = plane; }

  /// Sorts what was added; call once, before the first look.
  void build();

  struct Bucket {
    int ix;
    std::uint32_t begin, end;
    Eigen::Vector3f center;
  };

  /// Calls f(bucket) for every filled bucket that touches the box, in ascending order.
  template <class F>
  void for_each_bucket(const hal::Aabb& box, F&& f) const {
    if (buckets_.empty()) return;
    const auto low = [&](int a) { return std::max(0, cell_of(box.min()[a], a)); };
    const auto high = [&](int a) { return std::min(n_[a] - 1, cell_of(box.max()[a], a)); };
    const int x0 = low(0), x1 = high(0), y0 = low(1), y1 = high(1), z0 = low(2), z1 = high(2);
    for (int iz = z0; iz <= z1; ++iz) {
      for (int iy = y0; iy <= y1; ++iy) {
        const auto row = static_cast<std::size_t>(iz * n_[1] + iy);
        for (std::uint32_t b = row_begin_[row]; b < row_begin_[row + 1]; ++b) {
          if (buckets_[b].ix >= x0 && buckets_[b].ix <= x1) f(buckets_[b]);
        }
      }
    }
  }

  /// In the order of the buckets.
  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] const std::vector<Eigen::Vector3f>& points() const { return points_; }
  [[nodiscard]] ObstacleKind kind(std::size_t i) const { return kinds_[i]; }
  [[nodiscard]] const std::optional<hal::Plane>& ground() const { return ground_; }

 private:
  [[nodiscard]] int cell_of(double value, int axis) const {
    const double cell = std::floor((value - origin_[axis]) * (1.0 / kCell));
    return static_cast<int>(std::clamp(cell, -1.0, 1e6));
  }

  std::vector<Eigen::Vector3f> points_;
  std::vector<ObstacleKind> kinds_;
  std::optional<hal::Plane> ground_;
  hal::Vec3 origin_ = hal::Vec3::Zero();
  int n_[3] = {0, 0, 0};
  std::vector<Bucket> buckets_;
  std::vector<std::uint32_t> row_begin_;
};

/// Which points of a frame count as obstacles.
struct ObstacleConfig {
  double reach_m = 0.30;
  double ground_band_m = 0.015;
  double ground_sigmas = 4.0;
  int min_support = 3;
  double support_sigmas = 4.0;
  bool surroundings = true;
  perception::NoiseModel noise;

  template <class Visitor>
  void visit(Visitor& v) {
    v("reach_m", reach_m, hal::Range{0, 5},
      "Points farther than this from the object's box are left out (m).");
    v("ground_band_m", ground_band_m, hal::Range{0, 0.2},
      "Points this near the ground plane are the ground (m).");
    v("ground_sigmas", ground_sigmas, hal::Range{0, 20}, "The same in standard deviations of the depth.");
    v("min_support", min_support, hal::Range{0, 8},
      "Neighbours in the image at a like depth that a point needs.");
    v("support_sigmas", support_sigmas, hal::Range{0, 50}, "What a like depth is, in standard deviations.");
    v("surroundings", surroundings, "Whether points beside the object count.");
    v("noise", noise, "Depth noise.");
  }
};

/// The object's points and the points around it, without the ground (the plane stands for it) and without
/// lone points in mid-air: a pixel between an edge and its background shows a depth at which there is
/// nothing. `cloud` may be null: then the object's points alone.
[[nodiscard]] Obstacles gather_obstacles(const perception::Scene& scene,
                                         const perception::OrganisedCloud* cloud,
                                         const ObstacleConfig& config);

}  // namespace colift::planner
