#include "hal/drivers/kinect/kinect_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "hal/drivers/kinect/capture_link/capture_watch.hpp"
#include "hal/drivers/kinect/device_clock.hpp"
#include "hal/drivers/kinect/kinect_source.hpp"
#include "hal/drivers/kinect/lost_packets.hpp"

namespace colift::hal {

namespace {

using namespace std::chrono_literals;
using kinect::CaptureEnd;
using kinect::CaptureWatch;
using kinect::KinectSource;
using kinect::RawFrame;
using kinect::Stream;
using Health = DeviceHealth::State;

constexpr auto kLongestWait = 20ms;  // between two looks at the process

/// Against gravity, from the accelerometer: y is up, x right, z backwards on a level device. The sign of x
/// and z has not been tried on a device.
std::optional<Vec3> up_of(const kinect::FrameStamp& s) {
  if (s.has_accel == 0) return std::nullopt;
  const Vec3 a(s.accel[0], -s.accel[1], -s.accel[2]);
  const double g = a.norm() / kinect::kCountsPerG;
  if (!(g > 0.8 && g < 1.2)) return std::nullopt;  // shaken, or nonsense
  return a.normalized();
}

}  // namespace

struct KinectCamera::Impl {
  Impl(KinectConfig c, const Clock& k) : config(std::move(c)), clock(k), watch(config) {}

  KinectConfig config;
  const Clock& clock;
  SteadyClock machine;  // that of the capture process
  std::optional<KinectSource> source;
  CaptureWatch watch;
  std::optional<kinect::FrameRing> ring;
  std::optional<kinect::CaptureProcess> process;
  kinect::CaptureNews news;
  kinect::DepthTable table;
  kinect::DeviceClock times;
  RawFrame raw, before, infrared_raw;
  bool opened = false, active = false, infrared = false, over = false;
  Timestamp frame_at{0}, device_at{Timestamp::min()}, infrared_at{Timestamp::min()};
  std::uint64_t rejected = 0;
  KinectReport report;
  std::string last_error;

  [[nodiscard]] bool is_recording() const { return source && source->kind == KinectSource::Kind::Fakenect; }

  // ---- the process

  void start() {
    process.reset();
    news = {};
    times.forget();
    before.pixels.clear();
    device_at = infrared_at = Timestamp::min();
    over = false;
    auto made = kinect::FrameRing::make();
    if (!made) {
      report.trouble = made.error().text();
      return;
    }
    ring.emplace(std::move(*made));
    auto started = kinect::CaptureProcess::start(source->call, ring->fd());
    if (!started) {
      report.trouble = started.error().text();
      return;
    }
    process.emplace(std::move(*started));
    if (infrared) ask_for_infrared();
  }

  void ask_for_infrared() const {
    if (!process) return;
    process->tell("infrared on");
    if (config.infrared_brightness > 0)
      process->tell(fmt::format("brightness {}", config.infrared_brightness));
  }

  /// What went wrong with it, in one sentence.
  [[nodiscard]] std::string words_of_end() const {
    if (news.end) return news.because;
    if (!process) return report.trouble.empty() ? "the capture process is not there" : report.trouble;
    const std::string& how = process->ended();
    const std::string last =
        news.last_words.empty() ? "" : fmt::format("; its last words: {}", news.last_words);
    return fmt::format("the capture process ended with {}{}", how.empty() ? "no word" : how, last);
  }

  /// Everything that is due: its words, its deadlines.
  void look_after() {
    const bool exists = process && process->exists();
    if (process) process->listen(news);
    if (news.constants && !report.own_constants) {
      table = kinect::DepthTable(*news.constants);
      report.own_constants = true;
    }
    if (is_recording() && watch.running() && !exists && news.end == CaptureEnd::DeviceLost) {
      over = true;  // a recording does not come back by itself
      watch.rest();
      lose("the recording is over");
      return;
    }
    CaptureWatch::Sight sight;
    sight.exists = exists;
    if (ring) sight.heartbeat = ring->heartbeat(), sight.frames = ring->newest(Stream::Depth);
    if (!exists) {
      sight.ended = words_of_end();
      sight.no_device = news.end == CaptureEnd::NoDevice;
    }
    const bool ran = watch.running();
    switch (watch.look(sight, clock.now())) {
      case CaptureWatch::Do::Nothing:
        break;
      case CaptureWatch::Do::Start:
        start();
        break;
      case CaptureWatch::Do::Kill:
        if (process) process->kill();
        break;
      case CaptureWatch::Do::Abandon:
        if (process) process->abandon();
        break;
    }
    if (ran && !watch.running()) lose(watch.why());
  }

  void lose(const std::string& why) {
    report.trouble = why;
    last_error = why;
  }

  [[nodiscard]] bool silent() const { return seconds(clock.now() - frame_at) > config.silent_s; }

  [[nodiscard]] bool lost() const { return !watch.running() || silent(); }

  [[nodiscard]] std::string words_of_loss() const {
    if (!watch.running()) return report.trouble.empty() ? "the capture process is not there" : report.trouble;
    return fmt::format("no frame for {:.1f} s{}", seconds(clock.now() - frame_at),
                       report.trouble.empty() ? "" : fmt::format(" (before: {})", report.trouble));
  }

  void wait(Duration patience) const {
    if (process)
      process->wait(std::min<Duration>(patience, kLongestWait));
    else
      kinect_sleep(std::min<Duration>(patience, kLongestWait));
  }
  static void kinect_sleep(Duration d);

  // ---- frames

  [[nodiscard]] Timestamp arrival(const kinect::FrameStamp& s) const {
    // the process's word, kept within reason
    const Duration age = std::clamp<Duration>(machine.now() - Timestamp(s.arrived_ns), 0ns, 10s);
    return clock.now() - age;
  }

  [[nodiscard]] Timestamp exposed(const kinect::DeviceClock::Times& t) const {
    return t.exposed -
           std::chrono::duration_cast<Duration>(std::chrono::duration<double>(config.latency_ms / 1e3));
  }

  void reject(std::string why) {
    ++rejected;
    last_error = std::move(why);
  }

  /// A new frame of the ring, if there is one that is good.
  std::optional<DepthFrame> take(const std::function<void(const RawFrame&, Timestamp)>& on_raw) {
    if (!ring) return std::nullopt;
    std::swap(raw, before);
    const auto got = ring->read(Stream::Depth, raw);
    if (!got || !*got) {
      std::swap(raw, before);
      if (!got) {
        ++report.broken;
        reject(got.error().detail);
      }
      return std::nullopt;
    }
    report.missed = ring->missed(Stream::Depth);
    const auto t = times.note(raw.stamp.ticks, arrival(raw.stamp));
    if (t.device <= device_at) {
      ++report.old;
      reject(fmt::format("a frame {:.1f} ms older than the one before", 1e3 * seconds(device_at - t.device)));
      return std::nullopt;
    }
    if (device_at != Timestamp::min()) {
      const double frames = static_cast<double>(raw.stamp.number - before.stamp.number);
      const double hz = frames / seconds(t.device - device_at);
      report.rate_hz = report.rate_hz == 0.0 ? hz : 0.9 * report.rate_hz + 0.1 * hz;
    }
    device_at = t.device;
    report.late_ms = 1e3 * seconds(t.late);
    report.lost_packets += raw.stamp.lost_packets;
    const bool consecutive =
        before.pixels.size() == raw.pixels.size() && raw.stamp.number == before.stamp.number + 1;
    if (raw.stamp.lost_packets > 0 || (consecutive && kinect::stale_runs(raw.pixels, before.pixels) > 0)) {
      ++report.suspect;
      if (config.drop_suspect) {
        reject("a frame with lost USB packets");
        return std::nullopt;
      }
    }
    if (on_raw) on_raw(raw, exposed(t));
    return convert(t);
  }

  DepthFrame convert(const kinect::DeviceClock::Times& t) {
    DepthFrame frame;
    frame.exposed_at = exposed(t);
    frame.intrinsics = intrinsics();
    table.convert(raw.pixels, frame.depth_m);
    frame.up_C = up_of(raw.stamp);
    const auto seen =
        std::count_if(frame.depth_m.begin(), frame.depth_m.end(), [](float z) { return z > 0.0f; });
    report.seen = static_cast<double>(seen) / static_cast<double>(kinect::kPixels);
    report.tilt_deg = raw.stamp.has_accel != 0 ? std::optional(raw.stamp.tilt_half_deg / 2.0) : std::nullopt;
    report.trouble.clear();
    ++report.frames;
    frame_at = clock.now();
    return frame;
  }

  [[nodiscard]] CameraIntrinsics intrinsics() const {
    return {kinect::kWidth, kinect::kHeight, config.fx, config.fy, config.cx, config.cy};
  }

  Result<> first_frame() {
    const Timestamp deadline =
        clock.now() + std::chrono::duration_cast<Duration>(std::chrono::duration<double>(config.open_s));
    watch.want();
    for (;;) {
      look_after();
      if (ring && watch.running() && ring->newest(Stream::Depth) > 0) break;
      const bool ended = !watch.running();
      if (ended || clock.now() >= deadline) {
        const std::string why =
            ended ? report.trouble : fmt::format("no frame within {:.1f} s", config.open_s);
        const bool gone = news.end == CaptureEnd::NoDevice || news.end == CaptureEnd::DeviceLost;
        last_error = why;
        watch.rest();
        process.reset();
        return failure(gone ? ErrorCode::LinkLost : ErrorCode::DeviceFault, "kinect.configure", why);
      }
      wait(kLongestWait);
    }
    frame_at = clock.now();
    report.trouble.clear();
    return {};
  }
};

void KinectCamera::Impl::kinect_sleep(Duration d) {
  const timespec t{0, std::clamp<long>(d.count(), 0, 999'999'999)};
  (void)::nanosleep(&t, nullptr);
}

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

Result<DepthFrame> KinectCamera::next_frame(std::chrono::milliseconds patience) {
  constexpr auto kWhere = "kinect.next_frame";
  Impl& k = *impl_;
  if (!k.active)
    return failure(ErrorCode::NotReady, kWhere, "the camera does not stream, call activate() first");
  const Timestamp deadline = k.clock.now() + std::max(patience, 0ms);
  for (;;) {
    // before the process is judged: its last frames count, even when it is gone
    if (auto frame = k.take(on_raw)) return std::move(*frame);
    k.look_after();
    if (auto frame = k.take(on_raw)) return std::move(*frame);
    if (k.lost()) return failure(ErrorCode::LinkLost, kWhere, k.words_of_loss());
    const Timestamp now = k.clock.now();
    if (now >= deadline)
      return failure(ErrorCode::Timeout, kWhere, fmt::format("no frame within {} ms", patience.count()));
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
    k.process->tell("infrared off");
  return {};
}

Result<InfraredFrame> KinectCamera::next_infrared(std::chrono::milliseconds patience) {
  constexpr auto kWhere = "kinect.next_infrared";
  Impl& k = *impl_;
  if (!k.active || !k.infrared)
    return failure(ErrorCode::NotReady, kWhere, "no infrared was asked for, or the camera does not stream");
  const Timestamp deadline = k.clock.now() + std::max(patience, 0ms);
  for (;;) {
    k.look_after();
    if (k.ring) {
      const auto got = k.ring->read(Stream::Infrared, k.infrared_raw);
      if (!got) {
        ++k.report.broken;
        k.reject(got.error().detail);
      } else if (*got) {
        InfraredFrame frame;
        const kinect::FrameStamp& s = k.infrared_raw.stamp;
        // the same counter as the depth's; its own frames are not older than the counter's last wrap
        frame.exposed_at = k.arrival(s) - std::chrono::duration_cast<Duration>(
                                              std::chrono::duration<double>(k.config.latency_ms / 1e3));
        frame.intrinsics = k.intrinsics();
        frame.intrinsics.height = kinect::kInfraredHeight;
        frame.intrinsics.cx += kinect::kInfraredOffsetU;
        frame.intrinsics.cy += kinect::kInfraredOffsetV;
        frame.width = kinect::kWidth;
        frame.height = kinect::kInfraredHeight;
        frame.brightness = k.infrared_raw.pixels;
        for (std::uint16_t& b : frame.brightness) b = std::min(b, kinect::kMostInfrared);
        if (frame.exposed_at > k.infrared_at) {
          k.infrared_at = frame.exposed_at;
          return frame;
        }
        ++k.report.old;
      }
    }
    if (!k.watch.running()) return failure(ErrorCode::LinkLost, kWhere, k.words_of_loss());
    const Timestamp now = k.clock.now();
    if (now >= deadline)
      return failure(
          ErrorCode::Timeout, kWhere,
          k.news.refused.empty() ? fmt::format("no image within {} ms", patience.count()) : k.news.refused);
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
  k.process->tell(fmt::format("tilt {}", degrees));
  return {};
}

Result<> KinectCamera::set_infrared_brightness(int brightness) {
  constexpr auto kWhere = "kinect.brightness";
  if (brightness < 1 || brightness > 50)
    return failure(ErrorCode::LimitExceeded, kWhere, fmt::format("{}, expected 1 to 50", brightness));
  if (!impl_->process || !impl_->opened)
    return failure(ErrorCode::NotReady, kWhere, "the camera is not open, call configure() first");
  impl_->process->tell(fmt::format("brightness {}", brightness));
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
