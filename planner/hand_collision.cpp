#include "planner/hand_collision.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::planner {
namespace {

constexpr double kSampleStep = 0.015;

/// The grasped feature, in H.
bool in_feature(const HandPlacement& placement, double y, double z) {
  return std::abs(y) <= 0.5 * placement.width_m + placement.margin_m &&
         z >= placement.gap_m - placement.margin_m;
}

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

bool inside(const hal::OrientedBox& box, const Vec3& p, double shrink) {
  const Vec3 local = box.axes.transpose() * (p - box.center);
  return ((0.5 * box.size.array() - shrink) - local.array().abs()).minCoeff() > 0.0;
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
      return fmt::format("{} would move through space that was not seen: {:.0f} % of its way before the face",
                         part, 100.0 * depth_m);
    case With::Reach:
      return fmt::format("{} would reach {:.0f} mm into space that was not seen", part, mm);
    case With::Completed:
      return fmt::format("{} would close {:.0f} mm inside the object's hidden part", part, mm);
  }
  return part;
}

HandCollision::HandCollision(const HandModel& hand, const CollisionConfig& config)
    : hand_(hand),
      config_(config),
      sweep_(hand, config.approach_m, config.closing_step_deg, Obstacles::kCellRadius + 1e-5) {
  sample_volume();
}

HandPlacement HandCollision::place(const GraspCandidate& candidate, const SeenSpace* seen) const {
  const double gap = hand_.gap(candidate);
  double margin = config_.feature_margin_m;
  if (seen != nullptr) margin = std::max(margin, config_.feature_sigmas * seen->sigma(candidate.position));
  // the palm itself is never excused
  return {hand_pose(candidate, hand_), candidate.width, gap, std::min(margin, 0.75 * gap)};
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

std::optional<Collision> HandCollision::check(const HandPlacement& placement,
                                              const Obstacles& obstacles) const {
  const int last = sweep_.last_step(placement.width_m);
  if (auto ground = check_ground(placement, obstacles, last)) return ground;

  const IntoHand into(placement.X_WH);
  const hal::Aabb around = hal::Aabb(sweep_.bounds()).transformed(placement.X_WH);
  const hal::Aabb widened(around.min() - Vec3::Constant(1e-4), around.max() + Vec3::Constant(1e-4));
  Worst worst;
  const std::vector<Eigen::Vector3f>& points = obstacles.points();
  obstacles.for_each_bucket(widened, [&](const Obstacles::Bucket& bucket) {
    const Vec3 c = into(bucket.center);
    if (sweep_.cell_step(c.x(), c.y(), c.z()) > last) return;
    for (std::uint32_t i = bucket.begin; i < bucket.end; ++i) {
      const Vec3 p = into(points[i]);
      const int from = sweep_.point_step(p.x(), p.y(), p.z());
      if (from > last || in_feature(placement, p.y(), p.z())) continue;
      if (const auto hit = sweep_.first_hit(p, last, from)) worst.offer(*hit, i);
    }
  });
  return report(worst, obstacles, sweep_);
}

std::optional<Collision> HandCollision::check_exact(const HandPlacement& placement,
                                                    const Obstacles& obstacles) const {
  const int last = sweep_.last_step(placement.width_m);
  if (auto ground = check_ground(placement, obstacles, last)) return ground;
  const IntoHand into(placement.X_WH);
  Worst worst;
  for (std::size_t i = 0; i < obstacles.size(); ++i) {
    const Vec3 p = into(obstacles.points()[i]);
    if (!sweep_.bounds().contains(p) || in_feature(placement, p.y(), p.z())) continue;
    if (const auto hit = sweep_.first_hit(p, last)) worst.offer(*hit, i);
  }
  return report(worst, obstacles, sweep_);
}

void HandCollision::sample_volume() {
  // a point for every 15 mm of the volume, with the first part and step that takes it
  const hal::Aabb& b = sweep_.bounds();
  for (double z = b.min().z(); z <= b.max().z(); z += kSampleStep) {
    for (double y = b.min().y(); y <= b.max().y(); y += kSampleStep) {
      for (double x = b.min().x(); x <= b.max().x(); x += kSampleStep) {
        const Vec3 p(x, y, z);
        const int from = sweep_.point_step(x, y, z);
        if (from > sweep_.steps()) continue;
        // the body counts as one part
        if (const auto hit = sweep_.first_hit(p, sweep_.steps(), from)) {
          samples_.push_back({p, hit->part < sweep_.fixed_parts() ? 0 : hit->part, hit->step});
        }
      }
    }
  }
}

std::optional<Collision> HandCollision::check_unseen(const HandPlacement& placement, const SeenSpace& seen,
                                                     const CompletedSolids& solids) const {
  const int last = sweep_.last_step(placement.width_m);
  struct Tally {
    int before = 0, unseen = 0;
    double reach_m = 0.0, filled_m = 0.0;
    Vec3 at = Vec3::Zero();
  };
  const SeenSpace::View view = seen.from(placement.X_WH);
  std::vector<Tally> tally(static_cast<std::size_t>(sweep_.parts()));
  for (const Sample& sample : samples_) {
    if (sample.step > last || in_feature(placement, sample.p_H.y(), sample.p_H.z())) continue;
    Tally& part = tally[static_cast<std::size_t>(sample.part)];
    const double behind = sample.p_H.z() - placement.gap_m;
    const bool before = behind <= 0.0;
    const Sight sight = view.at(sample.p_H);
    const bool hidden = sight == Sight::Hidden || sight == Sight::Unknown;
    if (before) ++part.before;
    if (!hidden) continue;
    if (before) {
      ++part.unseen;
      part.at = placement.X_WH * sample.p_H;
    } else {
      const Vec3 p_W = placement.X_WH * sample.p_H;
      part.reach_m = std::max(part.reach_m, behind);
      for (const CompletedSolid& completed : solids) {
        const hal::OrientedBox& solid = completed.box;
        if (inside(solid, p_W, placement.margin_m)) {
          const Vec3 local = solid.axes.transpose() * (p_W - solid.center);
          part.filled_m =
              std::max(part.filled_m, (0.5 * solid.size.array() - local.array().abs()).minCoeff());
        }
      }
    }
  }
  for (std::size_t i = 0; i < tally.size(); ++i) {
    const Tally& part = tally[i];
    const std::string& name = sweep_.part_name(static_cast<int>(i));
    if (part.unseen > config_.unseen_fraction * part.before) {
      const double fraction = static_cast<double>(part.unseen) / part.before;
      return Collision{Collision::With::Unseen, name, fraction, part.at};
    }
    if (part.filled_m > 0.0) return Collision{Collision::With::Completed, name, part.filled_m, part.at};
    if (part.reach_m > config_.max_unseen_m)
      return Collision{Collision::With::Reach, name, part.reach_m, part.at};
  }
  return std::nullopt;
}

}  // namespace colift::planner
