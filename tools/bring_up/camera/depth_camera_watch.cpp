#include "tools/bring_up/camera/depth_camera_watch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <thread>
#include <utility>

#include "hal/health_text.hpp"
#include "perception/noise_fit.hpp"
#include "tools/bring_up/bring_up.hpp"
#include "tools/bring_up/camera/camera_files.hpp"
#include "tools/bring_up/hal_camera_view.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/scenes/depth_file.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;

struct End {
  int code = kDone;
  std::string word = "done", reason;
};

std::string text_of(const hal::Openni2Report& r) {
  const auto& d = r.dropped;
  return fmt::format(
      "device     {}, serial {}; {}\n"
      "process    {}, started {} times, killed {} times\n"
      "dropped    {} twice, {} old, {} misdated, {} broken; {} never came, {} not asked for; clock set {} "
      "times\n",
      r.name.empty() ? "?" : r.name, r.serial.empty() ? "?" : r.serial, r.last_words, r.pid, r.starts,
      r.kills, d.duplicate, d.old, d.misdated, r.broken, d.skipped, r.missed, d.clock_set);
}

/// Frames until the time is over or somebody ends it.
class Watch {
 public:
  Watch(const CommonOptions& common, const HalCameraOptions& o, const WatchedCamera& watched,
        const hal::Clock& clock)
      : noise_wanted_(o.hal.verb == "noise"),
        camera_(watched.camera),
        report_(watched.report),
        clock_(clock),
        began_(clock.now()),
        screen_(progress_screen(common, o.hal, "info")) {
    view_.source = watched.source;
  }

  End run(double for_s) {
    screen_.line(fmt::format("{:8.1f} s  opens {} and waits for a frame", 0.0, view_.source));
    for (const auto step : {&hal::DepthCamera::configure, &hal::DepthCamera::activate})
      if (auto done = (camera_.*step)(); !done)
        return {done.error().code == hal::ErrorCode::BadConfig ? kBadInput : kDeviceFailed, "failed",
                done.error().text()};
    const hal::Timestamp begin = clock_.now(), end = begin + hal::duration_of(std::min(for_s, 1e6));
    bool lost = false;
    std::string why;
    while (clock_.now() < end) {
      if (InterruptGuard::asked())
        return {std::isfinite(for_s) ? kInterrupted : kDone, "interrupted", "asked to end"};
      auto frame = camera_.next_frame(50ms);
      if (frame) {
        if (lost) screen_.line(fmt::format("{:8.1f} s  frames again", at_s()));
        lost = false;
        take(std::move(*frame), begin);
      } else if (frame.error().code != hal::ErrorCode::Timeout) {
        why = frame.error().detail;
        if (!lost) screen_.line(fmt::format("{:8.1f} s  lost: {}", at_s(), why));
        lost = true;
        if (report_ && why.find("recording is over") != std::string::npos) return {kDone, "done", why};
        std::this_thread::sleep_for(20ms);
      }
      if (screen_.live())
        screen_.draw(screen(), at_s());
      else if (!lost)
        screen_.line_now_and_then(line(), at_s());
    }
    if (lost) return {kDeviceFailed, "failed", why};
    return {};
  }

  [[nodiscard]] std::string line() const {
    const hal::DeviceHealth h = camera_.health();
    return fmt::format("{:8.1f} s  {:.1f} Hz, {} frames, {} rejected, {:.0f} % seen, {:.2f} to {:.2f} m",
                       at_s(), rate_hz_, h.accepted, h.rejected, 1e2 * seen_, view_.near_m, view_.far_m);
  }

  [[nodiscard]] std::string screen() const {
    const hal::DeviceHealth h = camera_.health();
    std::string t = fmt::format("camera     {}, {}\n", view_.source, to_string(h.state));
    if (last_) {
      const auto& k = last_->intrinsics;
      t +=
          fmt::format("image      {} x {} pixels, focal lengths {:.1f}, {:.1f} px, centre ({:.1f}, {:.1f})\n",
                      k.width, k.height, k.fx, k.fy, k.cx, k.cy);
    }
    t += fmt::format("frames     {} at {:.1f} Hz, {} rejected; {:.1f} ms old when they come\n", h.accepted,
                     rate_hz_, h.rejected, 1e3 * age_s_);
    t += fmt::format("depth      {:.1f} % of the pixels: {:.2f} m, {:.2f} m in the middle, up to {:.2f} m\n",
                     1e2 * seen_, view_.near_m, view_.middle_m, view_.far_m);
    if (report_) t += text_of(report_());
    if (!h.last_error.empty()) t += fmt::format("last       {}\n", h.last_error);
    return t;
  }

  [[nodiscard]] std::string document(const std::string& verb, const End& end) const {
    using Json = nlohmann::ordered_json;
    const hal::DeviceHealth h = camera_.health();
    // before the first frame nothing of it is known
    const auto number = [&](double x) { return last_ && std::isfinite(x) ? Json(x) : Json(nullptr); };
    Json j = {{"schema", "colift.hal.camera/1"},
              {"verb", verb},
              {"end", end.word},
              {"because", end.reason},
              {"source", view_.source},
              {"state", to_string(h.state)},
              {"frames",
               {{"handed_out", h.accepted},
                {"rate_hz", number(rate_hz_)},
                {"rejected", h.rejected},
                {"late_ms", number(1e3 * age_s_)}}},
              {"seen", number(seen_)},
              {"depth_m", {number(view_.near_m), number(view_.middle_m), number(view_.far_m)}},
              {"last_error", h.last_error}};
    if (report_) {
      const hal::Openni2Report r = report_();
      const auto& d = r.dropped;
      j["name"] = r.name;
      j["serial"] = r.serial;
      j["process"] = {{"pid", r.pid}, {"starts", r.starts}, {"kills", r.kills}};
      j["dropped"] = {{"missed", r.missed},     {"duplicate", d.duplicate}, {"old", d.old},
                      {"misdated", d.misdated}, {"skipped", d.skipped},     {"clock_set", d.clock_set},
                      {"broken", r.broken}};
      j["library"] = r.last_words;
    }
    return j.dump(-1, ' ', false, Json::error_handler_t::replace);
  }

  [[nodiscard]] const std::optional<hal::DepthFrame>& last() const { return last_; }
  [[nodiscard]] hal::Result<perception::MeasuredNoise> noise() const { return noise_.result(); }
  [[nodiscard]] const CameraView& view() {
    view_.health = camera_.health();
    view_.report.seen = seen_;
    view_.report.rate_hz = rate_hz_;
    return view_;
  }

 private:
  void take(hal::DepthFrame frame, hal::Timestamp begin) {
    look_at_frame(frame, view_);
    const auto valid =
        std::count_if(frame.depth_m.begin(), frame.depth_m.end(), [](float z) { return z > 0.0f; });
    seen_ = static_cast<double>(valid) / static_cast<double>(std::max<std::size_t>(frame.depth_m.size(), 1));
    age_s_ = hal::seconds(clock_.now() - frame.exposed_at);
    const double s = hal::seconds(clock_.now() - begin);
    if (s > 0.0) rate_hz_ = static_cast<double>(camera_.health().accepted) / s;
    if (noise_wanted_) noise_.add(frame);
    last_ = std::move(frame);
  }
  [[nodiscard]] double at_s() const { return hal::seconds(clock_.now() - began_); }

  bool noise_wanted_;
  hal::DepthCamera& camera_;
  std::function<hal::Openni2Report()> report_;
  const hal::Clock& clock_;
  hal::Timestamp began_;
  LiveScreen screen_;
  CameraView view_;
  perception::NoiseFit noise_;
  std::optional<hal::DepthFrame> last_;
  double seen_ = 0.0, rate_hz_ = 0.0, age_s_ = 0.0;
};

}  // namespace

hal::Result<> check_depth_camera_request(const HalCameraOptions& o, bool openni2) {
  const auto refuse = [](const char* where, const char* why) {
    return hal::failure(hal::ErrorCode::BadInput, where, why);
  };
  if (o.hal.verb == "tilt") return refuse("tilt", "only a Kinect has a motor");
  if (o.hal.verb == "record" && !o.scene && !openni2)
    return refuse(
        "record",
        "records for fakenect, which plays a Kinect; expected record --scene FOLDER for the steps of "
        "a lift, info --depth FILE.png for one frame");
  if (o.infrared) return refuse("--infrared", "only a Kinect's infrared images are read");
  if (!o.source.empty() && !openni2)
    return refuse("--source", "is for a Kinect; expected v4l2: {device: ...} in the robot file");
  return {};
}

int watch_depth_camera(const CommonOptions& common, const HalCameraOptions& options,
                       const WatchedCamera& watched, const hal::Clock& clock, double for_s,
                       const perception::NoiseModel& configured) {
  const std::string where = fmt::format("hal camera {}", options.hal.verb);
  const InterruptGuard signals;
  Watch watch(common, options, watched, clock);
  const End end = watch.run(for_s);
  if (options.png && watch.last()) {
    if (auto written = write_camera_picture(*options.png, *watch.last(), watch.view()); !written)
      return report_error(where.c_str(), written.error());
    if (!common.quiet) std::fprintf(stderr, "picture: %s\n", options.png->c_str());
  }
  if (options.depth && watch.last()) {
    if (auto written = write_depth(*options.depth, *watch.last()); !written)
      return report_error(where.c_str(), written.error());
    if (!common.quiet)
      std::fprintf(stderr, "depth image: %s, camera.json beside it\n", options.depth->c_str());
  }
  std::optional<perception::MeasuredNoise> noise;
  if (options.hal.verb == "noise" && end.code == kDone) {
    const auto measured = watch.noise();
    if (const int code = say_noise(common, options.out, measured, configured); code != kDone) return code;
    noise = *measured;
  }
  if (common.json)
    std::puts(with_noise(watch.document(options.hal.verb, end), noise).c_str());
  else if (watch.last() && options.hal.verb != "noise")
    std::fputs(watch.screen().c_str(), stdout);
  std::fflush(stdout);
  if (end.code != kDone && end.code != kInterrupted)
    report_failure("camera", options.hal.verb, end.reason, fmt::format("next: {}\n", watched.advice));
  return end.code;
}

}  // namespace colift::tools
