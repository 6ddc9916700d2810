#include "sim_hal/mujoco/devices/sim_camera.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

using namespace colift;
using namespace colift::sim_hal;
using hal::ErrorCode;
using std::chrono::milliseconds;

namespace {

struct Rig {
  std::unique_ptr<SimWorld> world;
  std::unique_ptr<hal::DepthCamera> camera;

  explicit Rig(std::vector<DeviceFaultEvent> faults = {}, const char* noise = "kinect",
               std::uint64_t seed = 5) {
    Scenario scenario = built_in_scenario();
    scenario.camera.noise = noise;
    scenario.faults = std::move(faults);
    world = SimWorld::make(scenario, hal::built_in_robot(), seed, SimConfig{}).value();
    camera = make_sim_camera(*world);
    REQUIRE(camera->configure());
    REQUIRE(camera->activate());
  }
  [[nodiscard]] hal::Timestamp now() const { return world->clock().now(); }
  hal::DepthFrame next() {
    auto frame = camera->next_frame(milliseconds(100));
    REQUIRE(frame);
    return *std::move(frame);
  }
};

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

std::size_t seen(const hal::DepthFrame& frame) {
  return static_cast<std::size_t>(
      std::count_if(frame.depth_m.begin(), frame.depth_m.end(), [](float z) { return z > 0; }));
}

}  // namespace

TEST_CASE("a simulated camera exposes thirty times a second and moves the world to each exposure",
          "[sim][camera]") {
  Rig rig;
  CHECK(rig.next().exposed_at == milliseconds(0));
  for (const int due : {34, 67, 100, 134, 167, 200}) {
    CHECK(rig.next().exposed_at == milliseconds(due));
    CHECK(rig.now() == milliseconds(due));
  }
  for (int i = 7; i < 31; ++i) (void)rig.next();
  CHECK(rig.now() == milliseconds(1000));
}

TEST_CASE("with a timeout of zero the world stands still", "[sim][camera]") {
  Rig rig;
  (void)rig.next();
  const auto none = rig.camera->next_frame(milliseconds(0));
  REQUIRE_FALSE(none);
  CHECK(none.error().code == ErrorCode::Timeout);
  CHECK(rig.now() == milliseconds(0));
  CHECK_FALSE(rig.camera->next_frame(milliseconds(20)));
  CHECK(rig.now() == milliseconds(20));
  // somebody else moves the world: the frame is due, and shows the world as it is when it is asked for
  rig.world->advance(milliseconds(40));
  const auto frame = rig.camera->next_frame(milliseconds(0));
  REQUIRE(frame);
  CHECK(frame->exposed_at == milliseconds(60));
  CHECK(rig.now() == milliseconds(60));
  CHECK(rig.next().exposed_at == milliseconds(67));
}

TEST_CASE("of several frames that are due only one comes", "[sim][camera]") {
  Rig rig;
  rig.world->advance(milliseconds(500));
  CHECK(rig.next().exposed_at == milliseconds(500));
  CHECK_FALSE(rig.camera->next_frame(milliseconds(0)));
}

TEST_CASE("frames are the same for the same seed and differ for another, and from each other",
          "[sim][camera]") {
  Rig one, same, other({}, "kinect", 6);
  const auto a = one.next(), b = same.next(), c = other.next(), d = one.next();
  CHECK(same_bits(a.depth_m, b.depth_m));
  CHECK_FALSE(same_bits(a.depth_m, c.depth_m));
  CHECK_FALSE(same_bits(a.depth_m, d.depth_m));
}

TEST_CASE("without noise a frame is the truth, with noise it is near it", "[sim][camera]") {
  Rig ideal({}, "none"), noisy;
  const auto frame = ideal.next(), measured = noisy.next();
  const Rendering truth = render_truth(*ideal.world);
  std::size_t both = 0, off = 0;
  for (std::size_t i = 0; i < truth.depth_m.size(); ++i) {
    CHECK_FALSE((std::isnan(frame.depth_m[i]) != std::isnan(truth.depth_m[i])));
    if (truth.depth_m[i] > 0 && frame.depth_m[i] != truth.depth_m[i]) ++off;
    if (!(truth.depth_m[i] > 0) || !(measured.depth_m[i] > 0)) continue;
    ++both;
    const float z = truth.depth_m[i];
    if (std::abs(measured.depth_m[i] - z) > 0.005f * z * z + 0.003f) ++off;
  }
  CHECK(both > truth.depth_m.size() / 2);
  CHECK(off < both / 20);  // edges, flying pixels
}

TEST_CASE("truth shows ground, object and robot; the person comes with his time", "[sim][camera]") {
  Rig rig;
  const auto pixels = [&](Label label) {
    const Rendering truth = render_truth(*rig.world);
    return std::count(truth.label.begin(), truth.label.end(), label);
  };
  CHECK(pixels(Label::Ground) > 50'000);
  CHECK(pixels(Label::Target) > 8'000);
  CHECK(pixels(Label::Robot) > 2'000);
  CHECK(pixels(Label::Partner) == 0);
  rig.world->advance(milliseconds(3200));
  CHECK(pixels(Label::Partner) > 5'000);
}

TEST_CASE("up is against gravity as the camera is tilted", "[sim][camera]") {
  Rig rig;
  const auto frame = rig.next();
  REQUIRE(frame.up_C);
  const Pose X_WC = camera_pose(rig.world->scenario().camera);
  CHECK((X_WC.linear() * *frame.up_C - Vec3::UnitZ()).norm() < 1e-12);
  CHECK((X_WC.translation() - rig.world->scenario().camera.xyz).norm() == 0.0);
}

TEST_CASE("a frozen, a blind and a corrupt camera show it in their frames, and recover", "[sim][camera]") {
  Rig rig(
      {{0.09, "camera", "freeze", 0.1}, {0.19, "camera", "blind", 0.1}, {0.29, "camera", "corrupt", 0.1}});
  (void)rig.next();
  (void)rig.next();
  const auto good = rig.next();
  for (const int due : {100, 134, 167}) {
    const auto frozen = rig.next();
    CHECK(same_bits(frozen.depth_m, good.depth_m));
    CHECK(frozen.exposed_at == milliseconds(due));
  }
  for (int i = 0; i < 3; ++i) CHECK(seen(rig.next()) == 0);
  for (int i = 0; i < 3; ++i) CHECK(rig.next().depth_m.size() == 640 * 480 / 2);
  const auto well = rig.next();
  CHECK(well.depth_m.size() == 640 * 480);
  CHECK(seen(well) > 100'000);
}

TEST_CASE("a camera that drops frames times out and goes on", "[sim][camera]") {
  Rig rig({{0.05, "camera", "drop", 0.25}});
  (void)rig.next();
  (void)rig.next();
  const auto none = rig.camera->next_frame(milliseconds(100));
  REQUIRE_FALSE(none);
  CHECK(none.error().code == ErrorCode::Timeout);
  CHECK(rig.camera->health().state == hal::DeviceHealth::State::Stalled);
  CHECK(rig.now() == milliseconds(134));
  const auto frame = rig.camera->next_frame(milliseconds(1000));
  REQUIRE(frame);
  CHECK(frame->exposed_at == milliseconds(300));
  CHECK(rig.camera->health().rejected == 7);
}

TEST_CASE("a late camera shows what was, with the time when it was", "[sim][camera]") {
  Rig rig({{0.05, "camera", "late", 0.5}});
  (void)rig.next();
  (void)rig.next();
  const auto none = rig.camera->next_frame(milliseconds(100));
  REQUIRE_FALSE(none);
  const auto late = rig.camera->next_frame(milliseconds(300));
  REQUIRE(late);
  CHECK(late->exposed_at == milliseconds(67));
  CHECK(rig.now() == milliseconds(267));
}

TEST_CASE("an unplugged camera is lost until it is plugged in and configured again", "[sim][camera]") {
  Rig rig({{0.05, "camera", "unplug", 0.3}});
  (void)rig.next();
  (void)rig.next();
  const auto lost = rig.camera->next_frame(milliseconds(100));
  REQUIRE_FALSE(lost);
  CHECK(lost.error().code == ErrorCode::LinkLost);
  CHECK(rig.camera->configure().error().code == ErrorCode::LinkLost);
  rig.world->advance(milliseconds(400));
  CHECK(rig.camera->next_frame(milliseconds(0)).error().code == ErrorCode::LinkLost);
  REQUIRE(rig.camera->configure());
  REQUIRE(rig.camera->activate());
  CHECK(rig.next().exposed_at >= milliseconds(467));
}
