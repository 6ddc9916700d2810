#include "hal/drivers/kinect/kinect_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <utility>

#include "hal/drivers/kinect/lost_packets.hpp"

namespace colift::hal::kinect {
namespace {

using namespace std::chrono_literals;

constexpr auto kLongestWait = 20ms;  // between two looks at the process

/// Against gravity, from the accelerometer: y is up, x right, z backwards on a level device. The sign of x
/// and z has not been tried on a device.
std::optional<Vec3> up_of(const FrameStamp& s) {
  if (s.has_accel == 0) return std::nullopt;
  const Vec3 a(s.accel[0], -s.accel[1], -s.accel[2]);
  const double g = a.norm() / kCountsPerG;
  if (!(g > 0.8 && g < 1.2)) return std::nullopt;  // shaken, or nonsense
  return a.normalized();
}

void sleep_for(Duration d) {
  const timespec t{0, std::clamp<long>(d.count(), 0, 999'999'999)};
  (void)::nanosleep(&t, nullptr);
}

}  // namespace

void KinectStream::start() {
  process.reset();
  news = {};
  times_.forget();
  before_.pixels.clear();
  device_at_ = infrared_at_ = Timestamp::min();
  auto made = FrameRing::make();
  if (!made) {
    report.error = made.error().text();
    return;
  }
  ring.emplace(std::move(*made));
  auto started = CaptureProcess::start(source->call, ring->fd());
  if (!started) {
    report.error = started.error().text();
    return;
  }
  process.emplace(std::move(*started));
  if (infrared) ask_for_infrared();
}

void KinectStream::ask_for_infrared() const {
  if (!process) return;
  process->send_line("infrared on");
  if (config.infrared_brightness > 0)
    process->send_line(fmt::format("brightness {}", config.infrared_brightness));
}

std::string KinectStream::words_of_end() const {
  if (news.end) return news.reason;
  if (!process) return report.error.empty() ? "the capture process is not there" : report.error;
  const std::string& how = process->ended();
  const std::string last =
      news.last_words.empty() ? "" : fmt::format("; its last words: {}", news.last_words);
  return fmt::format("the capture process ended with {}{}", how.empty() ? "no word" : how, last);
}

void KinectStream::look_after() {
  const bool exists = process && process->exists();
  if (process) process->listen(news);
  if (news.constants && !report.own_constants) {
    table = DepthTable(*news.constants);
    report.own_constants = true;
  }
  if (is_recording() && watch.running() && !exists && news.end == CaptureEnd::DeviceLost) {
    watch.rest();  // a recording does not come back by itself
    note_device("the recording is over");
    return;
  }
  CaptureMonitor::Sight sight;
  sight.exists = exists;
  if (ring) sight.heartbeat = ring->heartbeat(), sight.frames = ring->newest(Stream::Depth);
  if (!exists) {
    sight.ended = words_of_end();
    sight.no_device = news.end == CaptureEnd::NoDevice;
  }
  const bool ran = watch.running();
  switch (watch.look(sight, clock.now())) {
    case CaptureMonitor::Do::Nothing:
      break;
    case CaptureMonitor::Do::Start:
      start();
      break;
    case CaptureMonitor::Do::Kill:
      if (process) process->kill();
      break;
    case CaptureMonitor::Do::Abandon:
      if (process) process->abandon();
      break;
  }
  if (ran && !watch.running()) note_device(watch.why());
}

void KinectStream::note_device(const std::string& why) {
  report.error = why;
  last_error = why;
}

bool KinectStream::lost() const {
  return !watch.running() || seconds(clock.now() - frame_at) > config.silent_s;
}

std::string KinectStream::words_of_loss() const {
  if (!watch.running()) return report.error.empty() ? "the capture process is not there" : report.error;
  return fmt::format("no frame for {:.1f} s{}", seconds(clock.now() - frame_at),
                     report.error.empty() ? "" : fmt::format(" (before: {})", report.error));
}

void KinectStream::wait(Duration timeout) const {
  if (process)
    process->wait(std::min<Duration>(timeout, kLongestWait));
  else
    sleep_for(std::min<Duration>(timeout, kLongestWait));
}

Timestamp KinectStream::arrival(const FrameStamp& s) const {
  // the process's word, kept within reason
  const Duration age = std::clamp<Duration>(machine_.now() - Timestamp(s.arrived_ns), 0ns, 10s);
  return clock.now() - age;
}

Timestamp KinectStream::exposed(Timestamp measured) const {
  return measured -
         std::chrono::duration_cast<Duration>(std::chrono::duration<double>(config.latency_ms / 1e3));
}

void KinectStream::reject(std::string why) {
  ++rejected;
  last_error = std::move(why);
}

std::optional<DepthFrame> KinectStream::take(const std::function<void(const RawFrame&, Timestamp)>& on_raw) {
  if (!ring) return std::nullopt;
  std::swap(raw_, before_);
  const auto got = ring->read(Stream::Depth, raw_);
  if (!got || !*got) {
    std::swap(raw_, before_);
    if (!got) {
      ++report.broken;
      reject(got.error().detail);
    }
    return std::nullopt;
  }
  report.missed = ring->missed(Stream::Depth);
  const auto t = times_.note(raw_.stamp.ticks, arrival(raw_.stamp));
  if (t.device <= device_at_) {
    ++report.old;
    reject(fmt::format("a frame {:.1f} ms older than the one before", 1e3 * seconds(device_at_ - t.device)));
    return std::nullopt;
  }
  if (device_at_ != Timestamp::min()) {
    const double frames = static_cast<double>(raw_.stamp.number - before_.stamp.number);
    const double hz = frames / seconds(t.device - device_at_);
    report.rate_hz = report.rate_hz == 0.0 ? hz : 0.9 * report.rate_hz + 0.1 * hz;
  }
  device_at_ = t.device;
  report.late_ms = 1e3 * seconds(t.late);
  report.lost_packets += raw_.stamp.lost_packets;
  const bool consecutive =
      before_.pixels.size() == raw_.pixels.size() && raw_.stamp.number == before_.stamp.number + 1;
  if (raw_.stamp.lost_packets > 0 || (consecutive && stale_runs(raw_.pixels, before_.pixels) > 0)) {
    ++report.suspect;
    if (config.drop_suspect) {
      reject("a frame with lost USB packets");
      return std::nullopt;
    }
  }
  if (on_raw) on_raw(raw_, exposed(t.exposed));
  return convert(t);
}

DepthFrame KinectStream::convert(const DeviceClock::Times& t) {
  DepthFrame frame;
  frame.exposed_at = exposed(t.exposed);
  frame.intrinsics = intrinsics();
  table.convert(raw_.pixels, frame.depth_m);
  frame.up_C = up_of(raw_.stamp);
  const auto seen =
      std::count_if(frame.depth_m.begin(), frame.depth_m.end(), [](float z) { return z > 0.0f; });
  report.seen = static_cast<double>(seen) / static_cast<double>(kPixels);
  report.tilt_deg = raw_.stamp.has_accel != 0 ? std::optional(raw_.stamp.tilt_half_deg / 2.0) : std::nullopt;
  report.error.clear();
  ++report.frames;
  frame_at = clock.now();
  return frame;
}

std::optional<InfraredFrame> KinectStream::take_infrared() {
  if (!ring) return std::nullopt;
  const auto got = ring->read(Stream::Infrared, infrared_raw_);
  if (!got) {
    ++report.broken;
    reject(got.error().detail);
  }
  if (!got || !*got) return std::nullopt;
  InfraredFrame frame;
  // the same counter as the depth's; its own frames are not older than the counter's last wrap
  frame.exposed_at = exposed(arrival(infrared_raw_.stamp));
  if (frame.exposed_at <= infrared_at_) {
    ++report.old;
    return std::nullopt;
  }
  infrared_at_ = frame.exposed_at;
  frame.intrinsics = infrared_of(intrinsics());
  frame.width = kWidth;
  frame.height = kInfraredHeight;
  frame.brightness = infrared_raw_.pixels;
  for (std::uint16_t& b : frame.brightness) b = std::min(b, kMostInfrared);
  return frame;
}

Result<> KinectStream::first_frame() {
  const Timestamp deadline =
      clock.now() + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(config.open_s));
  watch.want();
  for (;;) {
    look_after();
    if (ring && watch.running() && ring->newest(Stream::Depth) > 0) break;
    const bool ended = !watch.running();
    if (ended || clock.now() >= deadline) {
      const std::string why = ended ? report.error : fmt::format("no frame within {:.1f} s", config.open_s);
      const bool gone = news.end == CaptureEnd::NoDevice || news.end == CaptureEnd::DeviceLost;
      last_error = why;
      watch.rest();
      process.reset();
      return failure(gone ? ErrorCode::LinkLost : ErrorCode::DeviceFault, "kinect.configure", why);
    }
    wait(kLongestWait);
  }
  frame_at = clock.now();
  report.error.clear();
  return {};
}

}  // namespace colift::hal::kinect
