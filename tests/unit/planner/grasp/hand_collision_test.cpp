#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "planner/hand/hand_collision.hpp"

using namespace colift;
using hal::Vec3;
using planner::CollisionConfig;
using planner::GraspCandidate;
using planner::HandCollision;
using planner::HandModel;
using planner::Obstacles;

namespace {

/// Even numbers between 0 and 1 from a counter; the same on every machine.
class Numbers {
 public:
  double next() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) * 0x1.0p-53;
  }
  double between(double low, double high) { return low + (high - low) * next(); }
  Vec3 direction() {
    const double z = between(-1, 1), a = between(0, 2 * std::numbers::pi), r = std::sqrt(1 - z * z);
    return {r * std::cos(a), r * std::sin(a), z};
  }

 private:
  std::uint64_t state_ = 7;
};

/// A table top with legs as points every 2 cm or so, and some in mid-air.
Obstacles table_points(Numbers& numbers) {
  Obstacles o;
  const auto add = [&](double x, double y, double z) {
    o.add({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)},
          planner::ObstacleKind::Object);
  };
  for (int i = 0; i < 900; ++i) add(numbers.between(-0.3, 0.3), numbers.between(-0.2, 0.2), 0.4);
  for (int i = 0; i < 200; ++i) add(numbers.between(-0.3, 0.3), -0.2, numbers.between(0.37, 0.4));
  for (int i = 0; i < 200; ++i) add(0.26, -0.17, numbers.between(0.0, 0.37));
  for (int i = 0; i < 100; ++i) {
    o.add({static_cast<float>(numbers.between(-0.5, 0.5)), static_cast<float>(numbers.between(-0.5, 0.5)),
           static_cast<float>(numbers.between(0.0, 0.8))},
          planner::ObstacleKind::Surroundings);
  }
  o.set_ground({Vec3::UnitZ(), 0.0});
  o.build();
  return o;
}

GraspCandidate random_candidate(Numbers& numbers) {
  GraspCandidate c;
  c.kind = numbers.next() < 0.5 ? planner::GraspKind::Ega5 : planner::GraspKind::Wrap;
  c.position = {numbers.between(-0.45, 0.45), numbers.between(-0.35, 0.35), numbers.between(0.15, 0.65)};
  c.approach = numbers.direction();
  const auto [u, v] = hal::tangents(c.approach);
  const double a = numbers.between(0, 2 * std::numbers::pi);
  c.closing = std::cos(a) * u + std::sin(a) * v;
  c.width = numbers.between(0.005, 0.19);
  return c;
}

std::optional<planner::Collision> met_by(const Vec3& point_H, double width,
                                         const CollisionConfig& config = {}) {
  const HandCollision hand(HandModel{}, config);
  Obstacles o;
  o.add(point_H.cast<float>(), planner::ObstacleKind::Object);
  o.build();
  const planner::HandPlacement at{hal::Pose::Identity(), width, 0.03, 0.005};
  return hand.check(at, o);
}

}  // namespace

TEST_CASE("the quick test gives the exact test's verdict on 10 000 random candidates", "[collision]") {
  Numbers numbers;
  const Obstacles obstacles = table_points(numbers);
  const HandCollision hand(HandModel{}, CollisionConfig{});
  int collisions = 0, with_points = 0, different = 0;
  for (int i = 0; i < 10000; ++i) {
    auto placement = hand.place(random_candidate(numbers), nullptr);
    // without a view there is no allowance for ragged edges: half of the hands get one
    if (i % 2 == 0) placement.ragged_m = 0.01;
    const auto quick = hand.check(placement, obstacles), exact = hand.check_exact(placement, obstacles);
    if (quick.has_value() != exact.has_value()) {
      ++different;
    } else if (quick) {
      if (quick->part != exact->part || quick->with != exact->with || quick->depth_m != exact->depth_m ||
          quick->at != exact->at) {
        ++different;
      }
      ++collisions;
      if (quick->with != planner::Collision::With::Ground) ++with_points;
    }
  }
  CHECK(different == 0);
  // else the agreement says nothing
  CHECK(collisions < 9500);
  CHECK(with_points > 2000);
}

TEST_CASE("every placement of the open hand on its way counts", "[collision]") {
  // independent of the drawn-out boxes: the open hand itself, put at 200 places along the approach
  const HandModel model;
  const HandCollision hand(model, CollisionConfig{});
  Numbers numbers;
  int hits = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p(numbers.between(-0.06, 0.06), numbers.between(-0.2, 0.2), numbers.between(-0.2, 0.06));
    bool touched = false;
    for (int k = 0; k <= 200 && !touched; ++k) {
      const double t = 0.1 * k / 200.0;
      for (const auto& box : hand.sweep().fixed_boxes()) touched |= box.depth(p.x(), p.y(), p.z() + t) >= 0.0;
      for (std::size_t l = 0; l < hand.sweep().links(); ++l) {
        touched |= hand.sweep().finger_boxes(0)[l].depth(p.x(), p.y(), p.z() + t) >= 0.0;
      }
    }
    const auto hit = hand.sweep().first_hit(p, 0);
    if (touched) {
      ++hits;
      CHECK(hit);
    }
    if (hit && hit->depth_m > 0.001) CHECK(touched);
  }
  CHECK(hits > 300);
}

TEST_CASE("a point in the palm is named with its depth", "[collision]") {
  const auto met = met_by({0.0, 0.0, -0.014}, 0.03);
  REQUIRE(met);
  CHECK(met->text() == "palm meets the object 14 mm inside");
}

TEST_CASE("a point on the way of the approach is met though the hand ends before it", "[collision]") {
  CHECK(met_by({0.0, 0.0, -0.15}, 0.03));
  CHECK_FALSE(met_by({0.0, 0.0, -0.17}, 0.03));
}

TEST_CASE("the grasped feature is allowed between the fingers, and only there", "[collision]") {
  CHECK_FALSE(met_by({0.0, 0.014, 0.08}, 0.03));
  CHECK_FALSE(met_by({0.0, 0.0, 0.03}, 0.03));
  // where a finger passes on its way to the same width
  CHECK(met_by({0.025, -0.06, 0.08}, 0.03));
}

TEST_CASE("a wide object stops the fingers before a point that they would sweep for a thin one",
          "[collision]") {
  const Vec3 p(0.0, 0.06, 0.09);
  CHECK(met_by(p, 0.02));
  CHECK_FALSE(met_by(p, 0.16));
}

TEST_CASE("fingers that touch the object just before they have closed have taken hold of it", "[collision]") {
  const HandModel model;
  const HandCollision hand(model, CollisionConfig{});
  const auto meets = [&](double y, double ragged_m, planner::ObstacleKind kind) {
    Obstacles o;
    o.add(Eigen::Vector3f(0.0f, static_cast<float>(y), 0.10f), kind);
    o.build();
    return hand.check({hal::Pose::Identity(), 0.04, 0.03, 0.005, ragged_m}, o).has_value();
  };
  const auto object = planner::ObstacleKind::Object;
  // 8 mm beside a feature of 40 mm, of which 5 mm are allowed for noise
  CHECK(meets(0.028, 0.0, object));
  CHECK_FALSE(meets(0.028, 0.005, object));
  // another thing there, or the object much farther out, is in the way
  CHECK(meets(0.028, 0.005, planner::ObstacleKind::Surroundings));
  CHECK(meets(0.050, 0.005, object));
}

TEST_CASE("the ground refuses a hand that reaches into it, with the depth", "[collision]") {
  const HandCollision hand(HandModel{}, CollisionConfig{});
  Obstacles nothing;
  nothing.set_ground({Vec3::UnitZ(), 0.0});
  nothing.build();
  GraspCandidate c;
  c.approach = Vec3::UnitX();
  c.closing = Vec3::UnitY();
  c.width = 0.03;
  c.position = {0, 0, 0.0365};  // half a palm is 44.5 mm
  const auto met = hand.check(hand.place(c, nullptr), nothing);
  REQUIRE(met);
  CHECK(met->text() == "palm meets the ground 8 mm deep");
  c.position.z() = 0.052;
  CHECK_FALSE(hand.check(hand.place(c, nullptr), nothing));
  c.position.z() = 0.047;
  const auto near = hand.check(hand.place(c, nullptr), nothing);
  REQUIRE(near);
  CHECK_THAT(near->text(), Catch::Contains("above the ground, too near"));
}

TEST_CASE("a lone pixel in mid-air is no obstacle, a small thing is", "[collision]") {
  hal::DepthFrame frame;
  frame.depth_m.assign(640 * 480, 3.0f);
  frame.depth_m[240 * 640 + 300] = 1.5f;
  for (int v = 200; v < 203; ++v) {
    for (int u = 200; u < 203; ++u) frame.depth_m[static_cast<std::size_t>(v * 640 + u)] = 1.5f;
  }
  const auto cloud = perception::deproject(frame, hal::Pose::Identity());
  perception::Scene scene;
  scene.target.emplace();
  scene.target->aabb = hal::Aabb(Vec3(-0.4, -0.4, 1.4), Vec3(0.4, 0.4, 1.6));
  const auto obstacles = planner::gather_obstacles(scene, &cloud, planner::ObstacleConfig{});
  CHECK(obstacles.size() == 9);
}
