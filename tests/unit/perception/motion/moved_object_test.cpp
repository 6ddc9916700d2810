#include "perception/motion/moved_object.hpp"

#include <catch2/catch.hpp>

#include "tests/unit/perception/motion/moving_object.hpp"

using namespace colift;
using perception::test::MovingObject;
using perception::test::radians;

namespace {

/// Part of the pixels that both images know and that agree to 2 cm, and part of the object that is known.
struct Agreement {
  double agree = 0.0, object_known = 0.0;
};

Agreement compare(const MovingObject& stage, const hal::Pose& X) {
  const hal::DepthFrame drawn = move_object(stage.reference.cloud, stage.target.pixels, X);
  const auto truth = sim_hal::cast_rays(stage.moved(X, false), stage.scene.intrinsics, stage.scene.X_WC);
  int known = 0, agree = 0, object = 0, object_known = 0;
  for (std::size_t p = 0; p < truth.depth_m.size(); ++p) {
    const bool is_object = truth.label[p] == sim_hal::Label::Target;
    object += is_object;
    if (!(drawn.depth_m[p] > 0.0F) || !(truth.depth_m[p] > 0.0F)) continue;
    object_known += is_object;
    ++known;
    agree += std::abs(drawn.depth_m[p] - truth.depth_m[p]) < 0.02F;
  }
  return {static_cast<double>(agree) / known, static_cast<double>(object_known) / object};
}

}  // namespace

TEST_CASE("the picture of a moved object is what the camera would see", "[moved_object]") {
  const auto kind =
      GENERATE(sim_hal::ObjectKind::Table, sim_hal::ObjectKind::Box, sim_hal::ObjectKind::Chair);
  const MovingObject stage(kind, 3);
  const hal::Pose X = stage.motion(hal::Vec3::UnitZ(), radians(2.0), {0.015, -0.01, 0.0});
  const Agreement moved = compare(stage, X);
  CAPTURE(static_cast<int>(kind), moved.agree, moved.object_known);
  CHECK(moved.agree > 0.97);
  CHECK(moved.object_known > 0.85);

  // as it stood it would not be
  const Agreement stayed = [&] {
    const auto truth = sim_hal::cast_rays(stage.moved(X, false), stage.scene.intrinsics, stage.scene.X_WC);
    int known = 0, agree = 0;
    for (std::size_t p = 0; p < truth.depth_m.size(); ++p) {
      if (!stage.reference.cloud.seen(p) || !(truth.depth_m[p] > 0.0F)) continue;
      ++known;
      agree += std::abs(stage.reference.cloud.depth_m[p] - truth.depth_m[p]) < 0.02F;
    }
    return Agreement{static_cast<double>(agree) / known, 1.0};
  }();
  CHECK(moved.agree > stayed.agree);
}

TEST_CASE("an object that did not move stays as it was, but for its rim", "[moved_object]") {
  const MovingObject stage(sim_hal::ObjectKind::Table, 5);
  const hal::DepthFrame drawn =
      move_object(stage.reference.cloud, stage.target.pixels, hal::Pose::Identity());
  for (const std::uint32_t p : stage.target.pixels)
    REQUIRE(drawn.depth_m[p] == Approx(stage.reference.cloud.depth_m[p]).margin(0.03));
  std::size_t lost = 0;
  for (std::size_t p = 0; p < drawn.depth_m.size(); ++p)
    lost += stage.reference.cloud.seen(p) && !(drawn.depth_m[p] > 0.0F);
  CHECK(lost < stage.reference.cloud.size() / 20);
}

TEST_CASE("what leaves the image is not drawn", "[moved_object]") {
  const MovingObject stage(sim_hal::ObjectKind::Box, 2);
  const hal::Pose away(Eigen::Translation3d(0.0, 0.0, 100.0));
  const hal::DepthFrame drawn = move_object(stage.reference.cloud, stage.target.pixels, away);
  for (const std::uint32_t p : stage.target.pixels) CHECK_FALSE(drawn.depth_m[p] > 0.0F);
}
