#include "planner/hand/hand_collision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::planner {
namespace {

/// Of a bucket, with what single precision may add.
constexpr double kBall = Obstacles::kCellRadius + 2e-5;

constexpr double kThinPanel = 0.3;  // of a completed solid's least thickness

/// The grasped feature, in H.
bool in_feature(const HandPlacement& placement, double y, double z) {
  return std::abs(y) <= 0.5 * placement.width_m + placement.margin_m &&
         z >= placement.gap_m - placement.margin_m;
}

/// Where fingers that meet the object as they close have taken hold of it and stop.
struct Hold {
  Hold(const HandPlacement& placement, const HandSweep& sweep) {
    if (placement.ragged_m <= 0.0) return;
    const double allowance = placement.margin_m + placement.ragged_m;
    from_step = std::max(1, sweep.last_step(placement.width_m + 2.0 * allowance));
    from_z = placement.gap_m - allowance;
    face_y = 0.5 * placement.width_m + placement.margin_m;
  }
  [[nodiscard]] bool takes(const SweepHit& hit, const Vec3& p_H, ObstacleKind kind) const {
    if (hit.step == 0 || kind != ObstacleKind::Object || p_H.z() < from_z) return false;
    return hit.step >= from_step || std::abs(p_H.y()) <= face_y;
  }
  int from_step = std::numeric_limits<int>::max();
  double from_z = std::numeric_limits<double>::infinity();
  double face_y = 0.0;  ///< Up to there a finger touches the grasped face itself.
};

/// From W into H in one fixed order of operations, so that every path gives the same bits.
struct IntoHand {
  explicit IntoHand(const Pose& X_WH) : R(X_WH.linear()), t(X_WH.translation()) {}
  [[nodiscard]] Vec3 operator()(const Eigen::Vector3f& p) const {
    const double x = p.x() - t.x(), y = p.y() - t.y(), z = p.z() - t.z();
    return {R(0, 0) * x + R(1, 0) * y + R(2, 0) * z, R(0, 1) * x + R(1, 1) * y + R(2, 1) * z,
            R(0, 2) * x + R(1, 2) * y + R(2, 2) * z};
  }
  Eigen::Matrix3d R;
  Vec3 t;
};

/// The same to a few micrometres, for look-ups.
struct IntoHandCoarsely {
  explicit IntoHandCoarsely(const Pose& X_WH)
      : R(X_WH.linear().transpose().cast<float>()), t(X_WH.translation().cast<float>()) {}
  [[nodiscard]] Eigen::Vector3f operator()(const Eigen::Vector3f& p) const {
    const float x = p.x() - t.x(), y = p.y() - t.y(), z = p.z() - t.z();
    return {R(0, 0) * x + R(0, 1) * y + R(0, 2) * z, R(1, 0) * x + R(1, 1) * y + R(1, 2) * z,
            R(2, 0) * x + R(2, 1) * y + R(2, 2) * z};
  }
  Eigen::Matrix3f R;
  Eigen::Vector3f t;
};

/// The hit to report: before closing beats while closing, then the deepest, then the first point.
struct Worst {
  std::optional<SweepHit> hit;
  std::size_t point = 0;

  void offer(const SweepHit& other, std::size_t index) {
    if (hit) {
      const bool closing = hit->step > 0, other_closing = other.step > 0;
      if (closing != other_closing) {
        if (other_closing) return;
      } else if (other.depth_m < hit->depth_m || (other.depth_m == hit->depth_m && index > point)) {
        return;
      }
    }
    hit = other;
    point = index;
  }
};

std::optional<Collision> report(const Worst& worst, const Obstacles& obstacles, const HandSweep& sweep) {
  if (!worst.hit) return std::nullopt;
  Collision c;
  c.with = obstacles.kind(worst.point) == ObstacleKind::Object ? Collision::With::Object
                                                               : Collision::With::Surroundings;
  c.part = sweep.part_name(worst.hit->part);
  c.depth_m = worst.hit->depth_m;
  c.at = obstacles.points()[worst.point].cast<double>();
  return c;
}

/// Negative outside.
double depth_inside(const hal::OrientedBox& box, const Vec3& p) {
  const Vec3 local = box.axes.transpose() * (p - box.center);
  return (0.5 * box.size.array() - local.array().abs()).minCoeff();
}

}  // namespace

std::string Collision::text() const {
  const double mm = 1000.0 * depth_m;
  switch (with) {
    case With::Object:
      return fmt::format("{} meets the object {:.0f} mm inside", part, mm);
    case With::Surroundings:
      return fmt::format("{} meets something beside the object {:.0f} mm inside", part, mm);
    case With::Ground:
      return mm > 0.0 ? fmt::format("{} meets the ground {:.0f} mm deep", part, mm)
                      : fmt::format("{} passes {:.0f} mm above the ground, too near", part, -mm);
    case With::Unseen:
      return fmt::format("{} would move through unobserved space: {:.0f} % of its path before the face", part,
                         100.0 * depth_m);
    case With::Reach:
      return fmt::format("{} would reach {:.0f} mm into unobserved space", part, mm);
    case With::Completed:
      return fmt::format("{} would close {:.0f} mm inside the object's hidden part", part, mm);
  }
  return std::string(part);
}

HandCollision::HandCollision(const HandModel& hand, const CollisionConfig& config)
    : hand_(hand), config_(config), sweep_(hand, config.approach_m, config.closing_step_deg, kBall) {
  sample_volume();
}

HandPlacement HandCollision::place(const GraspCandidate& candidate, const SeenSpace* seen) const {
  const double gap = hand_.gap(candidate);
  double margin = config_.feature_margin_m, ragged = 0.0;
  if (seen != nullptr) {
    margin = std::max(margin, config_.feature_sigmas * seen->sigma(candidate.position));
    ragged = config_.ragged_px * seen->pixel_m(candidate.position);
  }
  // the palm itself is never excused
  return {hand_pose(candidate, hand_), candidate.width, gap, std::min(margin, 0.75 * gap), ragged};
}

std::optional<Collision> HandCollision::check_ground(const HandPlacement& placement,
                                                     const Obstacles& obstacles, int last) const {
  if (!obstacles.ground()) return std::nullopt;
  const hal::Plane plane_H = obstacles.ground()->in(placement.X_WH.inverse());
  const HandSweep::Lowest lowest = sweep_.lowest(plane_H, last);
  if (lowest.height_m >= config_.ground_clearance_m) return std::nullopt;
  const Vec3 at = obstacles.ground()->foot(placement.X_WH.translation());
  return Collision{Collision::With::Ground, sweep_.part_name(lowest.part), -lowest.height_m, at};
}

std::optional<Collision> HandCollision::check(const HandPlacement& placement, const Obstacles& obstacles,
                                              double enough_m) const {
  const int last = sweep_.last_step(placement.width_m);
  const hal::Aabb around = hal::Aabb(sweep_.bounds()).transformed(placement.X_WH);
  if (obstacles.ground() && sweep_.bounds_height(obstacles.ground()->in(placement.X_WH.inverse())) <
                                config_.ground_clearance_m + 1e-9) {
    if (auto ground = check_ground(placement, obstacles, last)) return ground;
  }

  const IntoHand into(placement.X_WH);
  const IntoHandCoarsely coarsely(placement.X_WH);
  const hal::Aabb widened(around.min() - Vec3::Constant(1e-4), around.max() + Vec3::Constant(1e-4));
  const auto feature_y = static_cast<float>(0.5 * placement.width_m + placement.margin_m - kBall);
  const auto feature_z = static_cast<float>(placement.gap_m - placement.margin_m + kBall);
  const Hold hold(placement, sweep_);
  Worst worst;
  int look_until = last;
  bool enough = false;
  const std::vector<Eigen::Vector3f>& points = obstacles.points();
  obstacles.for_each_bucket(widened, [&](const Obstacles::Bucket& bucket) {
    if (enough) return;
    const Eigen::Vector3f c = coarsely(bucket.center);
    if (sweep_.cell_step(c.x(), c.y(), c.z()) > look_until) return;
    if (std::abs(c.y()) <= feature_y && c.z() >= feature_z) return;
    for (std::uint32_t i = bucket.begin; i < bucket.end; ++i) {
      const Eigen::Vector3f near_p = coarsely(points[i]);
      if (sweep_.point_step(near_p.x(), near_p.y(), near_p.z()) > look_until) continue;
      const Vec3 p = into(points[i]);
      if (in_feature(placement, p.y(), p.z())) continue;
      const bool closing = worst.hit && worst.hit->step > 0;
      const auto hit = sweep_.quick_hit(p, look_until, closing ? worst.hit->depth_m : 0.0);
      if (!hit || hold.takes(*hit, p, obstacles.kind(i))) continue;
      worst.offer(*hit, i);
      // what is met before the fingers close leaves no room for what they would meet
      if (worst.hit->step == 0) look_until = 0;
      if (worst.hit->depth_m >= enough_m) {
        enough = true;
        return;
      }
    }
  });
  return report(worst, obstacles, sweep_);
}

std::optional<Collision> HandCollision::check_exact(const HandPlacement& placement,
                                                    const Obstacles& obstacles) const {
  const int last = sweep_.last_step(placement.width_m);
  if (auto ground = check_ground(placement, obstacles, last)) return ground;
  const IntoHand into(placement.X_WH);
  const Hold hold(placement, sweep_);
  Worst worst;
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const Vec3 p = into(obstacles.points()[i]);
    if (!sweep_.bounds().contains(p) || in_feature(placement, p.y(), p.z())) continue;
    const auto hit = sweep_.first_hit(p, last);
    if (hit && !hold.takes(*hit, p, obstacles.kind(i))) worst.offer(*hit, i);
  }
  return report(worst, obstacles, sweep_);
}

void HandCollision::sample_volume() {
  const double sample_m = config_.unseen_sample_m;
  // points on a grid in the volume, with the first part and step that takes it
  struct Sample {
    Vec3 p;
    int part, step;
  };
  std::vector<Sample> all;
  const hal::Aabb& b = sweep_.bounds();
  for (double z = b.min().z(); z <= b.max().z(); z += sample_m) {
    for (double y = b.min().y(); y <= b.max().y(); y += sample_m) {
      for (double x = b.min().x(); x <= b.max().x(); x += sample_m) {
        // the body counts as one part
        if (const auto hit = sweep_.quick_hit({x, y, z}, sweep_.steps())) {
          all.push_back({{x, y, z}, hit->part < sweep_.fixed_parts() ? 0 : hit->part, hit->step});
        }
      }
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const Sample& m, const Sample& n) { return m.step < n.step; });
  samples_.resize(static_cast<std::size_t>(sweep_.parts()));
  for (const Sample& sample : all) {
    Samples& part = samples_[static_cast<std::size_t>(sample.part)];
    part.x.push_back(static_cast<float>(sample.p.x()));
    part.y.push_back(static_cast<float>(sample.p.y()));
    part.z.push_back(static_cast<float>(sample.p.z()));
    part.step.push_back(static_cast<std::uint8_t>(sample.step));
  }
}

std::optional<Collision> HandCollision::check_unseen(const HandPlacement& placement, const SeenSpace& seen,
                                                     const CompletedSolids& solids) const {
  const int last = sweep_.last_step(placement.width_m);
  const SeenSpace::View view = seen.from(placement.X_WH);
  const auto feature_y = static_cast<float>(0.5 * placement.width_m + placement.margin_m);
  const auto feature_z = static_cast<float>(placement.gap_m - placement.margin_m);
  const auto gap = static_cast<float>(placement.gap_m);
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    const Samples& s = samples_[i];
    const auto count = static_cast<std::size_t>(
        std::upper_bound(s.step.begin(), s.step.end(), static_cast<std::uint8_t>(last)) - s.step.begin());
    int before = 0, unseen = 0;
    double reach_m = 0.0, filled_m = 0.0;
    Vec3 at = Vec3::Zero();
    for (std::size_t k = 0; k < count; ++k) {
      const float x = s.x[k], y = s.y[k], z = s.z[k];
      if (z >= feature_z && std::abs(y) <= feature_y) continue;
      const bool is_before = z <= gap;
      before += is_before;
      if (!view.hides(x, y, z)) continue;
      const Vec3 p_W = placement.X_WH * Vec3(x, y, z);
      if (is_before) {
        ++unseen;
        at = p_W;
        continue;
      }
      reach_m = std::max(reach_m, static_cast<double>(z) - placement.gap_m);
      for (const CompletedSolid& solid : solids) {
        const double depth = depth_inside(solid.box, p_W);
        // of a panel thinner than these allowances, its middle
        const double allowed =
            std::min(placement.margin_m + placement.ragged_m, kThinPanel * solid.box.size.minCoeff());
        if (depth > allowed) filled_m = std::max(filled_m, depth);
      }
    }
    const std::string& name = sweep_.part_name(static_cast<int>(i));
    if (unseen > config_.unseen_fraction * before) {
      return Collision{Collision::With::Unseen, name, static_cast<double>(unseen) / before, at};
    }
    if (filled_m > 0.0) return Collision{Collision::With::Completed, name, filled_m, at};
    if (reach_m > config_.max_unseen_m) return Collision{Collision::With::Reach, name, reach_m, at};
  }
  return std::nullopt;
}

}  // namespace colift::planner
