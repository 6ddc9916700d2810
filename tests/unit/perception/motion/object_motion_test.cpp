#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>

#include <limits>
#include <string>

#include "moving_object.hpp"

using namespace colift;
using namespace colift::perception;
using namespace colift::perception::test;
using hal::Pose;
using hal::Vec3;

namespace {

const Vec3 kUp = Vec3::UnitZ();

struct Errors {
  std::vector<double> rise_mm, tilt_deg;
  int lost = 0;
};

/// Lifts the object in `frames` steps of at most 4 mm while the partner holds it.
void follow_lift(const MovingObject& stage, int frames, Errors& errors) {
  auto follower = stage.follower();
  for (int i = 1; i <= frames; ++i) {
    const Pose X = stage.lift(static_cast<double>(i) / frames);
    const auto seen = follower.update(stage.see(stage.moved(X), static_cast<std::uint64_t>(i)));
    if (!seen) {
      ++errors.lost;
      continue;
    }
    const MotionError e = error_of(*seen, X, stage.scene.cog);
    errors.rise_mm.push_back(1e3 * std::abs(e.rise_m));
    errors.tilt_deg.push_back(degrees(e.tilt_rad));
  }
}

void cover(hal::DepthFrame& frame, int u_begin, int u_end, float depth_m) {
  const int width = frame.intrinsics.width;
  for (int v = 0; v < frame.intrinsics.height; ++v)
    for (int u = std::max(0, u_begin); u < std::min(width, u_end); ++u)
      frame.depth_m[static_cast<std::size_t>(v * width + u)] = depth_m;
}

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

TEST_CASE("rise and tilt of a lift are followed while a partner holds the object") {
  const auto [kind, name] = GENERATE(table<ObjectKind, std::string>({{ObjectKind::Table, "table"},
                                                                     {ObjectKind::Box, "box"},
                                                                     {ObjectKind::Chair, "chair"},
                                                                     {ObjectKind::Pipe, "pipe"}}));
  INFO(name);
  Errors errors;
  for (const std::uint64_t seed : {11, 12}) follow_lift(MovingObject(kind, seed), 16, errors);
  CHECK(errors.lost == 0);
  INFO("rise " << quantile(errors.rise_mm, 0.5) << ", " << quantile(errors.rise_mm, 0.95) << " mm; tilt "
               << quantile(errors.tilt_deg, 0.5) << ", " << quantile(errors.tilt_deg, 0.95) << " deg");
  CHECK(quantile(errors.rise_mm, 0.5) <= 1.5);
  CHECK(quantile(errors.rise_mm, 0.95) <= 4.0);
  CHECK(quantile(errors.tilt_deg, 0.5) <= 0.15);
  CHECK(quantile(errors.tilt_deg, 0.95) <= 0.4);
}

TEST_CASE("an object at rest does not drift, and its tilt is quiet") {
  const MovingObject stage(ObjectKind::Chair, 4);
  auto follower = stage.follower();
  const auto view =
      sim_hal::cast_rays(stage.moved(Pose::Identity()), stage.scene.intrinsics, stage.scene.X_WC);
  double squares = 0.0, first = 0.0, last = 0.0;
  constexpr int kFrames = 60;
  for (int i = 0; i < kFrames; ++i) {
    const auto seen = follower.update(sim_hal::measure(view, {}, 900 + static_cast<std::uint64_t>(i)));
    REQUIRE(seen);
    squares += std::pow(degrees(seen->tilt(kUp)), 2);
    (i < kFrames / 2 ? first : last) += 1e3 * seen->rise(stage.scene.cog, kUp) / (kFrames / 2);
  }
  CHECK(std::sqrt(squares / kFrames) <= 0.1);
  CHECK(std::abs(last - first) <= 0.1);  // mm
}

TEST_CASE("the covariance tells how far the estimate is off") {
  // squared error over variance has mean 1 for the rise and 2 for the two tilts when the claim is right
  double rise = 0.0, tilt = 0.0;
  int n = 0;
  for (const std::uint64_t seed : {21, 22, 23, 24}) {
    const MovingObject stage(ObjectKind::Box, seed, 5);
    auto follower = stage.follower();
    for (int i = 0; i < 5; ++i) {
      const Pose X = stage.lift(0.1 * i);
      const auto seen = follower.update(stage.see(stage.moved(X), static_cast<std::uint64_t>(i)));
      REQUIRE(seen);
      const Vec3 off = seen->X_WTnow_WTref * stage.scene.cog - X * stage.scene.cog;
      rise += std::pow(off.z() / seen->rise_sigma(kUp), 2);
      tilt += std::pow(error_of(*seen, X, stage.scene.cog).tilt_rad / seen->tilt_sigma(kUp), 2);
      ++n;
    }
  }
  CHECK(rise / n < 4.0);
  CHECK(tilt / n < 6.0);
  CHECK(rise / n > 0.05);
  CHECK(tilt / n > 0.1);
}

TEST_CASE("what a table top alone cannot tell is said and does not wander") {
  MovingObject stage(ObjectKind::Table, 4);
  // keep only the top: pixels near its height
  const double top = stage.scene.faces.front().center.z();
  std::erase_if(stage.target.pixels, [&](std::uint32_t i) {
    return std::abs(static_cast<double>(stage.reference.cloud.z[i]) - top) > 0.015;
  });
  auto follower = stage.follower();
  const Vec3 shift(0.0, 0.0, 0.05);
  for (int i = 1; i <= 15; ++i) {
    const Pose X = stage.motion(Vec3::UnitX(), radians(0.2 * i), shift * i / 15.0);
    const auto seen = follower.update(stage.see(stage.moved(X, false), static_cast<std::uint64_t>(i)));
    REQUIRE(seen);
    const MotionError e = error_of(*seen, X, stage.scene.cog);
    CHECK(degrees(e.tilt_rad) < 0.4);
    CHECK(std::abs(e.rise_m) < 0.006);
    const Vec3 off = seen->X_WTnow_WTref * seen->center_W - X * seen->center_W;
    CHECK(off.norm() < 0.03);
  }
  const auto& c = follower.last().covariance;
  CHECK(follower.last().rise_sigma(kUp) < 0.02);
  CHECK(std::sqrt(c(0, 0) + c(1, 1)) > 0.05);  // it may slide
  CHECK(degrees(follower.last().tilt_sigma(kUp)) < 0.3);
}

TEST_CASE("along what the view does not hold, an object is where the hand has it") {
  MovingObject stage(ObjectKind::Table, 4);
  const double top = stage.scene.faces.front().center.z();
  std::erase_if(stage.target.pixels, [&](std::uint32_t i) {
    return std::abs(static_cast<double>(stage.reference.cloud.z[i]) - top) > 0.015;
  });
  auto alone = stage.follower(), held = stage.follower();
  const Vec3 grasp = stage.scene.cog + Vec3(0.3, 0.1, 0.0), slip(0.0, 0.0, 0.004);
  Vec3 off_alone, off_held;
  double turned_rad = 0.0;
  for (int i = 1; i <= 30; ++i) {
    const Pose X = stage.motion(Vec3::UnitX(), radians(0.1 * i), Vec3(0.05, 0.02, 0.05) * i / 30.0);
    const auto frame = stage.see(stage.moved(X, false), static_cast<std::uint64_t>(i));
    const auto a = alone.update(frame);
    const auto h = held.update(frame, nullptr, HeldPoint{grasp, X * grasp + slip});
    REQUIRE((a && h));
    off_alone = a->X_WTnow_WTref * grasp - X * grasp;
    off_held = h->X_WTnow_WTref * grasp - X * grasp;
    turned_rad = std::max(turned_rad,
                          std::abs(Eigen::AngleAxisd(Eigen::Matrix3d(h->X_WTnow_WTref.linear() *
                                                                     a->X_WTnow_WTref.linear().transpose()))
                                       .angle()));
  }
  CHECK(off_alone.head<2>().norm() > 0.03);
  CHECK(off_held.head<2>().norm() < 0.01);
  CHECK(std::abs(off_held.z()) < 0.003);  // the height is seen, and that the object slipped in the hand
  CHECK(degrees(turned_rad) < 1.0);
  CHECK(held.last().covariance(0, 0) < 0.25 * alone.last().covariance(0, 0));
  // of every point of the object: its variance is one
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 6, 6>> of(held.last().covariance);
  CHECK(of.eigenvalues().minCoeff() > -1e-9 * of.eigenvalues().maxCoeff());
}

TEST_CASE("a pipe that may roll is followed in all the rest") {
  const MovingObject stage(ObjectKind::Pipe, 3);
  const Vec3 axis = stage.scene.cylinders.front().axis;
  auto follower = stage.follower();
  for (int i = 1; i <= 12; ++i) {
    const Pose X = stage.lift(i / 12.0);
    const auto seen = follower.update(stage.see(stage.moved(X), static_cast<std::uint64_t>(i)));
    REQUIRE(seen);
    const Vec3 now = seen->X_WTnow_WTref.linear() * axis, truth = X.linear() * axis;
    CHECK(degrees(std::asin(std::min(1.0, now.cross(truth).norm()))) < 0.3);
    const Eigen::AngleAxisd whole(Eigen::Matrix3d(seen->X_WTnow_WTref.linear() * X.linear().transpose()));
    CHECK(degrees(std::abs(whole.angle() * whole.axis().dot(axis))) < 1.0);  // no roll was made up
  }
  const Eigen::Matrix3d turns = follower.last().covariance.bottomRightCorner<3, 3>();
  CHECK(std::sqrt(axis.dot(turns * axis)) > 0.1);
}

TEST_CASE("frames without a view of the object are refused with the reason, and it is found again") {
  const MovingObject stage(ObjectKind::Box, 2);
  auto follower = stage.follower();
  std::string reason;
  const auto still = stage.see(stage.moved(Pose::Identity(), false), 1);
  REQUIRE(follower.update(still, &reason));
  CHECK(reason.empty());
  const Pose before = follower.last().X_WTnow_WTref;

  SECTION("no depth at all") {
    auto frame = still;
    std::fill(frame.depth_m.begin(), frame.depth_m.end(), kNan);
    CHECK_FALSE(follower.update(frame, &reason));
    CHECK(reason.find("100 % have no depth") != std::string::npos);
  }
  SECTION("somebody stands in front") {
    auto frame = still;
    cover(frame, 0, 640, 0.7f);
    CHECK_FALSE(follower.update(frame, &reason));
    CHECK(reason.find("100 % are hidden behind something nearer") != std::string::npos);
  }
  SECTION("another camera's frame") {
    auto frame = still;
    frame.intrinsics.width = 320;
    CHECK_FALSE(follower.update(frame, &reason));
    CHECK(reason.find("320 x 480") != std::string::npos);
  }
  CHECK(follower.last().X_WTnow_WTref.isApprox(before));
  // the object was lifted in the meantime
  const Pose X = stage.motion(Vec3::UnitX(), 0.0, {0.0, 0.0, 0.04});
  const auto seen = follower.update(stage.see(stage.moved(X, false), 2), &reason);
  INFO(reason);
  REQUIRE(seen);
  CHECK(std::abs(error_of(*seen, X, stage.scene.cog).rise_m) < 0.004);
}

TEST_CASE("an object that was put down while nobody looked is followed from where it stood") {
  const MovingObject stage(ObjectKind::Table, 6);
  auto follower = stage.follower(), fresh = stage.follower();
  for (int i = 1; i <= 16; ++i)
    REQUIRE(follower.update(stage.see(stage.moved(stage.lift(i / 16.0)), static_cast<std::uint64_t>(i))));
  follower.start_again();
  CHECK(follower.last().X_WTnow_WTref.isApprox(Pose::Identity()));
  CHECK(follower.last().center_W.isApprox(fresh.last().center_W));
  const auto frame = stage.see(stage.moved(Pose::Identity()), 99);
  const auto seen = follower.update(frame), as_new = fresh.update(frame);
  REQUIRE(seen);
  REQUIRE(as_new);
  CHECK(seen->X_WTnow_WTref.matrix() == as_new->X_WTnow_WTref.matrix());
}

TEST_CASE("half the object hidden by the robot's removed pixels does not matter") {
  const MovingObject stage(ObjectKind::Table, 2);
  double u_sum = 0.0;
  for (const std::uint32_t i : stage.target.pixels) u_sum += i % 640;
  const int middle = static_cast<int>(u_sum / static_cast<double>(stage.target.pixels.size()));
  auto follower = stage.follower();
  for (int i = 1; i <= 10; ++i) {
    const Pose X = stage.lift(i / 10.0);
    auto frame = stage.see(stage.moved(X), static_cast<std::uint64_t>(i));
    cover(frame, middle, 640, kNan);
    const auto seen = follower.update(frame);
    REQUIRE(seen);
    const MotionError e = error_of(*seen, X, stage.scene.cog);
    CHECK(std::abs(e.rise_m) < 0.006);
    CHECK(degrees(e.tilt_rad) < 0.6);
    CHECK(seen->seen < 0.75);
  }
}

TEST_CASE("an arm that sweeps over the top does not drag the object along") {
  const MovingObject stage(ObjectKind::Table, 5);
  auto follower = stage.follower();
  const auto& face = stage.scene.faces.front();
  double worst_rise = 0.0, worst_tilt = 0.0;
  for (int i = 0; i < 16; ++i) {
    // a forearm 3 mm above the top, as wide as an eighth of it
    auto world = stage.moved(Pose::Identity(), false);
    const double along = (i / 15.0 - 0.5) * face.width;
    const Vec3 middle = face.center + along * face.u + 0.043 * kUp;
    world.shapes.push_back(sim_hal::capsule(middle - 0.5 * face.height * face.v,
                                            middle + 0.5 * face.height * face.v, 0.04, Label::Partner));
    const auto seen = follower.update(stage.see(world, static_cast<std::uint64_t>(i)));
    REQUIRE(seen);
    worst_rise = std::max(worst_rise, std::abs(seen->rise(stage.scene.cog, kUp)));
    worst_tilt = std::max(worst_tilt, degrees(seen->tilt(kUp)));
  }
  CHECK(worst_rise < 0.003);
  CHECK(worst_tilt < 0.3);
}

TEST_CASE("the same frames give the same bits") {
  const MovingObject stage(ObjectKind::Box, 3, 3);
  auto a = stage.follower(), b = stage.follower();
  for (int i = 1; i <= 3; ++i) {
    const auto frame = stage.see(stage.moved(stage.lift(0.1 * i)), static_cast<std::uint64_t>(i));
    const auto one = a.update(frame), two = b.update(deproject(frame, stage.scene.X_WC));
    REQUIRE((one && two));
    CHECK(one->X_WTnow_WTref.matrix() == two->X_WTnow_WTref.matrix());
  }
}

TEST_CASE("a target that cannot be followed is refused") {
  MovingObject stage(ObjectKind::Box, 3, 1);
  const auto refused = [&] {
    return ObjectFollower::make(stage.reference, stage.target, NoiseModel{}, MotionConfig{}).error().code;
  };
  SECTION("without pixels") {
    stage.target.pixels.clear();
    CHECK(refused() == hal::ErrorCode::BadInput);
  }
  SECTION("with pixels of a larger image") {
    stage.target.pixels.push_back(640 * 480);
    CHECK(refused() == hal::ErrorCode::BadInput);
  }
  SECTION("too small") {
    stage.target.pixels.resize(20);
    CHECK(refused() == hal::ErrorCode::NotFound);
  }
}
