#include "sim_hal/synthetic/scenes.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

using namespace colift::sim_hal;

namespace {

constexpr ObjectKind kKinds[] = {ObjectKind::Table, ObjectKind::Box, ObjectKind::OpenBox, ObjectKind::Pipe,
                                 ObjectKind::Chair};
constexpr double kPi = 3.14159265358979323846;

/// Runs a check on the first `seeds` scenes of every kind.
template <class F>
void on_every_scene(std::uint64_t seeds, F check) {
  for (const ObjectKind kind : kKinds)
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      const SyntheticScene scene = make_scene(kind, seed);
      CAPTURE(scene.name);
      check(scene, seed);
    }
}

/// Points on the surface of a box, an upright or lying cylinder, or the axis of a capsule widened by its
/// radius.
std::vector<Vec3> surface_points(const Shape& s) {
  std::vector<Vec3> points;
  constexpr int n = 6;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j) {
      const double a = static_cast<double>(i) / n, b = static_cast<double>(j) / n;
      if (s.kind == Shape::Kind::Box) {
        const Vec3 h = 0.5 * s.size;
        for (const double side : {1.0, -1.0}) {
          points.push_back(s.X_WS * Vec3(side * h.x(), a * h.y(), b * h.z()));
          points.push_back(s.X_WS * Vec3(a * h.x(), side * h.y(), b * h.z()));
          points.push_back(s.X_WS * Vec3(a * h.x(), b * h.y(), side * h.z()));
        }
      } else {
        const double r = s.size[0], z = 0.5 * s.size[1] * b;
        points.push_back(s.X_WS * Vec3(r * std::cos(kPi * a), r * std::sin(kPi * a), z));
      }
    }
  return points;
}

/// Centre of gravity by counting points of a fine grid that lie within the target.
Vec3 counted_cog(const SyntheticScene& scene) {
  colift::hal::Aabb bounds;
  for (const Shape& s : scene.world.shapes)
    if (s.label == Label::Target)
      for (const Vec3& p : surface_points(s)) bounds.extend(p);
  Vec3 sum = Vec3::Zero();
  double count = 0;
  constexpr int n = 70;
  const Vec3 step = bounds.sizes() / n;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const Vec3 p = bounds.min() + step.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
        if (distance(scene.world, Label::Target, p) > 0) continue;
        sum += p;
        count += 1;
      }
  return sum / count;
}

bool same_world(const World& a, const World& b) {
  if (a.shapes.size() != b.shapes.size()) return false;
  for (std::size_t i = 0; i < a.shapes.size(); ++i) {
    const Shape &l = a.shapes[i], &r = b.shapes[i];
    if (l.kind != r.kind || l.label != r.label || l.size != r.size || l.reflectivity != r.reflectivity)
      return false;
    if (l.X_WS.matrix() != r.X_WS.matrix()) return false;
  }
  return true;
}

std::size_t pixels(const Rendering& image, Label label) {
  std::size_t n = 0;
  for (const Label l : image.label) n += l == label;
  return n;
}

}  // namespace

TEST_CASE("the whole object is in view, from where the scene says", "[scenes]") {
  on_every_scene(12, [](const SyntheticScene& scene, std::uint64_t) {
    REQUIRE(scene.world.shapes.size() >= 2);
    const Rendering image = cast_rays(scene.world, scene.intrinsics, scene.X_WC);
    CHECK(pixels(image, Label::Target) > 2500);
    for (int v = 0; v < 480; ++v)
      for (const int u : {0, 632})
        REQUIRE(image.label[static_cast<std::size_t>(v * 640 + u)] != Label::Target);
    for (int u = 0; u < 640; ++u)
      for (const int v : {0, 479})
        REQUIRE(image.label[static_cast<std::size_t>(v * 640 + u)] != Label::Target);

    colift::hal::Aabb bounds;
    for (const Shape& s : scene.world.shapes)
      if (s.label == Label::Target)
        for (const Vec3& p : surface_points(s)) bounds.extend(p);
    const double away = (scene.X_WC.translation() - bounds.center()).norm();
    CHECK(away > 1.05);
    CHECK(away < 2.35);
    const double down = std::asin(-scene.X_WC.linear().col(2).z()) * 180 / kPi;
    CHECK(down > 24.9);
    CHECK(down < 50.1);
  });
}

TEST_CASE("the object stands on the floor and nothing is inside anything else", "[scenes]") {
  on_every_scene(12, [](const SyntheticScene& scene, std::uint64_t) {
    double lowest = 1e9;
    const bool supported = scene.name.find("on blocks") != std::string::npos;
    for (const Shape& s : scene.world.shapes) {
      if (s.label == Label::Target)
        for (const Vec3& p : surface_points(s)) {
          lowest = std::min(lowest, p.z());
          REQUIRE(distance(scene.world, Label::Wall, p) > 0.15);
        }
      if (s.label == Label::Clutter && !supported)
        for (const Vec3& p : surface_points(s)) {
          REQUIRE(p.z() > -1e-9);
          REQUIRE(distance(scene.world, Label::Target, p) > 0.15 - 1e-9);
        }
    }
    if (!supported) CHECK(lowest == Approx(0.0).margin(2e-3));
  });
}

TEST_CASE("true faces and cylinders are where the object ends", "[scenes]") {
  on_every_scene(6, [](const SyntheticScene& scene, std::uint64_t) {
    CHECK(scene.faces.size() + scene.cylinders.size() > 0);
    for (const TrueFace& f : scene.faces) {
      CHECK(f.u.cross(f.v).dot(f.normal) == Approx(1.0));
      CHECK(distance(scene.world, Label::Target, f.center + 0.004 * f.normal) > 0.0);
      for (const double a : {-0.499, 0.0, 0.499})
        for (const double b : {-0.499, 0.0, 0.499}) {
          const Vec3 p = f.center + a * f.width * f.u + b * f.height * f.v;
          REQUIRE(std::abs(distance(scene.world, Label::Target, p)) < 2e-3);
        }
    }
    for (const TrueCylinder& c : scene.cylinders) {
      const Vec3 side = colift::hal::tangents(c.axis).first;
      for (const double along : {-0.49, 0.0, 0.49}) {
        const Vec3 p = c.center + along * c.length * c.axis + c.radius * side;
        REQUIRE(std::abs(distance(scene.world, Label::Target, p)) < 1e-9);
      }
    }
    REQUIRE(scene.graspable.size() >= 4);
    for (const Vec3& p : scene.graspable) REQUIRE(std::abs(distance(scene.world, Label::Target, p)) < 1e-9);
  });
}

TEST_CASE("the centre of gravity is that of the filled volume", "[scenes]") {
  on_every_scene(1, [](const SyntheticScene& scene, std::uint64_t) {
    CHECK((counted_cog(scene) - scene.cog).norm() < 0.015);
  });
}

TEST_CASE("rooms differ: some have clutter, some a wall, some more wall than floor in view", "[scenes]") {
  int with_wall = 0, more_wall = 0, with_clutter = 0, empty = 0, scenes = 0;
  on_every_scene(10, [&](const SyntheticScene& scene, std::uint64_t) {
    const Rendering image = cast_rays(scene.world, scene.intrinsics, scene.X_WC);
    const std::size_t wall = pixels(image, Label::Wall), floor = pixels(image, Label::Ground);
    bool clutter = false;
    for (const Shape& s : scene.world.shapes) clutter = clutter || s.label == Label::Clutter;
    ++scenes, with_wall += wall > 0, more_wall += wall > floor, with_clutter += clutter,
        empty += !clutter && wall == 0;
  });
  CHECK(with_wall > scenes / 4);
  CHECK(with_wall < scenes * 9 / 10);
  CHECK(more_wall >= 2);
  CHECK(with_clutter > scenes / 3);
  CHECK(empty > 0);
}

TEST_CASE("the same seed builds the same world", "[scenes]") {
  on_every_scene(2, [](const SyntheticScene& scene, std::uint64_t seed) {
    CHECK(same_world(scene.world, make_scene(scene.kind, seed).world));
    CHECK_FALSE(same_world(scene.world, make_scene(scene.kind, seed + 1).world));
    const World once = with_partner(scene.world, make_partner(scene, seed, true));
    CHECK(same_world(once, with_partner(scene.world, make_partner(scene, seed, true))));
    CHECK(same_world(with_passer_by(scene, seed, true), with_passer_by(scene, seed, true)));
  });
}

TEST_CASE("the partner's hand meets the object at the contact and does not run into it", "[partner]") {
  for (const bool two_hands : {false, true})
    on_every_scene(8, [&](const SyntheticScene& scene, std::uint64_t seed) {
      const PartnerPose pose = make_partner(scene, seed, two_hands);
      const World with = with_partner(scene.world, pose);
      std::vector<Vec3> contacts{pose.contact};
      if (pose.second_contact) contacts.push_back(*pose.second_contact);
      for (const Vec3& c : contacts) {
        CHECK(std::abs(distance(with, Label::Target, c)) < 1e-9);
        CHECK(std::abs(distance(with, Label::Partner, c)) < 0.006);
      }
      for (const Shape& s : with.shapes) {
        if (s.label != Label::Partner || s.kind == Shape::Kind::Sphere) continue;
        for (const Vec3& p : surface_points(s)) REQUIRE(distance(with, Label::Target, p) > -0.008);
      }
    });
}

TEST_CASE("a hand at a table top has the thumb above and the fingers below", "[partner]") {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    const SyntheticScene scene = make_scene(ObjectKind::Table, seed);
    const PartnerPose pose = make_partner(scene, seed, false);
    const World with = with_partner(scene.world, pose);
    const Vec3 inwards =
        (Vec3(scene.cog.x(), scene.cog.y(), 0) - Vec3(pose.contact.x(), pose.contact.y(), 0)).normalized();
    const double top = scene.faces.front().center.z();
    int above = 0, below = 0;
    for (const Shape& s : with.shapes)
      if (s.label == Label::Partner)
        for (const Vec3& p : surface_points(s)) {
          const Vec3 from = p - pose.contact;
          if (from.head<2>().norm() > 0.08 || from.dot(inwards) < 0.01) continue;
          above += p.z() > top, below += p.z() < 2 * pose.contact.z() - top;
        }
    CAPTURE(scene.name);
    CHECK(above > 0);
    CHECK(below > 0);
  }
}

TEST_CASE("but for the hands a partner stays outside of the object", "[partner]") {
  int clear = 0, all = 0;
  on_every_scene(10, [&](const SyntheticScene& scene, std::uint64_t seed) {
    const PartnerPose pose = make_partner(scene, seed, seed % 2 == 1);
    const World with = with_partner(scene.world, pose);
    bool outside = true;
    for (const Shape& s : with.shapes) {
      if (s.label != Label::Partner || s.kind == Shape::Kind::Box) continue;
      for (const Vec3& p : surface_points(s)) {
        if ((p - pose.contact).norm() < 0.22) continue;
        if (pose.second_contact && (p - *pose.second_contact).norm() < 0.22) continue;
        outside = outside && distance(with, Label::Target, p) > 0.0 && distance(with, Label::Wall, p) > 0.0;
      }
    }
    ++all, clear += outside;
  });
  CHECK(clear >= all * 19 / 20);
}

TEST_CASE("the camera sees most contacts, and partners come from any side", "[partner]") {
  int seen = 0, all = 0, sides[4] = {};
  on_every_scene(12, [&](const SyntheticScene& scene, std::uint64_t seed) {
    const PartnerPose pose = make_partner(scene, seed, false);
    const Rendering image = cast_rays(with_partner(scene.world, pose), scene.intrinsics, scene.X_WC);
    const Vec3 p = scene.X_WC.inverse() * pose.contact;
    const auto& k = scene.intrinsics;
    const int u = static_cast<int>(std::lround(k.fx * p.x() / p.z() + k.cx));
    const int v = static_cast<int>(std::lround(k.fy * p.y() / p.z() + k.cy));
    REQUIRE(u > 0);
    REQUIRE(v > 0);
    const auto i = static_cast<std::size_t>(v * k.width + u);
    ++all, seen += std::abs(image.depth_m.at(i) - p.z()) < 0.12;
    CHECK(pixels(image, Label::Partner) > 300);

    const Vec3 in_C = scene.X_WC.linear().transpose() * (pose.from - scene.cog);
    const double side = std::atan2(in_C.x(), in_C.z()) + kPi;  // about the camera's view
    ++sides[std::min(static_cast<int>(side / (kPi / 2)), 3)];
  });
  CHECK(seen >= all * 9 / 10);
  for (const int n : sides) CHECK(n >= 4);
}

TEST_CASE("two hands are used wherever the object has room for them", "[partner]") {
  int two = 0, all = 0;
  on_every_scene(8, [&](const SyntheticScene& scene, std::uint64_t seed) {
    const PartnerPose pose = make_partner(scene, seed, true);
    ++all;
    if (!pose.second_contact) return;
    ++two;
    const double apart = (*pose.second_contact - pose.contact).norm();
    CHECK(apart > 0.19);
    CHECK(apart < 0.66);
  });
  CHECK(two >= all * 3 / 4);
}

TEST_CASE("a passer-by touches nothing and stands before or behind the object", "[partner]") {
  int hides = 0, seen = 0, all = 0;
  on_every_scene(6, [&](const SyntheticScene& scene, std::uint64_t seed) {
    const Rendering alone = cast_rays(scene.world, scene.intrinsics, scene.X_WC);
    for (const bool in_front : {true, false}) {
      const World with = with_passer_by(scene, seed, in_front);
      REQUIRE(with.shapes.size() > scene.world.shapes.size());
      for (const Shape& s : with.shapes)
        if (s.label == Label::Partner)
          for (const Vec3& p : surface_points(s)) {
            REQUIRE(distance(with, Label::Target, p) > 0.08);
            REQUIRE(distance(with, Label::Wall, p) > 0.0);
          }
      const Rendering image = cast_rays(with, scene.intrinsics, scene.X_WC);
      const bool hidden = pixels(image, Label::Target) < pixels(alone, Label::Target) * 98 / 100;
      if (in_front) ++all, hides += hidden;
      if (!in_front) seen += pixels(image, Label::Partner) > 300;
    }
  });
  CHECK(hides >= all * 3 / 4);
  CHECK(seen >= all * 3 / 4);
}
