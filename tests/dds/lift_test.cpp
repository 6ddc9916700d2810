// A whole lift whose every frame came over DDS, sent by the other implementation and read by the driver.

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <thread>
#include <utility>

#include "hal/drivers/ros2_camera/ros2_camera.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tests/dds/camera_rig.hpp"
#include "tests/dds/frame_messages.hpp"
#include "tests/support/simulated_lift.hpp"

namespace {

using namespace colift;
using namespace colift::tests;
using namespace std::chrono_literals;

bool same_depth(const hal::DepthFrame& a, const hal::DepthFrame& b) {
  if (a.depth_m.size() != b.depth_m.size()) return false;
  for (std::size_t i = 0; i < a.depth_m.size(); ++i)
    if (a.depth_m[i] != b.depth_m[i] && !(std::isnan(a.depth_m[i]) && std::isnan(b.depth_m[i]))) return false;
  return true;
}

/// A simulated camera whose frames are sent as a driver of ROS 2 sends them and are handed out as they were
/// received. The simulation's time stands while they are on their way.
class CameraOverDds final : public hal::DepthCamera {
 public:
  explicit CameraOverDds(std::unique_ptr<hal::DepthCamera> simulated)
      : simulated_(std::move(simulated)),
        peer_(camera_config().domain),
        image_(peer_.writer("rt/camera/depth/image_rect_raw", "sensor_msgs::msg::dds_::Image_",
                            {true, false, 5})),
        info_(peer_.writer("rt/camera/depth/camera_info", "sensor_msgs::msg::dds_::CameraInfo_",
                           {true, false, 5})),
        driver_(camera_config(), clock_) {}

  hal::Result<> configure() override { return simulated_->configure(); }
  hal::Result<> activate() override { return simulated_->activate(); }
  void deactivate() noexcept override { simulated_->deactivate(); }
  [[nodiscard]] hal::DeviceHealth health() const override { return simulated_->health(); }

  hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds timeout) override {
    auto frame = simulated_->next_frame(timeout);
    if (!frame) return frame;
    hal::DepthFrame received = send(*frame);
    received.exposed_at = frame->exposed_at;
    return received;
  }

 private:
  void publish(const hal::DepthFrame& frame) {
    (void)info_->write(bytes_of(info_of_frame(frame)));
    (void)image_->write(bytes_of(image_of_frame(frame)));
  }

  hal::DepthFrame send(const hal::DepthFrame& frame) {
    if (!opened_) {
      // the driver waits for a first frame: both ends have yet to find each other
      publish(frame);
      std::jthread sender([&](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          publish(frame);
          std::this_thread::sleep_for(20ms);
        }
      });
      if (auto done = driver_.configure(); !done) throw std::runtime_error(done.error().text());
      if (auto done = driver_.activate(); !done) throw std::runtime_error(done.error().text());
      opened_ = true;
    }
    // a message that is lost is sent again; one that comes late is not taken for the next
    for (int tries = 0; tries < 50; ++tries) {
      publish(frame);
      for (auto received = driver_.next_frame(200ms); received; received = driver_.next_frame(0ms))
        if (same_depth(*received, frame)) return *received;
    }
    throw std::runtime_error("a frame did not come through as it was sent");
  }

  std::unique_ptr<hal::DepthCamera> simulated_;
  hal::SteadyClock clock_;
  FastPeer peer_;
  std::unique_ptr<FastPeer::Writer> image_, info_;
  hal::Ros2Camera driver_;
  bool opened_ = false;
};

}  // namespace

TEST_CASE("a lift from frames over ROS 2 equals the local one", "[dds][lift]") {
  const auto scenario =
      sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/table.yaml");
  REQUIRE(scenario);
  const auto here = simulate(*scenario, control::Method::Fast, 3);
  const auto there = simulate(*scenario, control::Method::Fast, 3, control::run_defaults(), std::nullopt,
                              [](std::unique_ptr<hal::DepthCamera> simulated) {
                                return std::make_unique<CameraOverDds>(std::move(simulated));
                              });
  REQUIRE(here.record.outcome == control::RunRecord::Result::Lifted);
  CHECK(there.record.outcome == here.record.outcome);
  REQUIRE(there.record.states.size() == here.record.states.size());
  for (std::size_t i = 0; i < here.record.states.size(); ++i) {
    CHECK(there.record.states[i].at == here.record.states[i].at);
    CHECK(there.record.states[i].reason == here.record.states[i].reason);
  }
  CHECK(there.share_robot == here.share_robot);
  CHECK(there.tilt_deg == here.tilt_deg);
  CHECK(there.partner_error_m == here.partner_error_m);
}
