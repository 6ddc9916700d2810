#pragma once

// A back end for a camera that CoLift does not know: what example 06 shows and tests/package puts to the
// test.

#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "hal/depth_camera.hpp"

namespace example {

/// What a maker's library gives: millimetres, 0 where nothing was measured.
struct RawImage {
  std::vector<std::uint16_t> depth_mm;
  colift::hal::Timestamp exposed_at{0};
};

/// Stands for the call of the maker's library; empty when no image came in that time.
using Grab = std::function<std::optional<RawImage>(std::chrono::milliseconds timeout)>;

/// The life of a device is configure(), activate(), next_frame() ..., deactivate(); who calls in another
/// order gets NotReady. A frame is in metres with NaN for what was not measured, and newer than the one
/// before.
class OwnCamera : public colift::hal::DepthCamera {
 public:
  OwnCamera(Grab grab, const colift::hal::CameraIntrinsics& intrinsics)
      : grab_(std::move(grab)), intrinsics_(intrinsics) {}

  [[nodiscard]] colift::hal::Result<> configure() override {
    health_.state = State::Opening;  // here the maker's library would open the device
    open_ = true;
    return {};
  }
  [[nodiscard]] colift::hal::Result<> activate() override {
    if (!open_) return not_ready("activate", "call configure() first");
    active_ = true;
    return {};
  }
  void deactivate() noexcept override { active_ = false; }
  [[nodiscard]] colift::hal::DeviceHealth health() const override { return health_; }

  [[nodiscard]] colift::hal::Result<colift::hal::DepthFrame> next_frame(
      std::chrono::milliseconds timeout) override {
    using namespace colift::hal;
    if (!active_) return not_ready("next_frame", "the camera is not active");
    const auto raw = grab_(timeout);
    if (!raw) return failure(ErrorCode::Timeout, "own_camera.next_frame", "no image in time");
    const auto pixels =
        static_cast<std::size_t>(intrinsics_.width) * static_cast<std::size_t>(intrinsics_.height);
    if (raw->depth_mm.size() != pixels || raw->exposed_at <= last_) {
      ++health_.rejected;
      return failure(ErrorCode::Timeout, "own_camera.next_frame", "an image of wrong size or an old one");
    }
    DepthFrame frame;
    frame.exposed_at = last_ = raw->exposed_at;
    frame.intrinsics = intrinsics_;
    frame.depth_m.reserve(pixels);
    for (const std::uint16_t mm : raw->depth_mm) frame.depth_m.push_back(mm == 0 ? NAN : 0.001f * mm);
    ++health_.accepted;
    health_.state = State::Streaming;
    return frame;
  }

 private:
  using State = colift::hal::DeviceHealth::State;
  static tl::unexpected<colift::hal::Error> not_ready(const char* where, const char* detail) {
    return colift::hal::failure(colift::hal::ErrorCode::NotReady, std::string("own_camera.") + where, detail);
  }

  Grab grab_;
  colift::hal::CameraIntrinsics intrinsics_;
  colift::hal::Timestamp last_{-1};
  colift::hal::DeviceHealth health_;
  bool open_ = false, active_ = false;
};

}  // namespace example
