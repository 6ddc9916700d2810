#include "planner/hand/obstacles.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace colift::planner {
namespace {

using Eigen::Vector3f;

constexpr float kFar = std::numeric_limits<float>::max();

struct Bounds {
  Vector3f low = Vector3f::Constant(kFar), high = Vector3f::Constant(-kFar);
  void extend(const Vector3f& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void extend(const Bounds& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  [[nodiscard]] bool fits_a_bucket() const {
    constexpr auto kDiameter = static_cast<float>(2.0 * Obstacles::kCellRadius - 1e-5);
    return (high - low).squaredNorm() <= kDiameter * kDiameter;
  }
};

}  // namespace

void Obstacles::add(const Vector3f& p, ObstacleKind kind) {
  points_.push_back(p);
  kinds_.push_back(kind);
}

Obstacles::Room Obstacles::make_room(std::size_t points) {
  const std::size_t before = points_.size();
  points_.resize(before + points);
  kinds_.resize(before + points);
  return {points_.data() + before, kinds_.data() + before};
}

void Obstacles::keep(std::size_t points) {
  points_.resize(points);
  kinds_.resize(points);
}

void Obstacles::add_bucket(std::uint32_t begin, std::uint32_t end, const Vector3f& low,
                           const Vector3f& high) {
  buckets_.push_back({begin, end, 0.5f * (low + high)});
}

void Obstacles::end_group(std::uint32_t first_bucket, const Vector3f& low, const Vector3f& high) {
  const auto group = static_cast<std::uint32_t>(groups_.size());
  groups_.push_back({first_bucket, static_cast<std::uint32_t>(buckets_.size()), low, high});
  if (group % kGroupsInRegion == 0) {
    regions_.push_back({group, group + 1, low, high});
    return;
  }
  Span& region = regions_.back();
  region.end = group + 1;
  region.low = region.low.cwiseMin(low);
  region.high = region.high.cwiseMax(high);
}

void Obstacles::close_group(const std::vector<Run>& runs) {
  const auto first_bucket = static_cast<std::uint32_t>(buckets_.size());
  std::uint32_t begin = first_bucket == 0 ? 0 : buckets_.back().end;
  Bounds all;
  for (const auto& [end, fits, low, high] : runs) {
    if (fits) {
      if (end == begin) continue;
      add_bucket(begin, end, low, high);
      all.extend(Bounds{low, high});
      begin = end;
      continue;
    }
    Bounds run;
    for (std::uint32_t i = begin; i < end; ++i) {
      Bounds longer = run;
      longer.extend(points_[i]);
      if (i > begin && !longer.fits_a_bucket()) {
        add_bucket(begin, i, run.low, run.high);
        all.extend(run);
        begin = i;
        run = Bounds{points_[i], points_[i]};
      } else {
        run = longer;
      }
    }
    if (end > begin) {
      add_bucket(begin, end, run.low, run.high);
      all.extend(run);
    }
    begin = end;
  }
  if (buckets_.size() > first_bucket) end_group(first_bucket, all.low, all.high);
}

void Obstacles::sort_by_cube() {
  constexpr float kPerMetre = 100.0f;  // a cube's diagonal fits into a bucket
  Bounds all;
  for (const Vector3f& p : points_) all.extend(p);
  // stable counting sorts by x, y and z: linear, and small even when the object fills a hall
  std::vector<std::uint32_t> order(points_.size()), next(points_.size()), begin;
  std::iota(order.begin(), order.end(), 0u);
  for (int axis = 0; axis < 3; ++axis) {
    const auto cell = [&](std::uint32_t i) {
      return static_cast<std::size_t>((points_[i][axis] - all.low[axis]) * kPerMetre);
    };
    const auto cells = static_cast<std::size_t>((all.high[axis] - all.low[axis]) * kPerMetre) + 1;
    begin.assign(cells + 1, 0);
    for (const std::uint32_t i : order) ++begin[cell(i) + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    for (const std::uint32_t i : order) next[begin[cell(i)]++] = i;
    order.swap(next);
  }
  std::vector<Vector3f> points(points_.size());
  std::vector<ObstacleKind> kinds(points_.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    points[i] = points_[order[i]];
    kinds[i] = kinds_[order[i]];
  }
  points_ = std::move(points);
  kinds_ = std::move(kinds);
}

void Obstacles::build() {
  buckets_.clear();
  groups_.clear();
  regions_.clear();
  if (points_.empty()) return;
  sort_by_cube();
  constexpr std::uint32_t kGroup = 256;  // points; a layout for speed, no result depends on it
  const auto n = static_cast<std::uint32_t>(points_.size());
  for (std::uint32_t end = std::min(kGroup, n);; end = std::min(end + kGroup, n)) {
    close_group({{end, false, {}, {}}});
    if (end == n) break;
  }
}

namespace {

/// Goes through an image in tiles of 16 x 16 pixels of 4 x 4 blocks each, and keeps the points that count.
class Gatherer {
 public:
  Gatherer(const perception::Scene& scene, const perception::OrganisedCloud& cloud,
           const ObstacleConfig& config, bool target_by_pixel)
      : scene_(scene), cloud_(cloud), config_(config), target_by_pixel_(target_by_pixel) {
    of_target_.assign(cloud.size(), 0);
    for (const std::uint32_t pixel : scene.target->pixels) {
      if (pixel < cloud.size()) of_target_[pixel] = 1;
    }
    low_ = (scene.target->aabb.min() - hal::Vec3::Constant(config.reach_m)).cast<float>();
    high_ = (scene.target->aabb.max() + hal::Vec3::Constant(config.reach_m)).cast<float>();
    find_window();
  }

  void into(Obstacles& obstacles) {
    // squares of 4 x 4 tiles, so that consecutive groups lie side by side
    before_ = count_ = obstacles.size();
    room_ = obstacles.make_room(static_cast<std::size_t>(u1_ - u0_) * static_cast<std::size_t>(v1_ - v0_));
    for (int v = v0_; v < v1_; v += 4 * kTile) {
      for (int u = u0_; u < u1_; u += 4 * kTile) {
        for (int j = 0; j < 4; ++j) {
          for (int i = 0; i < 4; ++i) tile(obstacles, u + kTile * i, v + kTile * j);
        }
      }
    }
    obstacles.keep(count_);
  }

 private:
  static constexpr int kTile = 16, kBlock = 4;

  /// The part of the image where the region may be seen.
  void find_window() {
    u0_ = v0_ = 0;
    u1_ = cloud_.width();
    v1_ = cloud_.height();
    double u_low = 1e9, u_high = -1e9, v_low = 1e9, v_high = -1e9;
    const hal::Pose X_CW = cloud_.X_WC.inverse();
    for (int corner = 0; corner < 8; ++corner) {
      const hal::Vec3 p(corner & 1 ? high_.x() : low_.x(), corner & 2 ? high_.y() : low_.y(),
                        corner & 4 ? high_.z() : low_.z());
      const hal::Vec3 c = X_CW * p;
      if (!(c.z() > 0.05)) return;  // the camera is in or beside it: anywhere
      const double u = cloud_.intrinsics.fx * c.x() / c.z() + cloud_.intrinsics.cx;
      const double v = cloud_.intrinsics.fy * c.y() / c.z() + cloud_.intrinsics.cy;
      u_low = std::min(u_low, u), u_high = std::max(u_high, u);
      v_low = std::min(v_low, v), v_high = std::max(v_high, v);
    }
    u0_ = static_cast<int>(std::clamp(u_low - 2.0, 0.0, u1_ + 0.0));
    v0_ = static_cast<int>(std::clamp(v_low - 2.0, 0.0, v1_ + 0.0));
    u1_ = static_cast<int>(std::clamp(u_high + 3.0, 0.0, u1_ + 0.0));
    v1_ = static_cast<int>(std::clamp(v_high + 3.0, 0.0, v1_ + 0.0));
  }

  void tile(Obstacles& obstacles, int u, int v) {
    if (u >= u1_ || v >= v1_) return;
    // blocks in the order of their quadrants, so that a quadrant's points stand together
    constexpr int kAcross[16] = {0, 1, 0, 1, 2, 3, 2, 3, 0, 1, 0, 1, 2, 3, 2, 3};
    constexpr int kDown[16] = {0, 0, 1, 1, 0, 0, 1, 1, 2, 2, 3, 3, 2, 2, 3, 3};
    std::array<Bounds, 16> bounds;
    std::array<std::uint32_t, 17> end{};
    end[0] = static_cast<std::uint32_t>(count_);
    for (std::size_t b = 0; b < 16; ++b) {
      block(u + kBlock * kAcross[b], v + kBlock * kDown[b], bounds[b]);
      end[b + 1] = static_cast<std::uint32_t>(count_);
    }
    if (end[16] == end[0]) return;
    runs_.clear();
    const auto add = [&](std::size_t first, std::size_t count, bool whole) {
      if (end[first] == end[first + count]) return true;
      Bounds all;
      for (std::size_t b = first; b < first + count; ++b) all.extend(bounds[b]);
      const bool fits = all.fits_a_bucket();
      if (fits || whole) runs_.push_back({end[first + count], fits, all.low, all.high});
      return fits;
    };
    if (!add(0, 16, false)) {
      for (std::size_t q = 0; q < 16; q += 4) {
        if (add(q, 4, false)) continue;
        for (std::size_t b = q; b < q + 4; ++b) add(b, 1, true);
      }
    }
    obstacles.close_group(runs_);
  }

  void block(int u0, int v0, Bounds& bounds) {
    const int u1 = std::min(u0 + kBlock, u1_), v1 = std::min(v0 + kBlock, v1_);
    for (int v = v0; v < v1; ++v) {
      for (int u = u0; u < u1; ++u) {
        const auto pixel = static_cast<std::size_t>(v * cloud_.width() + u);
        const bool of_target = of_target_[pixel] != 0;
        if (of_target ? !target_by_pixel_ : !counts(u, v, pixel)) continue;
        const Vector3f p(cloud_.x[pixel], cloud_.y[pixel], cloud_.z[pixel]);
        if (!(p.x() == p.x())) continue;
        bounds.extend(p);
        room_.points[count_ - before_] = p;
        room_.kinds[count_ - before_] = of_target ? ObstacleKind::Object : ObstacleKind::Surroundings;
        ++count_;
      }
    }
  }

  /// Whether a pixel beside the object is an obstacle.
  [[nodiscard]] bool counts(int u, int v, std::size_t pixel) const {
    if (!config_.surroundings) return false;
    const float x = cloud_.x[pixel], y = cloud_.y[pixel], z = cloud_.z[pixel];
    // written so that NaN is left out
    if (!(x >= low_.x() && x <= high_.x() && y >= low_.y() && y <= high_.y() && z >= low_.z() &&
          z <= high_.z())) {
      return false;
    }
    const double depth = cloud_.depth_m[pixel], sigma = config_.noise.sigma(depth);
    if (scene_.ground) {
      const double band = std::max(config_.ground_band_m, config_.ground_sigmas * sigma);
      if (std::abs(scene_.ground->plane.height({x, y, z})) <= band) return false;
    }
    const auto tolerance = static_cast<float>(config_.support_sigmas * sigma + config_.noise.step(depth));
    return supported(u, v, tolerance);
  }

  /// True when enough of the eight neighbours lie at a like depth.
  [[nodiscard]] bool supported(int u, int v, float tolerance) const {
    // the four nearest first: on a surface they settle it
    constexpr int kDu[8] = {-1, 1, 0, 0, -1, 1, -1, 1}, kDv[8] = {0, 0, -1, 1, -1, -1, 1, 1};
    const int width = cloud_.width();
    const float* depth = cloud_.depth_m.data() + static_cast<std::ptrdiff_t>(v) * width + u;
    int missing = config_.min_support;
    if (u > 0 && v > 0 && u + 1 < width && v + 1 < cloud_.height()) {
      for (int k = 0; k < 8 && missing > 0; ++k) {
        missing -= std::abs(depth[kDv[k] * width + kDu[k]] - *depth) <= tolerance;  // not for NaN
      }
      return missing <= 0;
    }
    for (int k = 0; k < 8 && missing > 0; ++k) {
      const int nu = u + kDu[k], nv = v + kDv[k];
      if (nu < 0 || nv < 0 || nu >= width || nv >= cloud_.height()) continue;
      if (std::abs(depth[kDv[k] * width + kDu[k]] - *depth) <= tolerance) --missing;  // not for NaN
    }
    return missing <= 0;
  }

  const perception::Scene& scene_;
  const perception::OrganisedCloud& cloud_;
  const ObstacleConfig& config_;
  bool target_by_pixel_;
  std::vector<std::uint8_t> of_target_;
  Vector3f low_, high_;
  int u0_, u1_, v0_, v1_;
  std::vector<Obstacles::Run> runs_;
  Obstacles::Room room_{};
  std::size_t before_ = 0, count_ = 0;  ///< Points that were there before, and that there are now.
};

}  // namespace

Obstacles gather_obstacles(const perception::Scene& scene, const perception::OrganisedCloud* cloud,
                           const ObstacleConfig& config) {
  Obstacles obstacles;
  if (scene.ground) obstacles.set_ground(scene.ground->plane);
  if (!scene.target) return obstacles;
  const perception::Target& target = *scene.target;
  const bool by_pixel = cloud != nullptr && target.pixels.size() == target.points.size();
  if (!by_pixel) {
    for (const auto& p : target.points) obstacles.add(p, ObstacleKind::Object);
    obstacles.build();
  }
  if (cloud != nullptr) Gatherer(scene, *cloud, config, by_pixel).into(obstacles);
  return obstacles;
}

}  // namespace colift::planner
