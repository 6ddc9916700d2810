#include "hal/drivers/kinect/kinect_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/drivers/kinect/kinect_stream.hpp"

namespace colift::hal {
namespace {

using namespace std::chrono_literals;
using kinect::Stream;
using Health = DeviceHealth::State;

}  // namespace

struct KinectCamera::Impl : kinect::KinectStream {
  using KinectStream::KinectStream;
  bool opened = false, active = false;
};

KinectCamera::KinectCamera(KinectConfig config, const Clock& clock)
    : impl_(std::make_unique<Impl>(std::move(config), clock)) {}

KinectCamera::~KinectCamera() = default;

Result<> KinectCamera::configure() {
  Impl& k = *impl_;
  if (!k.source) {
    auto source = kinect::kinect_source(k.config);
    if (!source) return tl::unexpected(source.error());
    k.source = std::move(*source);
  }
  if (k.opened && !k.watch.resting()) {
    // it is being looked after already; nobody waits for it in the middle of a job
    k.look_after();
    if (!k.lost()) return {};
    const bool fresh = k.watch.running() && k.ring && k.ring->newest(Stream::Depth) > 0 &&
                       seconds(k.clock.now() - k.watch.frame_seen_at()) < k.config.silent_s;
    if (fresh) return {};
    return failure(ErrorCode::LinkLost, "kinect.configure", k.words_of_loss());
  }
  if (auto first = k.first_frame(); !first) return first;
  k.opened = true;
  return {};
}

Result<> KinectCamera::activate() {
  if (!impl_->opened)
    return failure(ErrorCode::NotReady, "kinect.activate", "the camera is not open, call configure() first");
  impl_->active = true;
  return {};
}

void KinectCamera::deactivate() noexcept {
  impl_->active = false;
}

Result<DepthFrame> KinectCamera::next_frame(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = "kinect.next_frame";
  Impl& k = *impl_;
  if (!k.active)
    return failure(ErrorCode::NotReady, kWhere, "the camera does not stream, call activate() first");
  const Timestamp deadline = k.clock.now() + std::max(timeout, 0ms);
  for (;;) {
    // before the process is judged: its last frames count, even when it is gone
    if (auto frame = k.take(on_raw)) return std::move(*frame);
    k.look_after();
    if (auto frame = k.take(on_raw)) return std::move(*frame);
    if (k.lost()) return failure(ErrorCode::LinkLost, kWhere, k.words_of_loss());
    const Timestamp now = k.clock.now();
    if (now >= deadline)
      return failure(ErrorCode::Timeout, kWhere, fmt::format("no frame within {} ms", timeout.count()));
    k.wait(deadline - now);
  }
}

Result<> KinectCamera::want_infrared(bool wanted) {
  Impl& k = *impl_;
  constexpr auto kWhere = "kinect.infrared";
  if (!k.opened)
    return failure(ErrorCode::NotReady, kWhere, "the camera is not open, call configure() first");
  k.look_after();
  if (wanted && !k.news.infrared)
    return failure(ErrorCode::DeviceFault, kWhere,
                   "there is no infrared here: a fakenect recording holds none");
  k.infrared = wanted;
  if (wanted)
    k.ask_for_infrared();
  else if (k.process)
    k.process->send_line("infrared off");
  return {};
}

Result<InfraredFrame> KinectCamera::next_infrared(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = "kinect.next_infrared";
  Impl& k = *impl_;
  if (!k.active || !k.infrared)
    return failure(ErrorCode::NotReady, kWhere, "no infrared was asked for, or the camera does not stream");
  const Timestamp deadline = k.clock.now() + std::max(timeout, 0ms);
  for (;;) {
    k.look_after();
    if (auto frame = k.take_infrared()) return std::move(*frame);
    if (!k.watch.running()) return failure(ErrorCode::LinkLost, kWhere, k.words_of_loss());
    const Timestamp now = k.clock.now();
    if (now >= deadline)
      return failure(
          ErrorCode::Timeout, kWhere,
          k.news.refused.empty() ? fmt::format("no image within {} ms", timeout.count()) : k.news.refused);
    k.wait(deadline - now);
  }
}

Result<> KinectCamera::tilt(double degrees) {
  constexpr auto kWhere = "kinect.tilt";
  Impl& k = *impl_;
  if (!(std::abs(degrees) <= kinect::kTilt_deg))
    return failure(
        ErrorCode::LimitExceeded, kWhere,
        fmt::format("{} degrees, the motor goes to {} to either side", degrees, kinect::kTilt_deg));
  if (!k.process || !k.opened)
    return failure(ErrorCode::NotReady, kWhere, "the camera is not open, call configure() first");
  if (!k.config.motor)
    return failure(ErrorCode::NotReady, kWhere, "the motor is not opened: kinect: {motor: true}");
  k.process->send_line(fmt::format("tilt {}", degrees));
  return {};
}

Result<> KinectCamera::set_infrared_brightness(int brightness) {
  constexpr auto kWhere = "kinect.brightness";
  if (brightness < 1 || brightness > 50)
    return failure(ErrorCode::LimitExceeded, kWhere, fmt::format("{}, expected 1 to 50", brightness));
  if (!impl_->process || !impl_->opened)
    return failure(ErrorCode::NotReady, kWhere, "the camera is not open, call configure() first");
  impl_->process->send_line(fmt::format("brightness {}", brightness));
  return {};
}

DeviceHealth KinectCamera::health() const {
  const Impl& k = *impl_;
  DeviceHealth h;
  h.accepted = k.report.frames;
  h.rejected = k.rejected;
  h.last_error = k.last_error;
  if (!k.opened)
    h.state = k.last_error.empty() ? Health::Absent : Health::Failed;
  else if (k.lost() && k.active)
    h.state = Health::Lost;
  else if (!k.active)
    h.state = Health::Opening;
  else
    h.state = seconds(k.clock.now() - k.frame_at) > 0.1 ? Health::Stalled : Health::Streaming;
  return h;
}

KinectReport KinectCamera::report() const {
  const Impl& k = *impl_;
  KinectReport r = k.report;
  r.pid = k.process ? k.process->pid() : -1;
  r.starts = k.watch.starts();
  r.kills = k.watch.kills();
  r.serial = k.news.serial;
  r.constants = k.table.constants();
  r.infrared = k.news.infrared;
  r.motor = k.news.motor;
  r.last_words = k.news.refused.empty() ? k.news.last_words : k.news.refused;
  return r;
}

}  // namespace colift::hal
