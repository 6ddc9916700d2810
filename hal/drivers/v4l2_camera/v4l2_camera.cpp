#include "hal/drivers/v4l2_camera/v4l2_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "hal/drivers/v4l2_camera/stamp_gate.hpp"
#include "hal/drivers/v4l2_camera/video_stream.hpp"
#include "hal/drivers/v4l2_camera/video_words.hpp"

namespace colift::hal {
namespace {

using namespace std::chrono_literals;
using Health = DeviceHealth::State;

constexpr Duration kLook = 50ms;  // between two looks at whether the end was asked for
constexpr Duration kStalled = 100ms;
constexpr auto kLeave = 1s;  // for a call that does not come back
constexpr double kPauseGrowth = 1.5;

/// The calls, and which of them has not come back yet.
class WatchedCalls final : public VideoCalls {
 public:
  WatchedCalls(std::shared_ptr<VideoCalls> calls, std::atomic<const char*>& doing)
      : calls_(std::move(calls)), doing_(doing) {}

  int open(const std::string& path) override {
    return watched("open", [&] { return calls_->open(path); });
  }
  int close(int descriptor) override {
    return watched("close", [&] { return calls_->close(descriptor); });
  }
  int control(int descriptor, unsigned long request, void* argument) override {
    return watched(v4l2::name_of(request), [&] { return calls_->control(descriptor, request, argument); });
  }
  int map(int descriptor, std::size_t bytes, std::int64_t offset, const void*& to) override {
    return watched("mmap", [&] { return calls_->map(descriptor, bytes, offset, to); });
  }
  int unmap(const void* at, std::size_t bytes) override { return calls_->unmap(at, bytes); }
  int wait(int descriptor, Duration timeout) override { return calls_->wait(descriptor, timeout); }

 private:
  template <class Call>
  int watched(const char* name, const Call& call) {
    doing_ = name;
    const int done = call();
    doing_ = nullptr;
    return done;
  }

  std::shared_ptr<VideoCalls> calls_;
  std::atomic<const char*>& doing_;
};

}  // namespace

/// What the caller's thread and the device's have in common. The device's owns a share of it, so that it may
/// be left behind in a call.
struct V4l2Camera::Shared {
  const V4l2CameraConfig config;
  const v4l2::DepthModel model;
  const Clock& clock;  // not looked at any more once `ends` is set
  std::atomic<const char*> doing{nullptr};
  WatchedCalls calls;

  std::mutex mutex;
  std::condition_variable changed;
  bool runs = false, ends = false;
  std::optional<DepthFrame> newest;  // not handed out yet
  std::optional<Timestamp> good_at;  // when the last good one came
  std::optional<Error> loss;         // why there is no stream; none while it streams
  std::string last_error;
  std::uint64_t rejected = 0;

  Shared(V4l2CameraConfig c, const v4l2::DepthModel& m, std::shared_ptr<VideoCalls> k, const Clock& t)
      : config(std::move(c)), model(m), clock(t), calls(std::move(k), doing) {}

  bool asked_to_end() {
    const std::lock_guard lock(mutex);
    return ends;
  }

  void reject(std::string why) {
    const std::lock_guard lock(mutex);
    ++rejected;
    last_error = std::move(why);
  }

  void lost(Error why) {
    const std::lock_guard lock(mutex);
    last_error = why.detail;
    loss = std::move(why);
    changed.notify_all();
  }

  void take_over(DepthFrame frame) {
    const std::lock_guard lock(mutex);
    good_at = clock.now();
    newest = std::move(frame);
    loss.reset();
    changed.notify_all();
  }

  Result<DepthFrame> frame_of(const v4l2::VideoPicture& picture, std::size_t stride, v4l2::StampGate& gate) {
    const Timestamp now = clock.now();
    if (config.time == "kernel" && !picture.stamp)
      return failure(ErrorCode::BadReply, "v4l2.camera",
                     "its time stamps are not of the monotonic clock; time: arrival takes the time at which "
                     "an image comes");
    const Timestamp stamp = config.time == "kernel" ? *picture.stamp : now;
    const auto exposed = gate.pass(stamp - duration_of(1e-3 * config.latency_ms), now);
    if (!exposed) return tl::unexpected(exposed.error());
    auto depth = v4l2::depth_of({picture.bytes, stride}, model, {config.min_depth_m, config.max_depth_m});
    if (!depth) return tl::unexpected(depth.error());
    DepthFrame frame;
    frame.exposed_at = *exposed;
    frame.intrinsics = model.intrinsics;
    frame.depth_m = std::move(*depth);
    return frame;
  }

  /// Until it is lost, or asked to end. Whether there was a good frame.
  bool stream(v4l2::VideoStream& from, v4l2::StampGate& gate) {
    Timestamp good = clock.now();
    bool any = false;
    while (!asked_to_end()) {
      std::vector<std::string> dropped;
      const auto picture = from.newest(kLook, dropped);
      if (asked_to_end()) break;
      for (std::string& why : dropped) reject(std::move(why));
      if (picture) {
        if (auto frame = frame_of(*picture, from.stride(), gate)) {
          good = clock.now();
          any = true;
          take_over(std::move(*frame));
          continue;
        } else
          reject(frame.error().detail);
      } else if (picture.error().code != ErrorCode::Timeout && picture.error().code != ErrorCode::BadReply) {
        lost(picture.error());
        break;
      }
      if (seconds(clock.now() - good) <= config.frames_s) continue;
      std::string why;
      {
        const std::lock_guard lock(mutex);
        why = last_error;
      }
      lost({ErrorCode::LinkLost, "v4l2.camera",
            fmt::format("{} is there, but no good frame came for {} s{}{}; it is opened anew", config.device,
                        config.frames_s, why.empty() ? "" : ": ", why)});
      break;
    }
    return any;
  }

  void pause(double s) {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::duration<double>(s), [&] { return ends; });
  }

  void run() {
    v4l2::StampGate gate(config.max_age_s, config.future_s);
    double pause_s = config.first_pause_s;
    while (!asked_to_end()) {
      const CameraIntrinsics& k = model.intrinsics;
      auto opened = v4l2::VideoStream::open(calls, config, k.width, k.height);
      if (asked_to_end()) break;
      if (!opened)
        lost(opened.error());
      else if (stream(**opened, gate))
        pause_s = config.first_pause_s;
      if (opened) opened->reset();
      if (asked_to_end()) break;
      pause(pause_s);
      pause_s = std::min(kPauseGrowth * pause_s, std::max(config.max_pause_s, config.first_pause_s));
    }
    const std::lock_guard lock(mutex);
    runs = false;
    changed.notify_all();
  }
};

V4l2Camera::V4l2Camera(V4l2CameraConfig config, const v4l2::DepthModel& model,
                       std::shared_ptr<VideoCalls> calls, const Clock& clock)
    : shared_(std::make_shared<Shared>(std::move(config), model, std::move(calls), clock)) {}

V4l2Camera::~V4l2Camera() {
  stop();
}

void V4l2Camera::start() {
  Shared& s = *shared_;
  const std::lock_guard lock(s.mutex);
  if (s.runs) return;
  s.runs = true;
  s.ends = false;
  s.loss.reset();
  s.newest.reset();
  s.good_at.reset();
  // it owns its share of what it works on, and says itself that it has ended
  std::thread([shared = shared_] { shared->run(); }).detach();
}

void V4l2Camera::stop() {
  Shared& s = *shared_;
  std::unique_lock lock(s.mutex);
  s.ends = true;
  s.changed.notify_all();
  s.changed.wait_for(lock, kLeave, [&] { return !s.runs; });
}

bool V4l2Camera::silent() const {
  const Timestamp last = std::max(shared_->good_at.value_or(since_), since_);
  return seconds(shared_->clock.now() - last) > shared_->config.silent_s;
}

std::string V4l2Camera::words_of_loss() const {
  const Shared& s = *shared_;
  const double silent_s = seconds(s.clock.now() - std::max(s.good_at.value_or(since_), since_));
  if (const char* const call = s.doing)
    return fmt::format("{} has not come back from {}; no frame for {:.1f} s", s.config.device, call,
                       silent_s);
  if (s.loss) return s.loss->detail;
  return fmt::format("no good frame of {} for {:.1f} s{}{}", s.config.device, silent_s,
                     s.last_error.empty() ? "" : ": ", s.last_error);
}

Result<> V4l2Camera::configure() {
  constexpr auto kWhere = "v4l2.configure";
  Shared& s = *shared_;
  if (opened_) {
    // frames come again by themselves; nobody waits for them in the middle of a job
    const std::lock_guard lock(s.mutex);
    if (!s.loss && !silent()) return {};
    return failure(ErrorCode::LinkLost, kWhere, words_of_loss());
  }
  if (auto ok = v4l2::check(s.model); !ok) return ok;
  {
    const std::lock_guard lock(s.mutex);
    since_ = s.clock.now();
    if (s.runs)
      return failure(ErrorCode::LinkLost, kWhere, "the call before has not ended: " + words_of_loss());
  }
  start();
  Error why{ErrorCode::DeviceFault, kWhere, ""};
  {
    std::unique_lock lock(s.mutex);
    const Timestamp end = since_ + duration_of(s.config.open_s);
    while (!s.good_at && !s.loss && s.clock.now() < end) s.changed.wait_for(lock, kLook);
    if (s.good_at) {
      opened_ = true;
      s.last_error.clear();
      s.rejected = 0;
      return {};
    }
    if (s.loss)
      why = *s.loss;
    else
      why.detail = words_of_loss();
  }
  stop();
  return tl::unexpected(why);
}

Result<> V4l2Camera::activate() {
  if (!opened_)
    return failure(ErrorCode::NotReady, "v4l2.activate", "the camera is not open, call configure() first");
  const std::lock_guard lock(shared_->mutex);
  if (!active_) {
    shared_->newest.reset();
    since_ = shared_->clock.now();
  }
  active_ = true;
  return {};
}

void V4l2Camera::deactivate() noexcept {
  const std::lock_guard lock(shared_->mutex);
  active_ = false;
}

Result<DepthFrame> V4l2Camera::next_frame(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = "v4l2.next_frame";
  Shared& s = *shared_;
  if (!active_)
    return failure(ErrorCode::NotReady, kWhere, "the camera does not stream, call activate() first");
  const Timestamp deadline = s.clock.now() + std::max(timeout, 0ms);
  std::unique_lock lock(s.mutex);
  for (;;) {
    if (s.newest) {
      DepthFrame frame = std::move(*s.newest);
      s.newest.reset();
      ++accepted_;
      return frame;
    }
    if (s.loss || silent()) return failure(ErrorCode::LinkLost, kWhere, words_of_loss());
    const Timestamp now = s.clock.now();
    if (now >= deadline)
      return failure(ErrorCode::Timeout, kWhere, fmt::format("no frame within {} ms", timeout.count()));
    s.changed.wait_for(lock, std::min(deadline - now, kLook));
  }
}

DeviceHealth V4l2Camera::health() const {
  Shared& s = *shared_;
  const std::lock_guard lock(s.mutex);
  DeviceHealth h;
  h.accepted = accepted_;
  h.rejected = s.rejected;
  h.last_error = s.last_error;
  if (!opened_)
    h.state = s.last_error.empty() ? Health::Absent : Health::Failed;
  else if (!active_)
    h.state = Health::Opening;
  else if (s.loss || silent())
    h.state = Health::Lost;
  else
    h.state = s.clock.now() - std::max(s.good_at.value_or(since_), since_) > kStalled ? Health::Stalled
                                                                                      : Health::Streaming;
  if (h.state == Health::Lost) h.last_error = words_of_loss();
  return h;
}

}  // namespace colift::hal
