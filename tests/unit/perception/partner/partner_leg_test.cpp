#include "perception/partner/partner_leg.hpp"

#include <catch2/catch.hpp>

#include <numbers>

#include "partner_stage.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "sim_hal/synthetic/person.hpp"

namespace colift::perception {
namespace {

using sim_hal::Label;
using sim_hal::ObjectKind;
using test::Stage;

/// Smallest gap between the person and the object (m).
double gap(const sim_hal::World& world) {
  double smallest = 1e9;
  for (const auto& shape : world.shapes) {
    if (shape.label != Label::Partner) continue;
    const double half = shape.kind == sim_hal::Shape::Kind::Capsule ? 0.5 * shape.size[1] : 0.0;
    for (int i = -12; i <= 12; ++i) {
      const Vec3 p = shape.X_WS.translation() + half * i / 12.0 * shape.X_WS.linear().col(2);
      smallest = std::min(smallest, sim_hal::distance(world, Label::Target, p) - shape.size[0]);
    }
  }
  return smallest;
}

/// Somebody with hanging arms who came so near that a shoe, shin or thigh touches the object.
sim_hal::World leaning(const Stage& stage, sim_hal::Draws& draws) {
  const double azimuth = draws.between(-std::numbers::pi, std::numbers::pi);
  const double turn = draws.between(-0.9, 0.9), shoulders = draws.between(1.3, 1.48);
  const Vec3 away(std::cos(azimuth), std::sin(azimuth), 0.0);
  sim_hal::World world;
  double apart = 2.0;
  for (int step = 0; step < 200; ++step) {
    world = stage.scene.world;
    sim_hal::Posture posture;
    posture.facing = Eigen::AngleAxisd(turn, Vec3::UnitZ()) * Vec3(-away);
    const Vec3 right = posture.facing.cross(Vec3::UnitZ());
    const Vec3 middle = Vec3(stage.scene.cog.x(), stage.scene.cog.y(), shoulders) + apart * away;
    posture.right_shoulder = middle + 0.18 * right;
    posture.left_shoulder = middle - 0.18 * right;
    sim_hal::add_person(world, posture);
    const double free = gap(world);
    if (free < 0.004) break;
    apart -= std::max(0.002, 0.8 * free);
  }
  return world;
}

TEST_CASE("a leg or a shoe that touches the object is seldom taken for a hand", "[partner][leg]") {
  int taken = 0, looked = 0;
  for (const ObjectKind kind : {ObjectKind::Table, ObjectKind::Box, ObjectKind::Pipe, ObjectKind::Chair}) {
    for (std::uint64_t seed = 700; seed < 708; ++seed) {
      const Stage stage(kind, seed, 3);
      auto finder = stage.finder();
      sim_hal::Draws draws(seed, 77);
      for (int i = 0; i < 2; ++i) {
        const auto seen = finder.find(stage.see(leaning(stage, draws), seed));
        REQUIRE(seen);
        ++looked;
        taken += seen->kind == PartnerKind::Grasp ? 1 : 0;
      }
    }
  }
  INFO(taken << " of " << looked);
  CHECK(taken * 100 <= looked * 17);  // more than half without leg_sign
}

TEST_CASE("the hand of a person who also leans against the table is found, often as the only contact",
          "[partner][leg]") {
  const Stage stage(ObjectKind::Table, 3);
  const auto pose = sim_hal::make_partner(stage.scene, 3, false);
  auto finder = stage.finder();
  constexpr int kDraws = 10;
  int alone = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const auto seen = finder.find(stage.see(sim_hal::with_partner(stage.scene.world, pose), 1 + draw));
    REQUIRE(seen);
    REQUIRE(!seen->contacts.empty());
    double nearest = 1.0;
    for (const auto& c : seen->contacts) nearest = std::min(nearest, (c.position - pose.contact).norm());
    CHECK(nearest < 0.025);
    alone += seen->contacts.size() == 1 ? 1 : 0;
  }
  CHECK(alone >= 3);  // else a knee at the table's edge counts as a second hand
}

TEST_CASE("the reason names the leg", "[partner][leg]") {
  // a post on the ground beside a box: nothing but a leg
  const Stage stage(ObjectKind::Box, 1);
  const auto& face = *std::max_element(
      stage.scene.faces.begin(), stage.scene.faces.end(), [&](const auto& a, const auto& b) {
        const Vec3 eye = stage.scene.X_WC.translation();
        const auto towards = [&](const auto& f) {
          return std::abs(f.normal.z()) > 0.1 ? -1.0 : f.normal.dot((eye - f.center).normalized());
        };
        return towards(a) < towards(b);
      });
  auto world = stage.scene.world;
  const Vec3 foot = Vec3(face.center.x(), face.center.y(), 0.06) + 0.02 * face.normal;  // pressed against it
  world.shapes.push_back(sim_hal::capsule(foot, foot + 0.8 * Vec3::UnitZ(), 0.06, Label::Partner));
  auto finder = stage.finder();
  const auto seen = finder.find(stage.see(world, 2));
  REQUIRE(seen);
  CHECK(seen->kind == PartnerKind::Near);
  CHECK(seen->reason.find("a leg or the trunk of a person touches the object, and no hand does") == 0);
}

}  // namespace
}  // namespace colift::perception
