#include "tools/bring_up/cmd_hal_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>
#include <vector>

#include "hal/drivers/kinect/fakenect_writer.hpp"
#include "hal/drivers/kinect/kinect_camera.hpp"
#include "perception/calibration/grey_png.hpp"
#include "perception/noise_fit.hpp"
#include "tools/bring_up/bring_up.hpp"
#include "tools/bring_up/camera/camera_files.hpp"
#include "tools/bring_up/camera/depth_camera_watch.hpp"
#include "tools/bring_up/camera/openni2_command.hpp"
#include "tools/bring_up/camera/record_scene.hpp"
#include "tools/bring_up/hal_camera_view.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/video_rig.hpp"
#include "tools/scenes/depth_file.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;

/// The file's video device; nothing when its camera is another one.
std::optional<hal::V4l2CameraConfig> video_device(const HalCameraOptions& o) {
  if (!o.hal.robot) return std::nullopt;
  const auto file = read_robot_file(o.hal.robot);
  if (!file || file->camera != "v4l2") return std::nullopt;
  return file->v4l2;
}

hal::Result<hal::KinectConfig> load_kinect(const HalCameraOptions& o) {
  const auto file = read_wired(o.hal, kWiredCamera);
  if (!file) return tl::unexpected(file.error());
  hal::KinectConfig kinect = file->kinect;
  if (!o.source.empty()) kinect.source = o.source;
  kinect.motor = kinect.motor || o.hal.verb == "tilt";
  return kinect;
}

hal::Result<double> time_of(const HalCameraOptions& o) {
  if (auto done = check_time(o.hal); !done) return tl::unexpected(done.error());
  if (o.hal.verb == "tilt" && !(std::abs(o.tilt_deg) <= 31.0))
    return hal::failure(hal::ErrorCode::BadInput, "DEG",
                        fmt::format("a tilt of {}, expected -31 to 31 degrees", o.tilt_deg));
  if (o.hal.verb == "tilt" && !o.hal.yes)
    return hal::failure(hal::ErrorCode::BadInput, "tilt",
                        "it moves the camera, and whatever was calibrated is wrong then: say --yes");
  if (o.hal.for_s) return *o.hal.for_s;
  if (o.hal.verb == "info") return 1.5;
  if (o.hal.verb == "tilt") return 4.0;
  if (o.hal.verb == "noise") return 3.0;
  if (o.hal.verb == "watch" && (o.png || o.depth || o.infrared)) return 1.0;
  return std::numeric_limits<double>::infinity();
}

struct End {
  int code = kDone;
  std::string word = "done", reason;
};

/// Frames until the time is over, somebody ends it, or the recording does.
class Session {
 public:
  Session(const CommonOptions& common, const HalCameraOptions& o, const hal::KinectConfig& kinect,
          double for_s)
      : o_(o), for_s_(for_s), camera_(kinect, clock_), screen_(progress_screen(common, o.hal, "info")) {
    view_.source = kinect.source;
  }

  End run() {
    began_ = clock_.now();
    screen_.line(fmt::format("{:8.1f} s  starts the capture process and waits for a frame", 0.0));
    if (auto open = camera_.configure(); !open) return failed(open.error());
    if (auto active = camera_.activate(); !active) return failed(active.error());
    if (o_.infrared)
      if (auto done = camera_.want_infrared(true); !done) return failed(done.error());
    if (o_.hal.verb == "record") {
      auto writer = hal::kinect::FakenectWriter::open(o_.folder);
      if (!writer) return {kBadInput, "bad-request", writer.error().text()};
      writer_.emplace(std::move(*writer));
      camera_.on_raw([this](const hal::capture::RawFrame& raw, hal::Timestamp at) {
        if (!disk_) return;
        disk_ = writer_->write(raw, at);
      });
    }
    if (o_.hal.verb == "tilt")
      if (auto done = camera_.tilt(o_.tilt_deg); !done) return failed(done.error());
    return loop();
  }

  [[nodiscard]] const CameraView& view() {
    view_.health = camera_.health();
    view_.report = camera_.report();
    view_.at_s = hal::seconds(clock_.now() - began_);
    return view_;
  }
  [[nodiscard]] const std::optional<hal::DepthFrame>& last() const { return last_; }
  [[nodiscard]] const std::optional<hal::InfraredFrame>& infrared() const { return infrared_; }
  [[nodiscard]] hal::Result<perception::MeasuredNoise> noise() const { return noise_.result(); }
  [[nodiscard]] std::string recorded() const {
    return writer_ ? fmt::format("{} frames, {:.1f} MB in {}", writer_->frames(),
                                 static_cast<double>(writer_->bytes()) / 1e6, o_.folder.string())
                   : "";
  }

 private:
  End failed(const hal::Error& error) {
    code_ = error.code;
    return {error.code == hal::ErrorCode::BadConfig ? kBadInput : kDeviceFailed, "failed", error.text()};
  }

  End loop() {
    const hal::Timestamp end = clock_.now() + std::chrono::duration_cast<hal::Duration>(
                                                  std::chrono::duration<double>(std::min(for_s_, 1e6)));
    bool lost = false;
    std::string why;
    while (clock_.now() < end) {
      if (InterruptGuard::asked())
        return {std::isfinite(for_s_) ? kInterrupted : kDone, "interrupted", "asked to end"};
      auto frame = camera_.next_frame(50ms);
      if (!disk_) return {kBadInput, "failed", disk_.error().text()};
      if (o_.infrared)
        if (auto image = camera_.next_infrared(0ms)) infrared_ = std::move(*image);
      if (frame) {
        if (lost) screen_.line(fmt::format("{:8.1f} s  frames again", view().at_s));
        lost = false;
        look_at_frame(*frame, view_);
        if (o_.hal.verb == "noise") noise_.add(*frame);
        last_ = std::move(*frame);
      } else if (frame.error().code == hal::ErrorCode::LinkLost) {
        why = frame.error().detail;
        if (!lost) screen_.line(fmt::format("{:8.1f} s  lost: {}", view().at_s, why));
        lost = true;
        if (view_.source.starts_with("fakenect") && why.find("over") != std::string::npos)
          return {kDone, "done", why};
        std::this_thread::sleep_for(20ms);
      }
      if (screen_.live())
        screen_.draw(camera_screen(view()), view_.at_s);
      else if (!lost)
        screen_.line_now_and_then(camera_line(view()), view().at_s);
    }
    if (lost) return {kDeviceFailed, "failed", why};
    return {};
  }

  const HalCameraOptions& o_;
  double for_s_;
  hal::SteadyClock clock_;
  hal::KinectCamera camera_;
  LiveScreen screen_;
  CameraView view_;
  hal::Timestamp began_{0};
  std::optional<hal::kinect::FakenectWriter> writer_;
  hal::Result<> disk_;
  perception::NoiseFit noise_;
  std::optional<hal::DepthFrame> last_;
  std::optional<hal::InfraredFrame> infrared_;
  hal::ErrorCode code_ = hal::ErrorCode::LinkLost;

 public:
  [[nodiscard]] hal::ErrorCode code() const { return code_; }
};

/// Ten bits, as bright as the file can show them.
hal::Result<> write_infrared(const std::filesystem::path& png, const hal::InfraredFrame& frame) {
  std::vector<std::uint16_t> bright = frame.brightness;
  for (std::uint16_t& b : bright) b = static_cast<std::uint16_t>(64U * std::min<unsigned>(b, 1023U));
  return perception::write_grey_png(png, frame.width, frame.height, bright);
}

/// A depth camera that is no Kinect: what all of them need before they are opened; then `carry_out`.
template <class Do>
int other_camera(const CommonOptions& common, const HalCameraOptions& o, const std::string& where,
                 bool openni2, const Do& carry_out) {
  if (auto ok = check_depth_camera_request(o, openni2); !ok) return report_error(where.c_str(), ok.error());
  const auto for_s = time_of(o);
  if (!for_s) return report_error(where.c_str(), for_s.error());
  const auto resolved = config_of(common, control::Command::Hal);
  if (!resolved) return report_error(where.c_str(), resolved.error());
  show_warnings(where.c_str(), common, *resolved);
  return carry_out(*for_s, resolved->config.noise);
}

int watch_video(const CommonOptions& common, const HalCameraOptions& o, const hal::V4l2CameraConfig& config,
                const std::string& where, double for_s, const perception::NoiseModel& configured) {
  const hal::SteadyClock clock;
  auto camera = make_video_camera(config, clock);
  if (!camera) return report_error(where.c_str(), camera.error());
  const std::string source = "v4l2 " + config.device;
  const std::string advice = fmt::format(
      "v4l2-ctl --list-devices names the devices, v4l2-ctl -d {} "
      "--list-formats-ext what this one gives",
      config.device);
  if (o.scene) return cmd_record_scene(common, o, source, advice, **camera, clock);
  return watch_depth_camera(common, o, {**camera, source, advice, {}}, clock, for_s, configured);
}

}  // namespace

int cmd_hal_camera(const CommonOptions& common, const HalCameraOptions& options) {
  const std::string where = fmt::format("hal camera {}", options.hal.verb);
  if (const auto openni2 = openni2_of(options))
    return other_camera(common, options, where, true, [&](double for_s, const perception::NoiseModel& noise) {
      return openni2_command(common, options, *openni2, for_s, noise);
    });
  if (const auto video = video_device(options))
    return other_camera(common, options, where, false,
                        [&](double for_s, const perception::NoiseModel& noise) {
                          return watch_video(common, options, *video, where, for_s, noise);
                        });
  const auto kinect = load_kinect(options);
  if (!kinect) return report_error(where.c_str(), kinect.error());
  const auto for_s = time_of(options);
  if (!for_s) return report_error(where.c_str(), for_s.error());
  // the camera alone needs nothing of it, but what is wrong in it is said
  const auto resolved = config_of(common, control::Command::Hal);
  if (!resolved) return report_error(where.c_str(), resolved.error());
  show_warnings(where.c_str(), common, *resolved);

  if (options.scene) {
    const hal::SteadyClock clock;
    hal::KinectCamera camera(*kinect, clock);
    return cmd_record_scene(common, options, "kinect " + kinect->source,
                            camera_advice(hal::ErrorCode::LinkLost, kinect->source), camera, clock);
  }
  const InterruptGuard signals;
  Session session(common, options, *kinect, *for_s);
  End end = session.run();
  const CameraView& view = session.view();
  if (options.png && session.last()) {
    if (auto written = write_camera_picture(*options.png, *session.last(), view); !written)
      return report_error(where.c_str(), written.error());
    if (!common.quiet) std::fprintf(stderr, "picture: %s\n", options.png->c_str());
  }
  if (options.infrared && session.infrared()) {
    if (auto written = write_infrared(*options.infrared, *session.infrared()); !written)
      return report_error(where.c_str(), written.error());
    if (!common.quiet) std::fprintf(stderr, "infrared image: %s\n", options.infrared->c_str());
  }
  if (options.depth && session.last()) {
    if (auto written = write_depth(*options.depth, *session.last()); !written)
      return report_error(where.c_str(), written.error());
    if (!common.quiet)
      std::fprintf(stderr, "depth image: %s, camera.json beside it\n", options.depth->c_str());
  }
  std::optional<perception::MeasuredNoise> noise;
  if (options.hal.verb == "noise" && end.code == kDone) {
    const auto measured = session.noise();
    if (const int code = say_noise(common, options.out, measured, resolved->config.noise); code != kDone)
      return code;
    noise = *measured;
  }
  if (common.json)
    std::puts(with_noise(camera_document(options.hal.verb, view, end.word, end.reason), noise).c_str());
  else if (session.last() && options.hal.verb != "noise")
    std::fputs(camera_screen(view).c_str(), stdout);
  if (!session.recorded().empty() && !common.json) std::printf("recorded   %s\n", session.recorded().c_str());
  std::fflush(stdout);
  if (end.code != kDone && end.code != kInterrupted)
    report_failure(
        "camera", options.hal.verb, end.reason,
        end.code == kDeviceFailed || !session.last()
            ? std::optional(fmt::format("next: {}\n", camera_advice(session.code(), kinect->source)))
            : std::nullopt);
  return end.code;
}

}  // namespace colift::tools
