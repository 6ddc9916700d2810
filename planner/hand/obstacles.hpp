#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"

namespace colift::planner {

/// What a point belongs to, in a refusal's words.
enum class ObstacleKind : std::uint8_t { Object, Surroundings };

/// Points that a hand must not touch and the ground under them, frame W. Buckets of neighbouring points, each
/// within a small ball, stand in groups and these in regions with their boxes, so that a hand looks only at
/// the buckets around it.
class Obstacles {
 public:
  /// Radius of the ball around a bucket's middle that holds the bucket.
  static constexpr double kCellRadius = 0.009;

  void add(const Eigen::Vector3f& p, ObstacleKind kind);
  void set_ground(const hal::Plane& plane) { ground_ = plane; }

  /// Sorts what was added into buckets; call once, before the first look. Linear.
  void build();

  /// Points up to `end` and the box around them; `fits` says that they fit into a bucket.
  struct Run {
    std::uint32_t end;
    bool fits;
    Eigen::Vector3f low, high;
  };

  /// For points that come in groups of neighbours already (as pixels of an image do), instead of build():
  /// makes buckets of the points since the last call, without moving them. A run that does not fit into one
  /// is cut.
  void close_group(const std::vector<Run>& runs);

  /// Room for more points at the end, to be filled by the caller, who says in the end how many there are.
  struct Room {
    Eigen::Vector3f* points;
    ObstacleKind* kinds;
  };
  [[nodiscard]] Room make_room(std::size_t points);
  void keep(std::size_t points);

  /// Points `begin` to `end` that lie close together, and the middle of their box.
  struct Bucket {
    std::uint32_t begin, end;
    Eigen::Vector3f center;
  };

  /// Calls f(bucket) for every bucket that touches the box, in ascending order.
  template <class F>
  void for_each_bucket(const hal::Aabb& box, F&& f) const {
    const Eigen::Vector3f low = box.min().cast<float>(), high = box.max().cast<float>();
    constexpr auto r = static_cast<float>(kCellRadius + 1e-5);
    for (const Span& region : regions_) {
      if (!region.touches(low, high)) continue;
      for (std::uint32_t g = region.begin; g < region.end; ++g) {
        if (!groups_[g].touches(low, high)) continue;
        for (std::uint32_t b = groups_[g].begin; b < groups_[g].end; ++b) {
          const Eigen::Vector3f& c = buckets_[b].center;
          if (c.x() + r < low.x() || c.x() - r > high.x() || c.y() + r < low.y() || c.y() - r > high.y() ||
              c.z() + r < low.z() || c.z() - r > high.z()) {
            continue;
          }
          f(buckets_[b]);
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
  /// A box around a run of buckets or groups.
  struct Span {
    std::uint32_t begin, end;
    Eigen::Vector3f low, high;
    [[nodiscard]] bool touches(const Eigen::Vector3f& l, const Eigen::Vector3f& h) const {
      return low.x() <= h.x() && high.x() >= l.x() && low.y() <= h.y() && high.y() >= l.y() &&
             low.z() <= h.z() && high.z() >= l.z();
    }
  };
  static constexpr std::uint32_t kGroupsInRegion = 16;  ///< A layout for speed; no result depends on it.

  void sort_by_cube();
  void add_bucket(std::uint32_t begin, std::uint32_t end, const Eigen::Vector3f& low,
                  const Eigen::Vector3f& high);
  void end_group(std::uint32_t first_bucket, const Eigen::Vector3f& low, const Eigen::Vector3f& high);

  std::vector<Eigen::Vector3f> points_;
  std::vector<ObstacleKind> kinds_;
  std::optional<hal::Plane> ground_;
  std::vector<Bucket> buckets_;
  std::vector<Span> groups_, regions_;
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
    v("reach_m", reach_m, hal::Range{0, 5}, "Max distance of obstacle points from the object's box (m).");
    v("ground_band_m", ground_band_m, hal::Range{0, 0.2},
      "Max height of the ground's points over the ground plane (m).");
    v("ground_sigmas", ground_sigmas, hal::Range{0, 20}, "The same in standard deviations of the depth.");
    v("min_support", min_support, hal::Range{0, 8},
      "Min number of neighbours in the image at its own depth of a point that is kept.");
    v("support_sigmas", support_sigmas, hal::Range{0, 50},
      "Max depth difference of such neighbours, in standard deviations of the depth noise.");
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
