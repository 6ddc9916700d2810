#include "planner/motion/collision/fast_checker.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "planner/motion/collision/arm_batch.hpp"
#include "planner/motion/collision/carried_target.hpp"
#include "planner/motion/collision/collision_scene.hpp"

namespace colift::planner {
namespace {

using hal::JointVector;
using With = Touch::With;

/// A limit that is passed by this much is not passed (rad): rounding of measured and planned positions.
constexpr double kLimitSlack = 1e-6;
// carried by A6 or A7: where the hand goes, the wrist has to go too, and the rule for unseen space is the
// hand's
constexpr int kWrist = 6;

/// From when on a look-up is enough, for a sphere of a given radius.
struct Bound {
  float radius_m = 0.0f;
  std::int16_t enough = 0;
};

Bound bound(const DistanceField& field, float radius_m) {
  return {radius_m, field.enough(radius_m)};
}

}  // namespace

struct FastChecker::Impl {
  Impl(const hal::RobotModel& robot, const SphereModel& spheres, std::shared_ptr<const CollisionScene> world)
      : model(robot), bodies(robot, spheres), scene(std::move(world)), carried(*scene) {
    lower = model.lower_rad().array() - kLimitSlack;
    upper = model.upper_rad().array() + kLimitSlack;
    std::vector<int> group_of(model.links.size(), -1);
    for (std::size_t g = 0; g < bodies.groups.size(); ++g) {
      group_of[static_cast<std::size_t>(bodies.groups[g].link)] = static_cast<int>(g);
    }
    for (const auto& [a, b] : spheres.self_pairs) {
      pairs.emplace_back(group_of[static_cast<std::size_t>(a)], group_of[static_cast<std::size_t>(b)]);
    }
    set_bounds();
  }

  hal::RobotModel model;
  ArmBodies bodies;
  std::shared_ptr<const CollisionScene> scene;
  CarriedTarget carried;
  Contacts contacts = Contacts::None;
  JointVector lower, upper;
  std::vector<std::pair<int, int>> pairs;  // groups that can meet
  std::vector<Bound> group_obstacle, sphere_obstacle, group_target, sphere_target;
  ArmBatch<4> few;
  ArmBatch<16> many;
  std::array<JointVector, 4> few_q;
  std::array<JointVector, 16> many_q;
  std::size_t checks = 0;

  void set_bounds() {
    const auto margin = static_cast<float>(scene->config.margin_m);
    const std::size_t groups = bodies.groups.size(), spheres = bodies.radius_m.size();
    group_obstacle.resize(groups);
    group_target.resize(groups);
    sphere_obstacle.resize(spheres);
    sphere_target.resize(spheres);
    for (std::size_t g = 0; g < groups; ++g) {
      const SphereGroup& group = bodies.groups[g];
      group_obstacle[g] = bound(obstacles_of(group), group.radius_m + margin);
      group_target[g] = bound(scene->target, group.radius_m + margin);
      for (int i = group.first; i < group.first + group.count; ++i) {
        const auto s = static_cast<std::size_t>(i);
        sphere_obstacle[s] = bound(obstacles_of(group), bodies.radius_m[s] + margin);
        sphere_target[s] = bound(scene->target, bodies.radius_m[s] + margin);
      }
    }
  }

  [[nodiscard]] const DistanceField& obstacles_of(const SphereGroup& group) const {
    return group.body >= kWrist ? scene->obstacles : scene->arm_obstacles;
  }
  [[nodiscard]] bool within_limits(const JointVector& q) const {
    return (q.array() >= lower.array()).all() && (q.array() <= upper.array()).all();
  }
  [[nodiscard]] bool meets_target(const SphereGroup& group) const {
    return contacts == Contacts::None || (contacts == Contacts::FingersOnTarget && !group.in_hand);
  }

  /// Asks `touch(with, group, sphere, lane, depth_m)` for all that the batch touches; a true answer ends the
  /// search and is returned.
  template <std::size_t N, class OnTouch>
  bool search(ArmBatch<N>& batch, OnTouch&& touch);
  template <std::size_t N, class OnTouch>
  bool search_field(ArmBatch<N>& batch, const DistanceField& field, With with, std::size_t g,
                    const std::vector<Bound>& of_group, const std::vector<Bound>& of_sphere, OnTouch&& touch);
  template <std::size_t N, class OnTouch>
  bool search_ground(ArmBatch<N>& batch, std::size_t g, OnTouch&& touch);
  template <std::size_t N, class OnTouch>
  bool search_pair(ArmBatch<N>& batch, std::size_t a, std::size_t b, OnTouch&& touch);
  template <std::size_t N, class OnTouch>
  bool search_carried(ArmBatch<N>& batch, OnTouch&& touch);

  template <std::size_t N>
  bool all_free(ArmBatch<N>& batch, const std::array<JointVector, N>& q, std::size_t states) {
    checks += states;
    batch.set_joints(bodies, q, states);
    return !search(batch, [](With, std::size_t, std::size_t, std::size_t, float) { return true; });
  }
};

template <std::size_t N, class OnTouch>
bool FastChecker::Impl::search_field(ArmBatch<N>& batch, const DistanceField& field, With with, std::size_t g,
                                     const std::vector<Bound>& of_group, const std::vector<Bound>& of_sphere,
                                     OnTouch&& touch) {
  if (field.empty()) return false;
  std::int16_t squared[N];
  const auto none_near = [&](const typename ArmBatch<N>::Point& p, std::int16_t enough) {
    field.look_up(p.x.data(), p.y.data(), p.z.data(), static_cast<int>(batch.used), squared);
    std::int16_t least = squared[0];
    for (std::size_t l = 1; l < batch.used; ++l) least = std::min(least, squared[l]);
    return least >= enough;
  };
  if (none_near(batch.group[g], of_group[g].enough)) return false;
  batch.place(bodies, g);
  const SphereGroup& group = bodies.groups[g];
  for (int i = group.first; i < group.first + group.count; ++i) {
    const auto s = static_cast<std::size_t>(i);
    if (none_near(batch.sphere[s], of_sphere[s].enough)) continue;
    for (std::size_t l = 0; l < batch.used; ++l) {
      if (squared[l] >= of_sphere[s].enough) continue;
      const Eigen::Vector3f p(batch.sphere[s].x[l], batch.sphere[s].y[l], batch.sphere[s].z[l]);
      if (field.clear(p, of_sphere[s].radius_m)) continue;
      if (touch(with, g, s, l, of_sphere[s].radius_m - field.distance(p))) return true;
    }
  }
  return false;
}

template <std::size_t N, class OnTouch>
bool FastChecker::Impl::search_ground(ArmBatch<N>& batch, std::size_t g, OnTouch&& touch) {
  const Eigen::Vector3f n = scene->ground.normal.cast<float>();
  const auto offset = static_cast<float>(scene->ground.offset - scene->config.ground_clearance_m);
  const auto min_height = [&](const typename ArmBatch<N>::Point& p, typename ArmBatch<N>::Lanes& height) {
    float least = 1e9f;
    for (std::size_t l = 0; l < N; ++l) height[l] = n.x() * p.x[l] + n.y() * p.y[l] + n.z() * p.z[l] + offset;
    for (std::size_t l = 0; l < N; ++l) least = std::min(least, height[l]);
    return least;
  };
  typename ArmBatch<N>::Lanes height;
  const SphereGroup& group = bodies.groups[g];
  if (min_height(batch.group[g], height) >= group.radius_m) return false;
  batch.place(bodies, g);
  for (int i = group.first; i < group.first + group.count; ++i) {
    const auto s = static_cast<std::size_t>(i);
    if (min_height(batch.sphere[s], height) >= bodies.radius_m[s]) continue;
    for (std::size_t l = 0; l < batch.used; ++l) {
      if (height[l] >= bodies.radius_m[s]) continue;
      if (touch(With::Ground, g, s, l, bodies.radius_m[s] - height[l])) return true;
    }
  }
  return false;
}

template <std::size_t N, class OnTouch>
bool FastChecker::Impl::search_pair(ArmBatch<N>& batch, std::size_t a, std::size_t b, OnTouch&& touch) {
  using Point = typename ArmBatch<N>::Point;
  typename ArmBatch<N>::Lanes gap;  // squared distance less the squared reach
  const auto apart = [&](const Point& p, const Point& q, float reach) {
    float least = 1e9f;
    for (std::size_t l = 0; l < N; ++l) {
      const float dx = p.x[l] - q.x[l], dy = p.y[l] - q.y[l], dz = p.z[l] - q.z[l];
      gap[l] = dx * dx + dy * dy + dz * dz - reach * reach;
    }
    for (std::size_t l = 0; l < N; ++l) least = std::min(least, gap[l]);
    return least >= 0.0f;
  };
  const SphereGroup &ga = bodies.groups[a], &gb = bodies.groups[b];
  if (apart(batch.group[a], batch.group[b], ga.radius_m + gb.radius_m)) return false;
  batch.place(bodies, a);
  batch.place(bodies, b);
  for (int i = ga.first; i < ga.first + ga.count; ++i) {
    const auto s = static_cast<std::size_t>(i);
    if (apart(batch.sphere[s], batch.group[b], bodies.radius_m[s] + gb.radius_m)) continue;
    for (int j = gb.first; j < gb.first + gb.count; ++j) {
      const auto t = static_cast<std::size_t>(j);
      const float reach = bodies.radius_m[s] + bodies.radius_m[t];
      if (apart(batch.sphere[s], batch.sphere[t], reach)) continue;
      for (std::size_t l = 0; l < N; ++l) {
        if (gap[l] >= 0.0f) continue;
        // the other sphere is named by its group, which the pair tells
        const float depth = reach - std::sqrt(gap[l] + reach * reach);
        if (touch(With::Itself, a, static_cast<std::size_t>(gb.link), l, depth)) return true;
      }
    }
  }
  return false;
}

template <std::size_t N, class OnTouch>
bool FastChecker::Impl::search_carried(ArmBatch<N>& batch, OnTouch&& touch) {
  for (std::size_t l = 0; l < batch.used; ++l) {
    const Eigen::Isometry3f X_WH = batch.body_pose(hal::kArmJoints, l) * bodies.X_7H;
    const float depth = carried.depth_m(X_WH);
    if (depth > 0.0f && touch(With::Carried, 0, 0, l, depth)) return true;
    // arm links against the target, where the target's field stands: as it was before the lift
    const Eigen::Isometry3f X_back = carried.before_lift(X_WH);
    for (std::size_t g = 0; g < bodies.groups.size(); ++g) {
      const SphereGroup& group = bodies.groups[g];
      if (group.body == 0 || group.in_hand) continue;
      const auto place_of = [&](const typename ArmBatch<N>::Point& p) -> Eigen::Vector3f {
        return X_back * Eigen::Vector3f(p.x[l], p.y[l], p.z[l]);
      };
      if (scene->target.clear(place_of(batch.group[g]), group_target[g].radius_m)) continue;
      batch.place(bodies, g);
      for (int i = group.first; i < group.first + group.count; ++i) {
        const auto s = static_cast<std::size_t>(i);
        const Eigen::Vector3f p = place_of(batch.sphere[s]);
        if (scene->target.clear(p, sphere_target[s].radius_m)) continue;
        if (touch(With::Target, g, s, l, sphere_target[s].radius_m - scene->target.distance(p))) return true;
      }
    }
  }
  return false;
}

template <std::size_t N, class OnTouch>
bool FastChecker::Impl::search(ArmBatch<N>& batch, OnTouch&& touch) {
  // the hand first: it is what meets things
  for (std::size_t g = bodies.groups.size(); g-- > 0;) {
    const SphereGroup& group = bodies.groups[g];
    if (group.body == 0) continue;
    if (group.body > 1 && search_ground(batch, g, touch)) return true;
    if (search_field(batch, obstacles_of(group), With::Obstacle, g, group_obstacle, sphere_obstacle, touch))
      return true;
    if (meets_target(group) &&
        search_field(batch, scene->target, With::Target, g, group_target, sphere_target, touch))
      return true;
  }
  for (const auto& [a, b] : pairs) {
    if (search_pair(batch, static_cast<std::size_t>(a), static_cast<std::size_t>(b), touch)) return true;
  }
  return contacts == Contacts::Carrying && search_carried(batch, touch);
}

FastChecker::FastChecker(const hal::RobotModel& model, const SphereModel& spheres,
                         std::shared_ptr<const CollisionScene> scene)
    : impl_(std::make_unique<Impl>(model, spheres, std::move(scene))) {}
FastChecker::~FastChecker() = default;
FastChecker::FastChecker(FastChecker&&) noexcept = default;

void FastChecker::set_hand(const hal::HandPosture& hand) {
  impl_->bodies.set_hand(impl_->model, hand);
  impl_->set_bounds();
}

void FastChecker::allow(Contacts contacts) {
  impl_->contacts = contacts;
}

void FastChecker::set_carry_origin(const hal::Pose& X_WH) {
  impl_->carried.set_origin(X_WH);
}

bool FastChecker::is_free(const JointVector& q_rad) {
  Impl& m = *impl_;
  if (!m.within_limits(q_rad)) return ++m.checks, false;
  m.few_q.fill(q_rad);
  return m.all_free(m.few, m.few_q, 1);
}

bool FastChecker::is_free(const JointVector& from, const JointVector& to, double step_rad) {
  Impl& m = *impl_;
  if (!m.within_limits(from) || !m.within_limits(to)) return ++m.checks, false;
  const auto steps = static_cast<std::uint32_t>(
      std::max(1.0, std::ceil((to - from).cwiseAbs().maxCoeff() / step_rad - 1e-9)));
  // Middle first, then the quarters, and so on: the binary digits of a counter, reversed. A motion that
  // collides mostly does so around its middle.
  const std::uint32_t places = std::bit_ceil(steps + 1);
  const int digits = std::countr_zero(places);
  std::uint32_t counter = 1, left = steps + 1;
  const auto next = [&]() -> JointVector {
    for (;; ++counter) {
      std::uint32_t k = 0;
      for (int d = 0; d < digits; ++d) k |= ((counter >> d) & 1u) << (digits - 1 - d);
      k &= places - 1;
      if (k > steps) continue;
      ++counter;
      return from + (static_cast<double>(k) / steps) * (to - from);
    }
  };
  const auto run = [&](auto& batch, auto& q) {
    const std::size_t n = std::min<std::size_t>(q.size(), left);
    for (std::size_t i = 0; i < n; ++i) q[i] = next();
    for (std::size_t i = n; i < q.size(); ++i) q[i] = q[0];
    left -= static_cast<std::uint32_t>(n);
    return m.all_free(batch, q, n);
  };
  if (!run(m.few, m.few_q)) return false;
  while (left > m.few_q.size()) {
    if (!run(m.many, m.many_q)) return false;
  }
  return left == 0 || run(m.few, m.few_q);
}

Touch FastChecker::what_touches(const JointVector& q_rad) {
  Impl& m = *impl_;
  Touch worst;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double beyond = std::max(m.lower[i] - q_rad[i], q_rad[i] - m.upper[i]);
    if (beyond <= worst.depth_m && !std::isnan(beyond)) continue;
    const auto link = static_cast<std::size_t>(m.model.arm[static_cast<std::size_t>(i)]);
    worst = {With::Limits, m.model.links[link].joint, beyond};
  }
  ++m.checks;
  if (worst.with != With::Nothing) return worst;
  m.few_q.fill(q_rad);
  m.few.set_joints(m.bodies, m.few_q, 1);
  const auto name = [&](std::size_t link) { return m.model.links[link].name; };
  m.search(m.few, [&](With with, std::size_t g, std::size_t other, std::size_t, float depth) {
    if (worst.with != With::Nothing && depth <= worst.depth_m) return false;
    std::string part = name(static_cast<std::size_t>(m.bodies.groups[g].link));
    if (with == With::Itself) part += " and " + name(other);
    if (with == With::Carried) part = "the carried object";
    worst = {with, std::move(part), std::max(1e-6, static_cast<double>(depth))};
    return false;
  });
  return worst;
}

std::size_t FastChecker::checks() const {
  return impl_->checks;
}

}  // namespace colift::planner
