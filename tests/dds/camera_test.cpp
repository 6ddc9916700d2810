#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/dds/camera_rig.hpp"

namespace colift::tests {
namespace {

using namespace std::chrono_literals;
using hal::ErrorCode;
constexpr auto kSoon = 10'000ms;

void open(hal::DepthCamera& camera) {
  if (auto done = camera.configure(); !done) FAIL(done.error().text());
  REQUIRE(camera.activate());
}

/// What is wrong with what it sends; the driver has to see a word of it.
struct Lie {
  const char* name;
  FastCamera::Change change;
  const char* expected;
};

/// Its configure() fails, with the reason.
void check_refused(const Lie& lie) {
  INFO(lie.name);
  auto config = camera_config();
  config.open_s = 1.5;
  Ros2CameraRig rig(lie.change, config);
  const auto opened = rig.camera.configure();
  REQUIRE_FALSE(opened);
  CHECK(opened.error().code == ErrorCode::DeviceFault);
  CHECK_THAT(opened.error().detail, Catch::Contains(lie.expected));
  CHECK(rig.camera.health().accepted == 0);
}

}  // namespace

TEST_CASE("depth, model and time of an image over ROS 2 are those that were sent", "[dds][camera]") {
  SECTION("in millimetres") {
    Ros2CameraRig rig;
    open(rig.camera);
    const auto frame = rig.camera.next_frame(kSoon);
    REQUIRE(frame);
    CHECK(frame->intrinsics.width == 64);
    CHECK(frame->intrinsics.fx == 60.0);
    CHECK(frame->intrinsics.fy == 61.0);
    CHECK(frame->intrinsics.cx == 32.0);
    CHECK(frame->intrinsics.cy == 24.0);
    CHECK(std::isnan(frame->depth_m[64 * 30]));
    CHECK(frame->depth_m[64 * 30 + 30] == 1.5f);
    const double age_s = hal::seconds(rig.clock.now() - frame->exposed_at);
    CHECK(age_s >= 0.0);
    CHECK(age_s < 5.0);
  }
  SECTION("big endian, with padded rows") {
    Ros2CameraRig rig([](RosImage& m, RosCameraInfo&) {
      std::vector<std::uint8_t> padded(140 * 48, 0xee);
      for (std::size_t v = 0; v < 48; ++v)
        for (std::size_t u = 0; u < 64; ++u) {
          padded[140 * v + 2 * u] = m.data[128 * v + 2 * u + 1];
          padded[140 * v + 2 * u + 1] = m.data[128 * v + 2 * u];
        }
      m.data = padded, m.step = 140, m.is_bigendian = 1;
    });
    open(rig.camera);
    const auto frame = rig.camera.next_frame(kSoon);
    REQUIRE(frame);
    CHECK(frame->depth_m[64 * 30 + 30] == 1.5f);
    CHECK(std::isnan(frame->depth_m[64 * 30]));
  }
  SECTION("in metres, where what is no depth is NaN") {
    Ros2CameraRig rig([](RosImage& m, RosCameraInfo&) {
      std::vector<float> depth(64 * 48, 1.25f);
      depth[0] = -1.0f, depth[1] = std::numeric_limits<float>::infinity(), depth[2] = 0.0f, depth[3] = 1e30f;
      m.encoding = "32FC1", m.step = 256;
      m.data.assign(reinterpret_cast<std::uint8_t*>(depth.data()),
                    reinterpret_cast<std::uint8_t*>(depth.data() + depth.size()));
    });
    open(rig.camera);
    const auto frame = rig.camera.next_frame(kSoon);
    REQUIRE(frame);
    for (std::size_t i = 0; i < 4; ++i) CHECK(std::isnan(frame->depth_m[i]));
    CHECK(frame->depth_m[4] == 1.25f);
  }
}

TEST_CASE("a driver that contradicts itself is refused with the figure", "[dds][camera]") {
  const double nan = std::nan("");
  const Lie lies[] = {
      {"encoding", [](RosImage& m, RosCameraInfo&) { m.encoding = "bgr8"; }, "encoding 'bgr8'"},
      {"step", [](RosImage& m, RosCameraInfo&) { m.step = 127; }, "step 127"},
      {"bytes", [](RosImage& m, RosCameraInfo&) { m.data.pop_back(); }, "6143 bytes"},
      {"size", [](RosImage& m, RosCameraInfo&) { m.height = 47; }, "64 x 47 pixels"},
      {"absurd size", [](RosImage& m, RosCameraInfo&) { m.width = m.step = 0xffffffffu; }, "size 4294967295"},
      {"nan focal length", [nan](RosImage&, RosCameraInfo& i) { i.k[0] = nan; }, "not finite"},
      {"no calibration", [](RosImage&, RosCameraInfo& i) { i.k = {}; }, "not calibrated"},
      {"principal point", [](RosImage&, RosCameraInfo& i) { i.k[2] = 1e6; }, "principal point"},
      {"distortion model", [](RosImage&, RosCameraInfo& i) { i.distortion_model = "magic", i.d[0] = 0.1; },
       "'magic'"},
      {"distortion length", [](RosImage&, RosCameraInfo& i) { i.d.assign(3, 0.1); },
       "3 distortion coefficients"},
      {"region",
       [](RosImage&, RosCameraInfo& i) {
         i.roi = {8, 8, 32, 40};
       },
       "region of interest"},
      {"frame id", [](RosImage& m, RosCameraInfo&) { m.header.frame_id = "other"; }, "frame id"},
      {"future", [](RosImage& m, RosCameraInfo&) { m.header.stamp = system_stamp(3.0); }, "in the future"},
      {"past", [](RosImage& m, RosCameraInfo&) { m.header.stamp = system_stamp(-100.0); }, "s old"},
      {"nanoseconds", [](RosImage& m, RosCameraInfo&) { m.header.stamp.nanosec = 4'000'000'000u; },
       "10^9 ns"},
  };
  for (const Lie& lie : lies) check_refused(lie);
}

TEST_CASE("nobody publishes: the camera says what to do", "[dds][camera]") {
  hal::SteadyClock clock;
  auto config = camera_config();
  config.open_s = 0.3;
  hal::Ros2Camera camera(config, clock);
  const auto opened = camera.configure();
  REQUIRE_FALSE(opened);
  CHECK(opened.error().code == ErrorCode::LinkLost);
  CHECK_THAT(opened.error().detail, Catch::Contains("ROS_LOCALHOST_ONLY"));
}

TEST_CASE("a lie in the middle is dropped and counted, and frames go on after it", "[dds][camera]") {
  Ros2CameraRig rig;
  open(rig.camera);
  REQUIRE(rig.camera.next_frame(kSoon));
  rig.far_end.change([](RosImage& m, RosCameraInfo&) { m.encoding = "rgb8"; });
  while (rig.camera.health().rejected == 0) (void)rig.camera.next_frame(100ms);
  CHECK_THAT(rig.camera.health().last_error, Catch::Contains("rgb8"));
  rig.far_end.change({});
  CHECK(rig.camera.next_frame(kSoon));
}

TEST_CASE("a model that changes while the camera is used does not become its model", "[dds][camera]") {
  Ros2CameraRig rig;
  open(rig.camera);
  rig.far_end.change([](RosImage&, RosCameraInfo& i) { i.k[0] = 90.0; });
  while (rig.camera.health().rejected == 0) (void)rig.camera.next_frame(100ms);
  CHECK_THAT(rig.camera.health().last_error, Catch::Contains("model changed"));
  const auto frame = rig.camera.next_frame(kSoon);
  if (frame) CHECK(frame->intrinsics.fx == 60.0);
}

TEST_CASE("a second publisher is not listened to while the first is there", "[dds][camera]") {
  Ros2CameraRig rig;
  open(rig.camera);
  REQUIRE(rig.camera.next_frame(kSoon));
  const auto far = [](RosImage& m, RosCameraInfo&) {
    std::fill(m.data.begin(), m.data.end(), std::uint8_t{0x11});
  };
  const FastCamera liar(test_domain(), far);
  int frames = 0;
  while (rig.camera.health().rejected == 0 || frames < 5) {
    const auto frame = rig.camera.next_frame(kSoon);
    REQUIRE(frame);
    CHECK(frame->depth_m[64 * 30 + 30] == 1.5f);
    ++frames;
  }
  CHECK_THAT(rig.camera.health().last_error, Catch::Contains("second publisher"));
}

TEST_CASE("a driver that went away is a lost link; a new one is taken", "[dds][camera]") {
  hal::SteadyClock clock;
  auto config = camera_config();
  config.silent_s = 0.5;
  hal::Ros2Camera camera(config, clock);
  auto first = std::make_unique<FastCamera>(test_domain());
  open(camera);
  (void)camera.next_frame(kSoon);
  first.reset();
  hal::Result<hal::DepthFrame> frame = hal::DepthFrame{};
  while (frame || frame.error().code == ErrorCode::Timeout) frame = camera.next_frame(1'000ms);
  CHECK(frame.error().code == ErrorCode::LinkLost);
  CHECK(camera.health().state == hal::DeviceHealth::State::Lost);
  const FastCamera second(test_domain());
  const auto end = clock.now() + 30s;
  while (!frame && clock.now() < end) frame = camera.next_frame(100ms);
  CHECK(frame);
}

TEST_CASE("garbage on the camera's topics is never a frame", "[dds][camera]") {
  auto config = camera_config();
  config.open_s = 1.5;
  hal::SteadyClock clock;
  const std::string domain = std::to_string(test_domain());
  const PeerProcess images(
      {"flood", domain, "rt/camera/depth/image_rect_raw", "sensor_msgs::msg::dds_::Image_"});
  const PeerProcess infos(
      {"flood", domain, "rt/camera/depth/camera_info", "sensor_msgs::msg::dds_::CameraInfo_"});
  hal::Ros2Camera camera(config, clock);
  const auto begun = clock.now();
  const auto opened = camera.configure();
  CHECK_FALSE(opened);
  CHECK(hal::seconds(clock.now() - begun) < 30.0);
  CHECK(camera.health().accepted == 0);
}

TEST_CASE("with time: clock a stamp counts from /clock", "[dds][camera]") {
  auto config = camera_config();
  config.time = "clock";
  FastPeer peer(config.domain);
  const auto clock_writer = peer.writer("rt/clock", "rosgraph_msgs::msg::dds_::Clock_", {false, false, 1});
  Ros2CameraRig rig(
      [&clock_writer](RosImage& m, RosCameraInfo&) {
        static std::uint32_t tick = 0;
        const Stamp now{100 + static_cast<std::int32_t>(++tick / 30), (tick % 30) * 33'000'000u};
        (void)clock_writer->write(clock_bytes(now));
        m.header.stamp = now;
      },
      config);
  open(rig.camera);
  CHECK(rig.camera.next_frame(kSoon));
  const auto before = rig.camera.health().rejected;
  rig.far_end.change({});  // stamps of the system's clock, decades ahead
  while (rig.camera.health().rejected == before) (void)rig.camera.next_frame(100ms);
  CHECK_THAT(rig.camera.health().last_error, Catch::Contains("in the future"));
}

}  // namespace colift::tests
