#include <catch2/catch.hpp>

#include "collision_world.hpp"

namespace {

using namespace colift;
using planner::Contacts;
using planner::Touch;

/// A small map whose occupied cells are given by hand: carved free all over, then hit where asked.
perception::WorldMap map_with(const std::vector<hal::Vec3>& occupied) {
  perception::WorldMap map{perception::WorldMapConfig{}};
  // each point gets a camera of its own that sees nothing else
  for (const hal::Vec3& p : occupied) {
    perception::OrganisedCloud cloud;
    cloud.intrinsics = {2, 1, 575.0, 575.0, 0.5, 0.0};
    cloud.X_WC.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    cloud.X_WC.translation() = p + hal::Vec3(0, 0, 0.3);
    cloud.depth_m = {0.3f, 0.3f};
    for (int i = 0; i < 2; ++i) {
      cloud.x.push_back(static_cast<float>(p.x()));
      cloud.y.push_back(static_cast<float>(p.y()));
      cloud.z.push_back(static_cast<float>(p.z()));
    }
    map.insert(cloud, {});
  }
  return map;
}

const hal::Plane kFloor{hal::Vec3::UnitZ(), 0.0};

planner::SceneConfig measured_only() {
  planner::SceneConfig config;
  config.hidden_is_obstacle = false;
  return config;
}

planner::FastChecker checker(std::shared_ptr<const planner::CollisionScene> scene) {
  return {hal::built_in_robot(), planner::cover_with_spheres(hal::built_in_robot()), std::move(scene)};
}

std::shared_ptr<const planner::CollisionScene> share(planner::CollisionScene scene) {
  return std::make_shared<planner::CollisionScene>(std::move(scene));
}

/// The arm bent forward, palm over the floor before the robot.
hal::JointVector forward() {
  hal::JointVector q = hal::JointVector::Zero();
  q[1] = 0.9;
  q[3] = -1.2;
  q[5] = 0.6;
  return q;
}

}  // namespace

TEST_CASE("cells at the ground are the ground's, those above are obstacles") {
  const auto map = map_with({{0.5, 0.5, 0.01}, {0.5, -0.5, 0.05}});
  REQUIRE(map.occupied_cells() == 2);
  const auto scene = planner::make_collision_scene(map, kFloor, {}, measured_only());
  CHECK(scene.obstacles.distance({0.51f, 0.51f, 0.01f}) > 0.29f);
  CHECK(scene.obstacles.distance({0.51f, -0.49f, 0.05f}) == 0.0f);
}

TEST_CASE("unseen space around the robot's own axis is free") {
  const test::CollisionWorld world;
  planner::SceneConfig config;
  config.out_of_view_is_obstacle = true;
  config.own_space_m = 0.0;
  const auto strict = planner::make_collision_scene(world.map, world.ground, {}, config);
  config.own_space_m = 0.5;
  const auto usual = planner::make_collision_scene(world.map, world.ground, {}, config);
  const Eigen::Vector3f behind(-0.25f, 0.0f, 0.6f);
  CHECK(strict.arm_obstacles.distance(behind) == 0.0f);
  CHECK(usual.arm_obstacles.distance(behind) > 0.0f);
}

TEST_CASE("hidden space keeps the arm out but not the hand, and only as configured") {
  const test::CollisionWorld world;
  const auto& grid = world.map.grid();
  planner::SceneConfig config;
  config.own_space_m = 0.0;
  const auto usual = planner::make_collision_scene(world.map, world.ground, {}, config);
  config.hidden_is_obstacle = false;
  const auto seen_only = planner::make_collision_scene(world.map, world.ground, {}, config);
  config.out_of_view_is_obstacle = true;
  const auto shy = planner::make_collision_scene(world.map, world.ground, {}, config);
  int hidden = 0, out_of_view = 0;
  for (int z = 3; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x) {
        const auto state = grid.cells[grid.index(x, y, z)];
        const hal::Vec3 middle = grid.middle(x, y, z);
        if (middle.z() < 0.04) continue;
        const Eigen::Vector3f p = middle.cast<float>();
        if (state == perception::CellState::Hidden) {
          ++hidden;
          REQUIRE(usual.arm_obstacles.distance(p) == 0.0f);
          REQUIRE(seen_only.arm_obstacles.distance(p) <= seen_only.arm_obstacles.max_m());
        }
        if (state == perception::CellState::OutOfView) {
          ++out_of_view;
          REQUIRE(shy.arm_obstacles.distance(p) == 0.0f);
        }
        if (state != perception::CellState::Occupied) continue;
        REQUIRE(usual.obstacles.distance(p) == 0.0f);
        REQUIRE(seen_only.arm_obstacles.distance(p) == 0.0f);
      }
  CHECK(hidden > 1000);
  CHECK(out_of_view > 1000);
}

TEST_CASE("arm and hand keep the configured distance from the partner") {
  const hal::JointVector q = forward();
  const hal::Vec3 palm = hal::hand_pose(hal::built_in_robot(), q).translation();
  const auto map = map_with({});
  const auto free_with_partner_at = [&](const hal::Vec3& p) {
    const std::vector<Eigen::Vector3f> points{p.cast<float>()};
    auto fast = checker(share(planner::make_collision_scene(map, kFloor, points, measured_only())));
    return fast.is_free(q);
  };
  auto alone = checker(share(planner::make_collision_scene(map, kFloor, {}, measured_only())));
  REQUIRE(alone.is_free(q));
  CHECK_FALSE(free_with_partner_at(palm));
  // beside the hand, whose body is 45 mm from its middle to its side
  CHECK_FALSE(free_with_partner_at(palm + hal::Vec3(0, 0.16, 0)));
  CHECK(free_with_partner_at(palm + hal::Vec3(0, 0.40, 0)));
}

TEST_CASE("what obstructed a path keeps the robot as far away as it is asked to") {
  const hal::JointVector q = forward();
  const hal::Vec3 palm = hal::hand_pose(hal::built_in_robot(), q).translation();
  const auto map = map_with({});
  const auto scene = planner::make_collision_scene(map, kFloor, {}, measured_only());
  const auto free = [&](double beside_m, double clearance_m) {
    const std::vector<Eigen::Vector3f> points{(palm + hal::Vec3(0, beside_m, 0)).cast<float>()};
    auto fast = checker(share(planner::with_obstacle(scene, map.grid(), points, clearance_m)));
    return fast.is_free(q);
  };
  CHECK(free(0.30, 0.10));
  CHECK_FALSE(free(0.30, 0.28));  // the hand's body is 45 mm from its middle to its side
  CHECK(free(0.70, 0.28));
  CHECK_FALSE(free(0.0, 0.0));
}

TEST_CASE("fingers may be beside the target at the grasp, nothing may on the way") {
  const hal::JointVector q = forward();
  const hal::Pose X_WH = hal::hand_pose(hal::built_in_robot(), q);
  auto map = map_with({});
  const std::vector<hal::Vec3> points{X_WH * hal::Vec3(0, 0, 0.03)};
  map.set_target(points);
  auto fast = checker(share(planner::make_collision_scene(map, kFloor, {}, measured_only())));
  planner::ExactChecker exact(hal::built_in_robot(), map, kFloor);
  CHECK_FALSE(fast.is_free(q));
  CHECK(fast.what_touches(q).with == Touch::With::Target);
  fast.allow(Contacts::FingersOnTarget);
  exact.allow(Contacts::FingersOnTarget);
  CHECK(fast.is_free(q));
  CHECK(exact.what_touches(q).with == Touch::With::Nothing);

  // the same where the forearm is
  std::vector<hal::Pose> X_WL;
  hal::link_poses(hal::built_in_robot(), q, {}, X_WL);
  map.set_target(std::vector<hal::Vec3>{X_WL[static_cast<std::size_t>(hal::built_in_robot().arm[3])] *
                                        hal::Vec3(0, 0, 0.1)});
  auto again = checker(share(planner::make_collision_scene(map, kFloor, {}, measured_only())));
  again.allow(Contacts::FingersOnTarget);
  CHECK(again.what_touches(q).with == Touch::With::Target);
  CHECK(again.what_touches(q).part == "forearm");
  planner::ExactChecker judge(hal::built_in_robot(), map, kFloor);
  judge.allow(Contacts::FingersOnTarget);
  CHECK(judge.what_touches(q).with == Touch::With::Target);
}

TEST_CASE("a carried object may leave what it stood on upwards, and meet nothing else") {
  const hal::JointVector q = forward();
  const hal::Pose X_WH = hal::hand_pose(hal::built_in_robot(), q);
  const hal::Vec3 tip = X_WH * hal::Vec3(0, 0, 0.10);
  // a bar from the hand outwards; below its far end a support that it touches
  std::vector<hal::Vec3> bar;
  for (int i = 0; i < 20; ++i) bar.push_back(tip + hal::Vec3(0, 0.02 * i, 0));
  const hal::Vec3 end = bar.back();
  const auto scene_with = [&](const std::vector<hal::Vec3>& obstacles) {
    auto map = map_with(obstacles);
    map.set_target(bar);
    return share(planner::make_collision_scene(map, kFloor, {}, measured_only()));
  };
  const auto turned = [&](double by) {  // A1 swings the bar's end about the base
    hal::JointVector moved = q;
    moved[0] += by;
    return moved;
  };
  const auto carrying = [&](std::shared_ptr<const planner::CollisionScene> scene) {
    auto fast = checker(std::move(scene));
    fast.allow(Contacts::Carrying);
    fast.set_carry_origin(X_WH);
    return fast;
  };
  // a post: fewer cells beside the target would be a speck of the depth image
  const auto post = [](const hal::Vec3& top) {
    std::vector<hal::Vec3> cells;
    for (int i = 0; i < 14; ++i) cells.push_back(top - hal::Vec3(0, 0, 0.02 * i));
    return cells;
  };
  const auto plate = [](const hal::Vec3& middle) {
    std::vector<hal::Vec3> cells;
    for (int i = -2; i <= 2; ++i)
      for (int j = -2; j <= 2; ++j) cells.push_back(middle + hal::Vec3(0.02 * i, 0.02 * j, 0));
    return cells;
  };
  auto nothing_near = carrying(scene_with({}));
  CHECK(nothing_near.is_free(q));
  CHECK(nothing_near.is_free(turned(0.2)));

  // an obstacle where the end of the bar will come to
  const hal::Vec3 swung = Eigen::AngleAxisd(0.2, hal::Vec3::UnitZ()) * end;
  auto blocked = carrying(scene_with(post(swung + hal::Vec3(0, 0, 0.06))));
  CHECK(blocked.is_free(q));
  const Touch touch = blocked.what_touches(turned(0.2));
  CHECK(touch.with == Touch::With::Carried);
  CHECK(touch.text().find("the carried object") == 0);

  // a lone cell there is a speck
  CHECK(carrying(scene_with({swung})).is_free(turned(0.2)));

  // a support two cells below is touched at the start, and excused only while the bar rises
  auto supported = carrying(scene_with(plate(end - hal::Vec3(0, 0, 0.04))));
  CHECK(supported.is_free(q));
  hal::JointVector down = q;
  down[1] += 0.06;
  CHECK_FALSE(supported.is_free(down));
  hal::JointVector up = q;
  up[1] -= 0.04;
  CHECK(supported.is_free(up));
}

TEST_CASE("links keep their clearance from the ground, the base stands on it") {
  auto fast = checker(share(planner::make_collision_scene(map_with({}), kFloor, {}, {})));
  CHECK(fast.is_free(hal::JointVector::Zero()));
  hal::JointVector q = hal::JointVector::Zero();
  q[1] = 1.9;
  const Touch touch = fast.what_touches(q);
  CHECK(touch.with == Touch::With::Ground);
  CHECK(touch.text().find("too near to the ground") != std::string::npos);
  planner::ExactChecker exact(hal::built_in_robot(), map_with({}), kFloor);
  CHECK(exact.what_touches(q).with == Touch::With::Ground);
  CHECK(exact.what_touches(hal::JointVector::Zero()).with == Touch::With::Nothing);
}

TEST_CASE("a touch is said in words, with what and by how much") {
  CHECK(Touch{Touch::With::Obstacle, "forearm", 0.0121}.text() ==
        "forearm comes 12 mm too near to an obstacle");
  CHECK(Touch{Touch::With::Itself, "palm and base", 0.004}.text() ==
        "palm and base come 4 mm too near to each other");
  CHECK(Touch{Touch::With::Target, "forearm_end", 0.0}.text() == "forearm end touches the object");
  CHECK(Touch{Touch::With::Limits, "arm_3", 0.1}.text() == "arm 3 is 5.7 deg beyond its limit");
}
