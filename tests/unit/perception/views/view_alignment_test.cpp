#include "perception/views/view_alignment.hpp"

#include <catch2/catch.hpp>
#include <numbers>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/scenes.hpp"

using namespace colift;
using namespace colift::perception;
using hal::Pose;
using hal::Vec3;
using sim_hal::ObjectKind;

namespace {

constexpr ObjectKind kKinds[] = {ObjectKind::Table, ObjectKind::Box, ObjectKind::Pipe, ObjectKind::Chair};

/// What a camera at X sees of a scene, with noise.
OrganisedCloud seen_from(const sim_hal::SyntheticScene& scene, const Pose& X_WC, std::uint64_t noise,
                         const std::optional<Pose>& believed = std::nullopt) {
  const sim_hal::Rendering truth = sim_hal::cast_rays(scene.world, scene.intrinsics, X_WC);
  return deproject(sim_hal::measure(truth, {}, noise), believed.value_or(X_WC));
}

/// A camera on the other side of the object.
Pose opposite(const sim_hal::SyntheticScene& scene) {
  const Vec3 eye = scene.X_WC.translation();
  const Vec3 off = eye - scene.cog;
  return sim_hal::look_at(scene.cog + Vec3(-off.x(), -off.y(), off.z()), scene.cog);
}

/// A camera that is pushed: by so many metres, and turned about its own place.
Pose pushed(const Pose& X_WC, const Vec3& by_m, double by_deg, const Vec3& axis) {
  Pose X = X_WC;
  X.linear() = Eigen::AngleAxisd(hal::deg_to_rad(by_deg), axis.normalized()) * X_WC.linear();
  X.translation() += by_m;
  return X;
}

}  // namespace

TEST_CASE("two cameras that are where they are believed to be agree, whichever way they look") {
  for (std::uint64_t seed = 1; seed <= 6; ++seed)
    for (const ObjectKind kind : kKinds) {
      const auto scene = sim_hal::make_scene(kind, seed);
      const auto a = align_views(seen_from(scene, scene.X_WC, seed),
                                 seen_from(scene, opposite(scene), seed + 9), {}, {});
      INFO(scene.name << ", seed " << seed << ": " << a.reason);
      REQUIRE(a.enough);
      // single frames: what it is sure of is no more than it is off
      CHECK(a.sigmas < 6.0);
      CHECK(a.shift_m < 0.012);
      CHECK(a.after_m < 0.006);
    }
}

TEST_CASE("a wrong calibration of the second camera is found and taken out") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (const ObjectKind kind : kKinds) {
      const auto scene = sim_hal::make_scene(kind, seed);
      const Pose X = opposite(scene), believed = pushed(X, {0.004, -0.006, 0.012}, 0.6, {0.3, 1.0, 0.2});
      const auto a =
          align_views(seen_from(scene, scene.X_WC, seed), seen_from(scene, X, seed + 9, believed), {}, {});
      INFO(scene.name << ", seed " << seed << ": " << a.reason);
      REQUIRE(a.enough);
      CHECK(a.sigmas > 6.0);
      CHECK(a.after_m < a.before_m);
      // heights agree again; along the floor a lone object shows less
      double worst_m = 0.0;
      for (const Vec3& off : {Vec3(0.4, 0.0, 0.0), Vec3(-0.4, 0.0, 0.0), Vec3(0.0, 0.4, 0.0)}) {
        const Vec3 p = scene.cog + off;
        worst_m = std::max(worst_m, std::abs((a.X * believed * X.inverse() * p - p).z()));
      }
      CHECK(worst_m < 0.006);
    }
}

TEST_CASE("a camera that was pushed no longer agrees with its own earlier picture; one at rest does") {
  for (std::uint64_t seed = 1; seed <= 3; ++seed)
    for (const ObjectKind kind : kKinds) {
      const auto scene = sim_hal::make_scene(kind, seed);
      const OrganisedCloud before = seen_from(scene, scene.X_WC, seed);
      const auto at_rest = align_views(before, seen_from(scene, scene.X_WC, seed + 5), {}, {});
      INFO(scene.name << ", seed " << seed << ": at rest " << at_rest.reason);
      CHECK(at_rest.shift_m < 0.004);
      CHECK(at_rest.receded < 0.02);
      const Pose X = pushed(scene.X_WC, {0.02, 0.01, 0.0}, 2.0, scene.X_WC.linear().col(0));
      const auto moved = align_views(before, seen_from(scene, X, seed + 6, scene.X_WC), {}, {});
      INFO("pushed: receded " << moved.receded << ", " << moved.reason);
      CHECK((moved.receded > 0.2 || moved.shift_m > 0.025));
    }
}

TEST_CASE("somebody who walks in is no push") {
  const auto scene = sim_hal::make_scene(ObjectKind::Table, 3);
  const OrganisedCloud before = seen_from(scene, scene.X_WC, 1);
  for (const bool in_front : {false, true}) {
    sim_hal::SyntheticScene visited = scene;
    visited.world = sim_hal::with_passer_by(scene, 7, in_front);
    const auto a = align_views(before, seen_from(visited, scene.X_WC, 2), {}, {});
    INFO(a.reason);
    CHECK(a.shift_m < 0.006);
    CHECK(a.receded < 0.05);
  }
}

TEST_CASE("views that share nothing say so") {
  const auto scene = sim_hal::make_scene(ObjectKind::Box, 1);
  Pose away = scene.X_WC;
  away.linear() = Eigen::AngleAxisd(std::numbers::pi, Vec3::UnitZ()) * scene.X_WC.linear();
  const auto a = align_views(seen_from(scene, scene.X_WC, 1), seen_from(scene, away, 2), {}, {});
  CHECK_FALSE(a.enough);
  CHECK(a.reason.find("in common") != std::string::npos);
  OrganisedCloud empty = seen_from(scene, scene.X_WC, 1);
  for (auto* values : {&empty.depth_m, &empty.x, &empty.y, &empty.z})
    std::fill(values->begin(), values->end(), NAN);
  CHECK_FALSE(align_views(empty, empty, {}, {}).enough);
}
