// What tells an object from the room around it: heads, outlines, ramps, bulk.
#include <fmt/format.h>

#include <algorithm>

#include "lying_person.hpp"
#include "perception/ground/image_border.hpp"
#include "perception/target/outline.hpp"
#include "sim_hal/synthetic/person.hpp"
#include "sim_hal/synthetic/rooms.hpp"
#include "synthetic.hpp"

namespace colift::perception {
namespace {

using namespace sim_hal;

TargetResult target_of(const World& world, const Pose& X_WC, const std::optional<Vec3>& at = std::nullopt) {
  const OrganisedCloud cloud = deproject(measure(cast_rays(world, {}, X_WC), {}, 7), X_WC);
  const NoiseModel noise;
  const auto blocks = fit_block_planes(cloud, noise);
  const GroundResult g = find_ground(cloud, blocks, std::nullopt, noise, {});
  INFO(g.reason);
  REQUIRE(g.ground);
  return find_target(cloud, blocks, *g.ground, noise, {}, at);
}

bool refused(const TargetResult& r, RejectedObject::Kind kind) {
  return std::any_of(r.rejected.begin(), r.rejected.end(), [&](const auto& o) { return o.kind == kind; });
}

World floor_only() {
  World world;
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  return world;
}

const Pose kCamera = look_at(Vec3(-0.6, 0, 1.1), Vec3(1.8, 0, 0.4));

Posture person_at(double yaw, bool sits) {
  Posture p;
  p.facing = {std::cos(yaw), std::sin(yaw), 0};
  const Vec3 right = p.facing.cross(Vec3::UnitZ());
  const auto shoulders = [&](const Vec3& middle) {
    p.right_shoulder = middle + 0.18 * right;
    p.left_shoulder = middle - 0.18 * right;
  };
  if (!sits) {
    shoulders(Vec3(2.2, 0, 1.42));
    return p;
  }
  p.hip = Vec3(2.0, 0, 0.55);
  shoulders(*p.hip + Vec3(0, 0, 0.5));
  p.right_foot = Vec3(2.0, 0, 0.08) + 0.42 * p.facing + 0.12 * right;
  p.left_foot = Vec3(2.0, 0, 0.08) + 0.42 * p.facing - 0.12 * right;
  return p;
}

}  // namespace

TEST_CASE("a person is known by head and shoulders at any posture, not by the height", "[person]") {
  const double yaw = GENERATE(0.0, 1.0, 2.5, 4.0);
  const bool sits = GENERATE(true, false);
  World world = floor_only();
  add_person(world, person_at(yaw, sits));
  const TargetResult r = target_of(world, look_at(Vec3(-0.9, 0, 1.3), Vec3(2.0, 0, 0.75)));
  INFO(r.reason);
  CHECK_FALSE(r.target);
  CHECK(refused(r, RejectedObject::Kind::Person));
  CHECK(r.reason.find("a person is in view") != std::string::npos);
}

TEST_CASE("a person at the rim of the view is no target", "[person]") {
  int taken = 0;
  for (const double yaw : {0.0, 1.0, 2.5, 4.0})
    for (const bool sits : {true, false}) {
      World world = floor_only();
      add_person(world, person_at(yaw, sits));
      for (const double beside_m : {-1.7, -1.6, -1.5, -1.4, -1.3, -1.2, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7}) {
        const TargetResult r = target_of(world, look_at(Vec3(-0.9, 0, 1.3), Vec3(2.0, beside_m, 0.75)));
        UNSCOPED_INFO(yaw << " rad, " << beside_m << " m: " << r.reason);
        taken += r.target ? 1 : 0;
      }
    }
  CHECK(taken <= 2);  // of 96: two legs of him alone are hard to tell from a stool
}

TEST_CASE("a box on a table, a chair and a vase on a cupboard have no head", "[person]") {
  World world = floor_only();
  SECTION("a box on a table") {
    world.shapes.push_back(box({1.8, 0, 0.71}, {0.5, 0.8, 0.03}, 0.2, Label::Target));
    for (const double x : {-0.22, 0.22})
      for (const double y : {-0.35, 0.35})
        world.shapes.push_back(box({1.8 + x, y, 0.35}, {0.04, 0.04, 0.69}, 0.2, Label::Target));
    world.shapes.push_back(box({1.8, 0, 0.85}, {0.15, 0.2, 0.25}, 0.0, Label::Target));
  }
  SECTION("a chair") {
    world.shapes.push_back(box({1.6, 0, 0.44}, {0.45, 0.45, 0.04}, 0.4, Label::Target));
    world.shapes.push_back(box({1.8, 0.08, 0.72}, {0.03, 0.42, 0.5}, 0.4, Label::Target));
    world.shapes.push_back(box({1.6, 0, 0.21}, {0.06, 0.06, 0.42}, 0.4, Label::Target));
  }
  const TargetResult r = target_of(world, kCamera);
  INFO(r.reason);
  REQUIRE(r.target);
  CHECK_FALSE(refused(r, RejectedObject::Kind::Person));
}

TEST_CASE("a sofa along a wall is furniture, the carton before it is the target", "[target]") {
  World world = floor_only();
  world.shapes.push_back(box({3.05, 0, 1.35}, {0.1, 8, 2.7}, 0, Label::Wall));
  world.shapes.push_back(box({2.55, 0, 0.24}, {0.75, 1.7, 0.37}, 0, Label::Clutter));
  world.shapes.push_back(box({2.85, 0, 0.45}, {0.2, 1.7, 0.8}, 0, Label::Clutter));
  const TargetResult alone = target_of(world, kCamera);
  INFO(alone.reason);
  CHECK_FALSE(alone.target);
  world.shapes.push_back(box({1.4, 0.3, 0.15}, {0.3, 0.4, 0.3}, 0.5, Label::Target));
  const TargetResult r = target_of(world, kCamera);
  INFO(r.reason);
  REQUIRE(r.target);
  CHECK(r.target->obb.center.x() < 1.7);
}

TEST_CASE("a desk with panels is carried, a chest that is a little larger is not", "[target]") {
  const auto desk_of = [](double width, double depth, double height) {
    World world = floor_only();
    const auto add = [&](const Vec3& at, const Vec3& size) {
      world.shapes.push_back(box(Vec3(1.5, 0, 0) + at, size, 0.4, Label::Target));
    };
    const Eigen::AngleAxisd turn(0.4, Vec3::UnitZ());
    add({0, 0, height - 0.01}, {width, depth, 0.02});
    for (const double side : {-1.0, 1.0})
      add(turn * Vec3(0.5 * side * (width - 0.02), 0, 0.5 * (height - 0.02)), {0.02, depth, height - 0.02});
    add({0, 0, 0.5 * (height - 0.02)}, {width - 0.04, 0.02, height - 0.02});
    return target_of(world, look_at(Vec3(-0.3, 0.9, 1.5), Vec3(1.5, 0, 0.4)));
  };
  // 0.44 m^3; its footprint was counted in cells of 4 cm: 0.55
  const TargetResult desk = desk_of(1.10, 0.55, 0.72);
  INFO(desk.reason);
  CHECK(desk.target);
  CHECK_FALSE(desk_of(1.20, 0.62, 0.76).target);
}

TEST_CASE("a long pipe on stands does not close the view down to the ground", "[target]") {
  World world = floor_only();
  world.shapes.push_back(cylinder(Vec3(1.5, 0, 0.245), Vec3::UnitY(), 0.055, 1.785, Label::Target));
  for (const double side : {-1.0, 1.0})
    world.shapes.push_back(box(Vec3(1.5, 0.46 * side, 0.095), {0.18, 0.17, 0.19}, 0.3, Label::Target));
  const TargetResult r = target_of(world, look_at(Vec3(-0.2, 0.15, 1.53), Vec3(1.5, 0, 0.19)));
  INFO(r.reason);
  CHECK(r.target);
  CHECK_FALSE(refused(r, RejectedObject::Kind::Large));
}

TEST_CASE("what hangs in the air is not on the ground", "[target]") {
  World world = floor_only();
  world.shapes.push_back(
      box({2.2, 0, 1.05}, {0.3, 0.6, 0.25}, 0, Label::Clutter));  // a cupboard without its wall
  const TargetResult r = target_of(world, kCamera);
  CHECK_FALSE(r.target);
  CHECK(refused(r, RejectedObject::Kind::Floating));
}

TEST_CASE("an object whose outline goes on is a part of something", "[outline]") {
  World world = floor_only();
  world.shapes.push_back(box({1.6, 0, 0.15}, {0.3, 0.4, 0.3}, 0.3, Label::Target));
  const OrganisedCloud cloud = deproject(measure(cast_rays(world, {}, kCamera), {}, 3), kCamera);
  const Ground ground{{Vec3::UnitZ(), 0.0}, 1000, 0.002};
  const ImageBorder border = find_image_border(cloud);
  std::vector<std::uint8_t> mask(cloud.size(), 0);
  for (std::size_t i = 0; i < mask.size(); ++i) mask[i] = cloud.seen(i) && cloud.z[i] > 0.03f ? 1 : 0;
  const DepthJump jump{0.013f, 0.008f};
  const auto whole_of = [&](const std::vector<std::uint8_t>& m) {
    const Components c = connected_components(cloud.depth_m, m, cloud.width(), cloud.height(), jump);
    auto f = describe_fragments(cloud, c, ground, border, {});
    REQUIRE_FALSE(f.empty());
    const auto largest = std::max_element(f.begin(), f.end(),
                                          [](const auto& a, const auto& b) { return a.pixels < b.pixels; });
    return read_outline(cloud, c, c.labels(cloud.width(), cloud.height()), *largest, ground, border, jump);
  };
  const Outline whole = whole_of(mask);
  CHECK(whole.free() > 0.9);
  CHECK(whole.free() + whole.same + whole.nearer + whole.rim + whole.unknown == Approx(1.0));
  // the same box, cut in two by the mask
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (i % static_cast<std::size_t>(cloud.width()) < 320) mask[i] = 0;
  CHECK(whole_of(mask).same > 0.15);
}

TEST_CASE("a ramp between a carton and the wall behind it parts them", "[second_look]") {
  World world = floor_only();
  world.shapes.push_back(box({1.75, 0, 1.35}, {0.1, 8, 2.7}, 0, Label::Wall));
  world.shapes.push_back(box({1.4, 0.1, 0.2}, {0.25, 0.5, 0.4}, 0.1, Label::Target));
  // the wall is too near and too much hidden to be known as one when its upper part leaves the view
  const Pose camera = look_at(Vec3(-0.1, 0, 0.55), Vec3(1.4, 0, 0.25));
  const Rendering truth = cast_rays(world, intrinsics_of(DepthSensor::ActiveStereo), camera);
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const OrganisedCloud cloud = deproject(measure_with(DepthSensor::ActiveStereo, truth, seed), camera);
    const NoiseModel noise;
    const auto blocks = fit_block_planes(cloud, noise);
    const GroundResult g = find_ground(cloud, blocks, std::nullopt, noise, {});
    REQUIRE(g.ground);
    const TargetResult r = find_target(cloud, blocks, *g.ground, noise, {});
    UNSCOPED_INFO(r.reason);
    if (!r.target) continue;
    std::size_t own = 0;
    for (const std::uint32_t p : r.target->pixels) own += truth.label[p] == Label::Target ? 1 : 0;
    right += own > r.target->pixels.size() * 8 / 10 ? 1 : 0;
  }
  CHECK(right >= 4);
}

TEST_CASE("random rooms: the object, and no person, most of the time", "[rooms]") {
  int solvable = 0, right = 0, wrong = 0, persons = 0;
  constexpr int kRooms = 60;
  for (std::uint64_t seed = 501; seed < 501 + kRooms; ++seed) {
    const RandomRoom room = make_room(seed);
    const Rendering truth = cast_rays(room.world, room.intrinsics, room.X_WC);
    const OrganisedCloud cloud = deproject(measure_with(room.sensor, truth, seed), Pose::Identity());
    const ObjectInView object = object_in_view(room, truth);
    const bool can = room.has_object && object.pixels >= 1500 && object.hidden_fraction < 0.3 && !object.cut;
    solvable += can ? 1 : 0;
    const NoiseModel noise;
    const auto blocks = fit_block_planes(cloud, noise);
    const GroundResult g = find_ground(cloud, blocks, std::nullopt, noise, {});
    if (!g.ground) continue;
    const TargetResult r = find_target(cloud, blocks, *g.ground, noise, {});
    if (!r.target) {
      CHECK(r.reason.find("no target") == 0);
      continue;
    }
    std::size_t own = 0, of_person = 0;
    for (const std::uint32_t p : r.target->pixels) {
      own += truth.label[p] == Label::Target ? 1 : 0;
      of_person += truth.label[p] == Label::Partner ? 1 : 0;
    }
    const bool is_object = 2 * own > r.target->pixels.size();
    right += can && is_object ? 1 : 0;
    wrong += is_object ? 0 : 1;
    persons += 2 * of_person > r.target->pixels.size() ? 1 : 0;
  }
  fmt::print("random rooms: {} of {} that can be solved, {} of {} wrong, {} of them persons\n", right,
             solvable, wrong, kRooms, persons);
  CHECK(right >= 0.75 * solvable);
  CHECK(wrong <= 0.15 * kRooms);
  CHECK(persons == 0);
}

TEST_CASE("who lies on the floor is hardly ever the target, from wherever he is seen", "[person]") {
  const Vec3 middle(1.4, -0.1, 0.1);
  int views = 0, targets = 0;
  for (int k = 0; k < 12; ++k)
    for (const double away : {1.4, 2.0, 2.6})
      for (const double height : {0.9, 1.6})
        for (const bool hands_behind_head : {true, false}) {
          const double azimuth = 2.0 * M_PI * k / 12.0;
          const Vec3 eye = middle + Vec3(away * std::cos(azimuth), away * std::sin(azimuth), height);
          World world = floor_only();
          for (const Shape& part : lying_person({1.4, 0, 0}, hands_behind_head)) world.shapes.push_back(part);
          ++views;
          targets += target_of(world, look_at(eye, middle)).target ? 1 : 0;
        }
  INFO(targets << " of " << views << " views");
  CHECK(targets <=
        8);  // seen along the body, or as two parts; as a "pipe that lies" it was most of the views
}

}  // namespace colift::perception
