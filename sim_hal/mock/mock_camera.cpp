#include "sim_hal/mock/mock_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {

using hal::ErrorCode;
using State = hal::DeviceHealth::State;

MockCamera::MockCamera(CameraScript script, hal::ManualClock& clock)
    : script_(std::move(script)), clock_(clock), start_(clock.now()) {}

hal::Timestamp MockCamera::due(std::uint64_t frame) const {
  return start_ + script_.period * static_cast<hal::Duration::rep>(frame);
}

std::uint64_t MockCamera::newest_due() const {
  return static_cast<std::uint64_t>(
      std::max<hal::Duration::rep>((clock_.now() - start_) / script_.period, 0));
}

tl::unexpected<hal::Error> MockCamera::drop_link(std::string where) {
  health_.state = State::Lost;
  health_.last_error = fmt::format("the camera is unplugged since {:.3f} s", hal::seconds(clock_.now()));
  return hal::failure(ErrorCode::LinkLost, std::move(where), health_.last_error);
}

hal::Result<> MockCamera::configure() {
  const hal::CameraIntrinsics& k = script_.intrinsics;
  if (!script_.world || k.width <= 0 || k.height <= 0 || !(script_.period.count() > 0)) {
    health_.state = State::Failed;
    health_.last_error = fmt::format(
        "a script needs a world, at least one pixel and a period, found {} world, {} x {} pixels, {} ns",
        script_.world ? "a" : "no", k.width, k.height, script_.period.count());
    return hal::failure(ErrorCode::BadConfig, "mock_camera.configure", health_.last_error);
  }
  if (faults_.at(newest_due()) == Fault::Unplug) return drop_link("mock_camera.configure");
  // what went by while the link was down was never seen
  if (health_.state == State::Lost) next_ = std::max(next_, newest_due());
  health_.state = State::Opening;
  return {};
}

hal::Result<> MockCamera::activate() {
  if (health_.state != State::Opening && health_.state != State::Streaming)
    return hal::failure(ErrorCode::NotReady, "mock_camera.activate",
                        "the camera is not open, call configure() first");
  health_.state = State::Streaming;
  return {};
}

void MockCamera::deactivate() noexcept {
  if (health_.state == State::Streaming || health_.state == State::Stalled) health_.state = State::Opening;
}

hal::DepthFrame MockCamera::render(std::uint64_t frame) const {
  const Rendering truth = cast_rays(script_.world(frame), script_.intrinsics, script_.X_WC);
  return script_.ideal ? measure_ideal(truth) : measure(truth, script_.noise, hash(script_.seed, 0, frame));
}

hal::Result<hal::DepthFrame> MockCamera::next_frame(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = "mock_camera.next_frame";
  if (health_.state == State::Lost) return hal::failure(ErrorCode::LinkLost, kWhere, health_.last_error);
  if (health_.state != State::Streaming && health_.state != State::Stalled)
    return hal::failure(ErrorCode::NotReady, kWhere, "the camera does not stream, call activate() first");

  const hal::Timestamp deadline = clock_.now() + std::max(timeout, std::chrono::milliseconds(0));
  // the newest frame that is due already, unless a fault keeps it back
  std::uint64_t frame = std::max(next_, newest_due());
  if (due(frame) <= clock_.now())
    while (frame > next_ && faults_.at(frame) == Fault::Drop) --frame;
  for (; std::max(due(frame), clock_.now()) <= deadline; ++frame) {
    const auto fault = faults_.at(frame);
    if (due(frame) > clock_.now()) clock_.advance(due(frame) - clock_.now());
    if (fault == Fault::Drop) {
      ++health_.rejected;
      next_ = frame + 1;
      continue;
    }
    if (fault == Fault::Unplug) return drop_link(kWhere);
    return deliver(frame, fault);
  }
  if (deadline > clock_.now()) clock_.advance(deadline - clock_.now());
  health_.state = State::Stalled;
  health_.last_error = fmt::format("no frame within {} ms", timeout.count());
  return hal::failure(ErrorCode::Timeout, kWhere, health_.last_error);
}

hal::Result<hal::DepthFrame> MockCamera::deliver(std::uint64_t frame, std::optional<Fault> fault) {
  next_ = frame + 1;
  health_.state = State::Streaming;
  ++health_.accepted;
  hal::DepthFrame image = render(frame);
  image.exposed_at = due(frame);
  if (!fault) {
    last_good_ = image.depth_m;
  } else if (fault == Fault::Freeze) {
    // a camera that freezes with its first frame shows that one
    if (last_good_.empty()) last_good_ = image.depth_m;
    image.depth_m = last_good_;
  } else if (fault == Fault::AllNan) {
    std::fill(image.depth_m.begin(), image.depth_m.end(), std::numeric_limits<float>::quiet_NaN());
  } else if (fault == Fault::WrongSize) {
    image.depth_m.resize(image.depth_m.size() / 2);
  }
  return image;
}

}  // namespace colift::sim_hal
