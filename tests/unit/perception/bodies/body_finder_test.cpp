#include "perception/bodies/body_finder.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "room.hpp"

using namespace colift;
using namespace colift::perception;
using namespace colift::perception::test;
using hal::Vec3;
using sim_hal::ObjectKind;

namespace {

constexpr ObjectKind kKinds[] = {ObjectKind::Table, ObjectKind::Box, ObjectKind::Pipe, ObjectKind::Chair};

/// Whether some body has a point this near to a point in W.
bool found_at(const std::vector<Body>& bodies, const BodyFinder& finder, const Vec3& p_W, double within_m) {
  for (const Body& body : bodies)
    for (const BodyPoint& point : finder.points(body))
      if ((point.p_W.cast<double>() - p_W).norm() < within_m) return true;
  return false;
}

sim_hal::Posture standing(const Vec3& at, const Vec3& facing) {
  sim_hal::Posture p;
  p.facing = facing;
  p.right_shoulder = Vec3(at.x(), at.y(), 1.42) + 0.18 * facing.cross(Vec3::UnitZ());
  p.left_shoulder = Vec3(at.x(), at.y(), 1.42) - 0.18 * facing.cross(Vec3::UnitZ());
  return p;
}

}  // namespace

TEST_CASE("nobody is nobody: an arm that moves among table, box, pipe and chair is no body") {
  int frames = 0, wrong = 0;
  double largest_m2 = 0.0;
  for (std::uint64_t seed = 1; seed <= 4; ++seed)
    for (const ObjectKind kind : kKinds) {
      Room room(kind, seed);
      BodyFinder finder = room.finder();
      for (int i = 0; i <= 12; ++i) {
        const double part = i / 12.0;
        const auto& bodies = room.bodies(finder, room.frame(room.scene.world, part), part);
        ++frames;
        if (bodies.empty()) continue;
        ++wrong;
        largest_m2 = std::max(largest_m2, bodies.front().area_m2);
        UNSCOPED_INFO("kind " << static_cast<int>(kind) << " seed " << seed << " part " << part << ": "
                              << 1e4 * bodies.front().area_m2 << " cm2 at "
                              << bodies.front().center.transpose());
      }
    }
  INFO(wrong << " of " << frames << " frames, at most " << largest_m2 << " m2");
  CHECK(wrong == 0);
}

// Longer than it takes until what lies behind the reference counts as the scene: at edges the nearest depth
// around counts, and what lies behind them is no news.
TEST_CASE("a cluttered room stays empty for as long as one looks at it") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    Room room(kKinds[seed % 4], seed);
    sim_hal::World cluttered = room.scene.world;
    for (int i = 0; i < 6; ++i) {
      const double turn = 1.05 * i;
      const Vec3 at = room.object_at + 0.9 * Vec3(std::cos(turn), std::sin(turn), 0.0);
      cluttered.shapes.push_back(sim_hal::box({at.x(), at.y(), 0.3}, {0.2, 0.3, 0.6}, turn, Label::Clutter));
    }
    room.take_reference(cluttered);
    BodyFinder finder = room.finder();
    INFO("seed " << seed);
    for (int i = 0; i < 45; ++i) REQUIRE(room.bodies(finder, room.frame(cluttered, 0.0), 0.0).empty());
  }
}

TEST_CASE("a column is found in the first frame, wherever it stands") {
  int found = 0, asked = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Room room(kKinds[seed % 4], seed);
    BodyFinder finder = room.finder();
    const double turn = 0.628 * static_cast<double>(seed);
    const Vec3 at = room.object_at + 0.9 * Vec3(std::cos(turn), std::sin(turn), 0.0);
    sim_hal::World world = room.scene.world;
    world.shapes.push_back(
        sim_hal::cylinder({at.x(), at.y(), 0.875}, Vec3::UnitZ(), 0.15, 1.75, Label::Partner));
    sim_hal::World with_robot = world;
    add_robot(with_robot, room.model, room.posture(0.5), room.hand);
    const auto truth = sim_hal::cast_rays(with_robot, room.scene.intrinsics, room.scene.X_WC);
    const auto seen = std::count(truth.label.begin(), truth.label.end(), Label::Partner);
    if (seen < 3000) continue;  // out of the camera's view
    ++asked;
    const auto& bodies = room.bodies(finder, room.frame(world, 0.5), 0.5);
    REQUIRE_FALSE(bodies.empty());
    double off_m = 1e9;
    for (const Body& body : bodies)
      for (const BodyPoint& point : finder.points(body))
        off_m = std::min(off_m, std::hypot(static_cast<double>(point.p_W.x()) - at.x(),
                                           static_cast<double>(point.p_W.y()) - at.y()));
    INFO("seed " << seed << ", " << seen << " pixels of it in view");
    CHECK(off_m < 0.18);
    found += off_m < 0.18 ? 1 : 0;
  }
  REQUIRE(asked >= 5);
  CHECK(found == asked);
}

TEST_CASE(
    "a person is one body, also behind the object, at the border, and with half of the pixels missing") {
  Room room(ObjectKind::Table, 3);
  BodyFinder finder = room.finder();
  const Vec3 eye = room.scene.X_WC.translation();
  const Vec3 away = Vec3(room.object_at.x() - eye.x(), room.object_at.y() - eye.y(), 0.0).normalized();
  const Vec3 side = away.cross(Vec3::UnitZ());

  SECTION("behind the object") {
    sim_hal::World world = room.scene.world;
    sim_hal::add_person(world, standing(room.object_at + 0.7 * away, -away));
    const auto& bodies = room.bodies(finder, room.frame(world, 0.0), 0.0);
    REQUIRE(bodies.size() == 1);
    CHECK(bodies.front().area_m2 > 0.12);
  }
  SECTION("half of the pixels missing") {
    sim_hal::World world = room.scene.world;
    sim_hal::add_person(world, standing(room.object_at + 0.6 * side, -side));
    hal::DepthFrame image = room.frame(world, 0.0);
    const std::size_t whole = room.bodies(finder, image, 0.0).size();
    for (std::size_t i = 0; i < image.depth_m.size(); ++i)
      if (sim_hal::hash(7, 7, i) % 2 == 0) image.depth_m[i] = NAN;
    const auto& bodies = room.bodies(finder, image, 0.0);
    REQUIRE(bodies.size() == whole);
    CHECK(bodies.front().area_m2 > 0.05);
  }
  SECTION("at the image's border") {
    // walks in from the side: as soon as a hand's breadth of him is in view
    bool seen = false;
    for (double off = 3.0; off > 0.8 && !seen; off -= 0.05) {
      sim_hal::World world = room.scene.world;
      sim_hal::add_person(world, standing(room.object_at + off * side, -side));
      const auto truth = sim_hal::cast_rays(world, room.scene.intrinsics, room.scene.X_WC);
      const auto pixels = std::count(truth.label.begin(), truth.label.end(), Label::Partner);
      const auto& bodies = room.bodies(finder, room.frame(world, 0.0), 0.0);
      seen = !bodies.empty();
      INFO(pixels << " pixels of him in view");
      CHECK((seen || pixels < 6000));
    }
    CHECK(seen);
  }
}

TEST_CASE("who stands where a thing was carried off is noticed; an empty room stays empty (row 51)") {
  int found = 0, asked = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Room room(kKinds[seed % 4], seed);
    const Vec3 eye = room.scene.X_WC.translation();
    const Vec3 away = Vec3(room.object_at.x() - eye.x(), room.object_at.y() - eye.y(), 0.0).normalized();
    const Vec3 side = (seed % 2 == 0 ? 1.0 : -1.0) * away.cross(Vec3::UnitZ());
    const Vec3 at = room.object_at + 0.8 * side;
    // a cupboard, and a child behind where its front was
    sim_hal::World with = room.scene.world, child = room.scene.world;
    with.shapes.push_back(
        sim_hal::box({at.x(), at.y(), 0.6}, {0.6, 0.6, 1.2}, std::atan2(away.y(), away.x()), Label::Clutter));
    child.shapes.push_back(
        sim_hal::cylinder({at.x(), at.y(), 0.5}, Vec3::UnitZ(), 0.12, 1.0, Label::Partner));
    const auto truth = sim_hal::cast_rays(child, room.scene.intrinsics, room.scene.X_WC);
    if (std::count(truth.label.begin(), truth.label.end(), Label::Partner) < 3000) continue;
    room.take_reference(with);
    BodyFinder finder = room.finder();
    INFO("seed " << seed);
    REQUIRE(room.bodies(finder, room.frame(with, 0.0), 0.0).empty());
    for (int i = 0; i < 18; ++i) REQUIRE(room.bodies(finder, room.frame(room.scene.world, 0.0), 0.0).empty());
    ++asked;
    const auto& bodies = room.bodies(finder, room.frame(child, 0.0), 0.0);
    const bool seen = found_at(bodies, finder, {at.x(), at.y(), 0.5}, 0.3);
    CHECK(seen);
    found += seen ? 1 : 0;
    // and what is put back is a thing like any other
    CHECK_FALSE(room.bodies(finder, room.frame(with, 0.0), 0.0).empty());
  }
  REQUIRE(asked >= 5);
  CHECK(found == asked);
}

TEST_CASE("an arm that reaches for the robot's hand is a body up to the padding") {
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    Room room(kKinds[seed % 4], seed);
    BodyFinder finder = room.finder();
    const Vec3 palm = hal::hand_pose(room.model, room.posture(0.5)).translation();
    const Vec3 eye = room.scene.X_WC.translation();
    // from the side, so that the camera sees both
    const Vec3 side = (palm - eye).cross(Vec3::UnitZ()).normalized();
    sim_hal::World world = room.scene.world;
    world.shapes.push_back(
        sim_hal::capsule(palm + 0.25 * side, palm + 0.85 * side + Vec3(0, 0, 0.2), 0.045, Label::Partner));
    const auto& bodies = room.bodies(finder, room.frame(world, 0.5), 0.5);
    sim_hal::World with_robot = world;
    add_robot(with_robot, room.model, room.posture(0.5), room.hand);
    const auto truth = sim_hal::cast_rays(with_robot, room.scene.intrinsics, room.scene.X_WC);
    if (std::count(truth.label.begin(), truth.label.end(), Label::Partner) < 4000) continue;
    INFO("seed " << seed);
    CHECK_FALSE(bodies.empty());
    CHECK(found_at(bodies, finder, palm + 0.25 * side, 0.10));
  }
}

TEST_CASE("an object that was raised is no body, and somebody beside it is") {
  for (const ObjectKind kind : kKinds) {
    Room room(kind, 5);
    BodyFinder finder = room.finder();
    hal::Pose lift = hal::Pose::Identity();
    lift.translation().z() = 0.05;
    sim_hal::World world = room.scene.world;
    for (auto& shape : world.shapes)
      if (shape.label == Label::Target) shape.X_WS = lift * shape.X_WS;
    INFO("kind " << static_cast<int>(kind));
    CHECK(room.bodies(finder, room.frame(world, 0.0), 0.0, lift).empty());
    const Vec3 eye = room.scene.X_WC.translation();
    const Vec3 side = (room.object_at - eye).cross(Vec3::UnitZ()).normalized();
    sim_hal::add_person(world, standing(room.object_at + 0.8 * side, -side));
    CHECK(room.bodies(finder, room.frame(world, 0.0), 0.0, lift).size() == 1);
  }
}

TEST_CASE("a flat foot that was the ground rises with the object and is no body; what was not there is one") {
  Room room(ObjectKind::Table, 5);
  const Vec3 eye = room.scene.X_WC.translation();
  const Vec3 nearer = Vec3(eye.x() - room.object_at.x(), eye.y() - room.object_at.y(), 0.0).normalized();
  const Vec3 at = Vec3(room.object_at.x(), room.object_at.y(), 0.0) + 0.2 * nearer;
  const auto plate = [&](double height_m, Label label) {
    return sim_hal::box({at.x(), at.y(), height_m - 0.01}, {0.12, 0.12, 0.02}, 0.0, label);
  };
  hal::Pose lift = hal::Pose::Identity();
  lift.translation().z() = 0.05;
  sim_hal::World before = room.scene.world, raised = room.scene.world;
  for (auto& shape : raised.shapes)
    if (shape.label == Label::Target) shape.X_WS = lift * shape.X_WS;
  raised.shapes.push_back(plate(0.07, Label::Clutter));

  SECTION("it was there") {
    before.shapes.push_back(plate(0.02, Label::Clutter));
    room.take_reference(before);
    BodyFinder finder = room.finder();
    REQUIRE(room.bodies(finder, room.frame(before, 0.0), 0.0).empty());
    CHECK(room.bodies(finder, room.frame(raised, 0.0), 0.0, lift).empty());
    // it does not hide a foot that is set down there
    sim_hal::World foot = raised;
    foot.shapes.push_back(sim_hal::box({at.x(), at.y(), 0.095}, {0.10, 0.25, 0.05}, 0.0, Label::Partner));
    CHECK(room.bodies(finder, room.frame(foot, 0.0), 0.0, lift).size() == 1);
  }
  SECTION("without the rule it is a body") {
    before.shapes.push_back(plate(0.02, Label::Clutter));
    room.take_reference(before);
    BodyFinder finder = room.finder({.max_foot_m2 = 0.0});
    CHECK(room.bodies(finder, room.frame(raised, 0.0), 0.0, lift).size() == 1);
  }
  SECTION("it was not there") {
    BodyFinder finder = room.finder();
    raised.shapes.back() = plate(0.10, Label::Partner);
    CHECK(room.bodies(finder, room.frame(raised, 0.0), 0.0, lift).size() == 1);
  }
}

TEST_CASE("what a body hides counts as the body, as deep as it may be thick") {
  Room room(ObjectKind::Box, 2);
  BodyFinder finder = room.finder();
  const Vec3 eye = room.scene.X_WC.translation();
  const Vec3 side = (room.object_at - eye).cross(Vec3::UnitZ()).normalized();
  sim_hal::World world = room.scene.world;
  sim_hal::add_person(world, standing(room.object_at + 0.7 * side, -side));
  const auto& bodies = room.bodies(finder, room.frame(world, 0.0), 0.0);
  REQUIRE_FALSE(bodies.empty());
  int deep = 0;
  for (const BodyPoint& point : finder.points(bodies.front())) {
    CHECK(point.hidden_m >= 0.0F);
    CHECK(static_cast<double>(point.hidden_m) <= BodyConfig{}.hidden_m + 1e-6);
    deep += static_cast<double>(point.hidden_m) > 0.2 ? 1 : 0;
  }
  CHECK(deep > static_cast<int>(bodies.front().count) / 2);
}

TEST_CASE("a frame of another size shows nobody and does no harm") {
  Room room(ObjectKind::Box, 1);
  BodyFinder finder = room.finder();
  hal::DepthFrame image;
  image.depth_m.resize(77, 1.0F);
  CHECK(finder.find(image, {}).empty());
}
