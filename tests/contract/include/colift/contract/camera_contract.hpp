#pragma once

#include <chrono>
#include <cmath>
#include <cstddef>
#include <functional>
#include <memory>

#include "colift/contract/catch.hpp"
#include "hal/depth_camera.hpp"

namespace colift::contract {

/// A depth camera under test, ready to be configured.
struct CameraUnderTest {
  std::shared_ptr<void> rig;  ///< Owns the camera and what it needs to live: clock, far end, world.
  hal::DepthCamera* camera = nullptr;
};

/// Makes one; called anew for each fact.
using MakeCamera = std::function<CameraUnderTest()>;

/// What the suite has to know about a camera and the room before it.
struct CameraTraits {
  double min_valid_fraction = 0.25;               ///< Fraction of the pixels of each frame that have depth.
  float min_depth_m = 0.1f, max_depth_m = 20.0f;  ///< Of all pixels that have depth.
  std::chrono::milliseconds frame_timeout{1000};  ///< A frame comes within this.
};

namespace detail {

inline void open(hal::DepthCamera& camera) {
  REQUIRE(camera.configure());
  REQUIRE(camera.activate());
}

inline void check_frame(const hal::DepthFrame& frame, const CameraTraits& traits) {
  const auto& k = frame.intrinsics;
  REQUIRE(frame.depth_m.size() == static_cast<std::size_t>(k.width) * static_cast<std::size_t>(k.height));
  CHECK(k.fx > 0);
  CHECK(k.fy > 0);
  std::size_t valid = 0, wrong = 0;
  for (const float depth_m : frame.depth_m) {
    if (std::isnan(depth_m)) continue;
    ++valid;
    wrong += !(depth_m > traits.min_depth_m && depth_m < traits.max_depth_m);
  }
  CHECK(static_cast<double>(valid) > traits.min_valid_fraction * static_cast<double>(frame.depth_m.size()));
  CHECK(wrong == 0);
  CHECK((frame.rgb.empty() || frame.rgb.size() == 3 * frame.depth_m.size()));
  if (frame.up_C) CHECK(std::abs(frame.up_C->norm() - 1.0) < 1e-9);
}

}  // namespace detail

/// What every hal::DepthCamera promises (hal/depth_camera.hpp, hal/device.hpp), one section for each fact. To
/// be called from a test case of its own, as contract::check_arm(). Some twenty frames in all.
inline void check_camera(const MakeCamera& make, const CameraTraits& traits = {}) {
  constexpr std::chrono::milliseconds kShort{10};
  const auto timeout = traits.frame_timeout;

  SECTION("a depth camera gives nothing before it is configured and activated") {
    const CameraUnderTest test = make();
    const auto early = test.camera->next_frame(kShort);
    REQUIRE_FALSE(early);
    CHECK(early.error().code == hal::ErrorCode::NotReady);
    CHECK_FALSE(early.error().detail.empty());
    CHECK_FALSE(test.camera->activate());
    REQUIRE(test.camera->configure());
    CHECK_FALSE(test.camera->next_frame(kShort));
    REQUIRE(test.camera->activate());
    CHECK(test.camera->next_frame(timeout));
  }

  SECTION("frames are whole, in metres, and NaN where nothing was measured") {
    const CameraUnderTest test = make();
    detail::open(*test.camera);
    for (int i = 0; i < 3; ++i) {
      const auto frame = test.camera->next_frame(timeout);
      REQUIRE(frame);
      detail::check_frame(*frame, traits);
    }
  }

  SECTION("each frame is newer than the one before") {
    const CameraUnderTest test = make();
    detail::open(*test.camera);
    const auto first = test.camera->next_frame(timeout);
    REQUIRE(first);
    hal::Timestamp last = first->exposed_at;
    // seven, so that a short recording that is played in a loop begins again
    for (int i = 0; i < 7; ++i) {
      const auto frame = test.camera->next_frame(timeout);
      REQUIRE(frame);
      CHECK(frame->exposed_at > last);
      last = frame->exposed_at;
    }
  }

  SECTION("a camera at rest gives nothing, and continues when it is activated again") {
    const CameraUnderTest test = make();
    detail::open(*test.camera);
    REQUIRE(test.camera->next_frame(timeout));
    test.camera->deactivate();
    test.camera->deactivate();
    CHECK_FALSE(test.camera->next_frame(kShort));
    REQUIRE(test.camera->activate());
    CHECK(test.camera->next_frame(timeout));
  }

  SECTION("a camera's health counts what it handed out") {
    const CameraUnderTest test = make();
    CHECK(test.camera->health().accepted == 0);
    detail::open(*test.camera);
    for (int i = 0; i < 4; ++i) REQUIRE(test.camera->next_frame(timeout));
    CHECK(test.camera->health().accepted == 4);
    CHECK(test.camera->health().rejected == 0);
    CHECK(test.camera->health().state == hal::DeviceHealth::State::Streaming);
  }
}

}  // namespace colift::contract
