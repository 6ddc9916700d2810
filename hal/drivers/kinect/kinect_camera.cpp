#include "hal/drivers/kinect/kinect_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/drivers/kinect/kinect_stream.hpp"

namespace colift::hal {

using namespace std::chrono_literals;

KinectCamera::KinectCamera(KinectConfig config, const Clock& clock)
    : stream_(std::make_unique<kinect::KinectStream>(std::move(config), clock)), clock_(clock) {}

KinectCamera::~KinectCamera() = default;

Result<> KinectCamera::configure() {
  if (auto found = stream_->find_source(); !found) return found;
  return stream_->configure();
}

Result<> KinectCamera::activate() {
  return stream_->activate();
}

void KinectCamera::deactivate() noexcept {
  stream_->deactivate();
}

DeviceHealth KinectCamera::health() const {
  return stream_->health();
}

Result<DepthFrame> KinectCamera::next_frame(std::chrono::milliseconds timeout) {
  return stream_->next_frame(timeout);
}

void KinectCamera::on_raw(std::function<void(const capture::RawFrame&, Timestamp)> call) {
  stream_->on_raw = std::move(call);
}

Result<> KinectCamera::want_infrared(bool wanted) {
  kinect::KinectStream& k = *stream_;
  constexpr auto kWhere = "kinect.infrared";
  if (!k.opened())
    return failure(ErrorCode::NotReady, kWhere, "the camera is not open, call configure() first");
  k.look_after();
  if (wanted && !k.news().infrared)
    return failure(ErrorCode::DeviceFault, kWhere,
                   "there is no infrared here: a fakenect recording holds none");
  k.infrared = wanted;
  if (wanted)
    k.ask_for_infrared();
  else
    k.send_line("infrared off");
  return {};
}

Result<InfraredFrame> KinectCamera::next_infrared(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = "kinect.next_infrared";
  kinect::KinectStream& k = *stream_;
  if (!k.active() || !k.infrared)
    return failure(ErrorCode::NotReady, kWhere, "no infrared was asked for, or the camera does not stream");
  const Timestamp deadline = clock_.now() + std::max(timeout, 0ms);
  for (;;) {
    k.look_after();
    if (auto frame = k.take_infrared()) return std::move(*frame);
    if (!k.running()) return failure(ErrorCode::LinkLost, kWhere, k.words_of_loss());
    const Timestamp now = clock_.now();
    if (now >= deadline)
      return failure(ErrorCode::Timeout, kWhere,
                     k.news().refused.empty() ? fmt::format("no image within {} ms", timeout.count())
                                              : k.news().refused);
    k.wait(deadline - now);
  }
}

Result<> KinectCamera::tilt(double degrees) {
  constexpr auto kWhere = "kinect.tilt";
  kinect::KinectStream& k = *stream_;
  if (!(std::abs(degrees) <= kinect::kTilt_deg))
    return failure(
        ErrorCode::LimitExceeded, kWhere,
        fmt::format("{} degrees, the motor goes to {} to either side", degrees, kinect::kTilt_deg));
  if (k.pid() < 0 || !k.opened())
    return failure(ErrorCode::NotReady, kWhere, "the camera is not open, call configure() first");
  if (!k.config.motor)
    return failure(ErrorCode::NotReady, kWhere, "the motor is not opened: kinect: {motor: true}");
  k.send_line(fmt::format("tilt {}", degrees));
  return {};
}

Result<> KinectCamera::set_infrared_brightness(int brightness) {
  constexpr auto kWhere = "kinect.brightness";
  if (brightness < 1 || brightness > 50)
    return failure(ErrorCode::LimitExceeded, kWhere, fmt::format("{}, expected 1 to 50", brightness));
  if (stream_->pid() < 0 || !stream_->opened())
    return failure(ErrorCode::NotReady, kWhere, "the camera is not open, call configure() first");
  stream_->send_line(fmt::format("brightness {}", brightness));
  return {};
}

KinectReport KinectCamera::report() const {
  const kinect::KinectStream& k = *stream_;
  KinectReport r = k.report;
  r.pid = k.pid();
  r.starts = k.watch().starts();
  r.kills = k.watch().kills();
  r.frames = k.health().accepted;
  r.missed = k.missed();
  r.broken += k.broken();
  r.error = k.error();
  r.serial = k.news().serial;
  r.constants = k.table.constants();
  r.infrared = k.news().infrared;
  r.motor = k.news().motor;
  r.last_words = k.news().refused.empty() ? k.news().last_words : k.news().refused;
  return r;
}

}  // namespace colift::hal
