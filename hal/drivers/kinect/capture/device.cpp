#include "hal/drivers/kinect/capture/device.hpp"

#include <sys/time.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/drivers/capture_link/process/words_out.hpp"
#include "hal/drivers/kinect/kinect_facts.hpp"
#include "hal/drivers/kinect/lost_packets.hpp"

namespace colift::capture {
namespace {

using namespace std::chrono_literals;
namespace kinect = hal::kinect;
using hal::capture::CaptureState;
using hal::capture::FrameRingWriter;
using hal::capture::FrameStamp;
using hal::capture::Stream;

constexpr int kErrors = 3;        // in a row: one alone may be got over
constexpr auto kRestart = 500ms;  // without a frame: the stream is stopped and started
constexpr auto kGiveUp = 2s;
constexpr auto kAccelerometer = 1s;
constexpr suseconds_t kTurn_us = 8000;

Device* logs_to = nullptr;  // the library's log knows the context only

}  // namespace

Device::Device(FrameRingWriter& ring, std::string serial, bool motor)
    : ring_(ring),
      serial_(std::move(serial)),
      motor_(motor),
      depth_(kinect::kPixels),
      infrared_(kinect::kInfraredPixels) {}

Device::~Device() {
  close();
}

std::optional<End> Device::open() {
  ring_.set_state(CaptureState::Opening);
  say("state opening");
  if (freenect_init(&context_, nullptr) < 0) {
    context_ = nullptr;
    return End{CaptureEnd::CannotOpen, "libusb does not start: is /dev/bus/usb there?"};
  }
  logs_to = this;
  freenect_set_log_callback(context_, on_log);
  freenect_set_log_level(context_, FREENECT_LOG_INFO);  // lost packets are told there and nowhere else
  const int subdevices = FREENECT_DEVICE_CAMERA | (motor_ ? FREENECT_DEVICE_MOTOR : 0);
  freenect_select_subdevices(context_, static_cast<freenect_device_flags>(subdevices));
  const int found = freenect_num_devices(context_);
  if (found <= 0) return End{CaptureEnd::NoDevice, "no Kinect on USB"};
  const std::string serial = serial_.empty() ? first_serial(context_) : serial_;
  const int opened = serial_.empty()
                         ? freenect_open_device(context_, &device_, 0)
                         : freenect_open_device_by_camera_serial(context_, &device_, serial_.c_str());
  if (opened < 0) {
    device_ = nullptr;
    const std::string which = serial_.empty() ? "the Kinect" : "the Kinect with serial " + serial_;
    return End{CaptureEnd::CannotOpen,
               which + " cannot be opened: " +
                   (last_log_.empty() ? "no permission, or another program has it" : last_log_)};
  }
  freenect_set_user(device_, this);
  freenect_set_depth_callback(device_, on_depth);
  freenect_set_video_callback(device_, on_video);
  const auto mode = depth_mode();
  if (!mode || mode->bytes != static_cast<int>(2 * kinect::kPixels))
    return End{CaptureEnd::NoMode, "the library has no 11-bit depth of 640 x 480 pixels"};
  if (freenect_set_depth_mode(device_, *mode) < 0 || freenect_set_depth_buffer(device_, depth_.data()) < 0)
    return End{CaptureEnd::CannotStart, "the depth mode is refused: " + last_log_};
  if (!serial.empty()) say("serial " + serial);
  if (const auto c = constants_of(device_))
    say("constants " + std::to_string(c->emitter_cm) + " " + std::to_string(c->reference_cm) + " " +
        std::to_string(c->pixel_cm) + " " + std::to_string(c->shift));
  say(std::string("features") + (infrared_mode() ? " infrared" : "") + (motor_ ? " motor" : ""));
  if (freenect_start_depth(device_) < 0)
    return End{CaptureEnd::CannotStart, "the depth does not start: " + last_log_};
  depth_on_ = true;
  frame_at_ = restarted_at_ = Clock::now();
  return std::nullopt;
}

std::optional<End> Device::turn() {
  timeval timeout{0, kTurn_us};
  if (freenect_process_events_timeout(context_, &timeout) < 0) {
    // once may be a bad transfer; a device that is gone says so for ever
    if (++errors_in_a_row_ >= kErrors)
      return End{CaptureEnd::DeviceLost,
                 frames_ == 0 ? "the device failed before its first frame" : "the device is gone"};
    say("note the library reports an error; tries on");
  }
  const Clock::time_point now = Clock::now();
  if (frames_ != frames_seen_) {
    if (frames_seen_ == 0) {
      ring_.set_state(CaptureState::Streaming);
      say("state streaming");
    }
    frames_seen_ = frames_;
    errors_in_a_row_ = 0;
    say("frame");
  }
  if (auto end = watch_frames(now)) return end;
  read_accelerometer(now);
  return std::nullopt;
}

std::optional<End> Device::watch_frames(Clock::time_point now) {
  if (now - frame_at_ > kGiveUp)
    return End{CaptureEnd::NoFrames, "no frame for 2 s, the stream was restarted"};
  if (now - frame_at_ > kRestart && now - restarted_at_ > kRestart) {
    restarted_at_ = now;
    say("note no frame for 0.5 s: the stream is stopped and started");
    (void)freenect_stop_depth(device_);
    depth_on_ = freenect_start_depth(device_) >= 0;
    if (!depth_on_) return End{CaptureEnd::CannotStart, "the depth does not start again: " + last_log_};
  }
  return std::nullopt;
}

void Device::read_accelerometer(Clock::time_point now) {
  if (!motor_ || now - accel_at_ < kAccelerometer) return;
  accel_at_ = now;
  if (freenect_update_tilt_state(device_) < 0) return;
  const freenect_raw_tilt_state* s = freenect_get_tilt_state(device_);
  if (s == nullptr) return;
  motion_.accel[0] = s->accelerometer_x;
  motion_.accel[1] = s->accelerometer_y;
  motion_.accel[2] = s->accelerometer_z;
  motion_.tilt_half_deg = s->tilt_angle;
  motion_.has_accel = 1;
}

std::optional<std::string> Device::want_infrared(bool wanted) {
  if (wanted == infrared_on_) return std::nullopt;
  if (!wanted) {
    infrared_on_ = false;
    (void)freenect_stop_video(device_);
    return std::nullopt;
  }
  const auto mode = infrared_mode();
  if (!mode || mode->bytes != static_cast<int>(2 * kinect::kInfraredPixels))
    return "there is no infrared here: a recording holds none";
  if (freenect_set_video_mode(device_, *mode) < 0 ||
      freenect_set_video_buffer(device_, infrared_.data()) < 0 || freenect_start_video(device_) < 0)
    return "the infrared stream does not start: " + last_log_;
  infrared_on_ = true;
  return std::nullopt;
}

std::optional<std::string> Device::set_brightness(int brightness) {
  if (!set_ir_brightness(device_, std::clamp(brightness, 1, 50))) return "the brightness cannot be set here";
  return std::nullopt;
}

std::optional<std::string> Device::tilt(double degrees) {
  if (!motor_) return "the motor is not opened (kinect.motor)";
  if (!(std::abs(degrees) <= kinect::kTilt_deg)) return "the motor goes to 31 degrees to either side";
  if (freenect_set_tilt_degs(device_, degrees) < 0) return "the motor refuses: " + last_log_;
  return std::nullopt;
}

void Device::close() {
  if (device_ != nullptr) {
    // closing alone leaves the second stream running
    if (infrared_on_) (void)freenect_stop_video(device_);
    if (depth_on_) (void)freenect_stop_depth(device_);
    (void)freenect_close_device(device_);
  }
  if (context_ != nullptr) (void)freenect_shutdown(context_);
  device_ = nullptr;
  context_ = nullptr;
  depth_on_ = infrared_on_ = false;
  logs_to = nullptr;
}

FrameStamp Device::stamp(std::uint32_t ticks, int height) const {
  FrameStamp s = motion_;
  s.ticks = ticks;
  s.width = kinect::kWidth;
  s.height = static_cast<std::uint32_t>(height);
  s.arrived_ns = std::chrono::nanoseconds(Clock::now().time_since_epoch()).count();
  return s;
}

void Device::on_depth(freenect_device* device, void* pixels, std::uint32_t ticks) {
  auto& self = *static_cast<Device*>(freenect_get_user(device));
  FrameStamp s = self.stamp(ticks, kinect::kHeight);
  s.lost_packets = std::exchange(self.lost_, 0);
  (void)self.ring_.write(Stream::Depth, s, static_cast<const std::uint16_t*>(pixels));
  ++self.frames_;
  self.frame_at_ = Clock::now();
}

void Device::on_video(freenect_device* device, void* pixels, std::uint32_t ticks) {
  auto& self = *static_cast<Device*>(freenect_get_user(device));
  if (!self.infrared_on_) return;
  (void)self.ring_.write(Stream::Infrared, self.stamp(ticks, kinect::kInfraredHeight),
                         static_cast<const std::uint16_t*>(pixels));
}

void Device::on_log(freenect_context*, freenect_loglevel level, const char* text) {
  if (logs_to != nullptr && text != nullptr) logs_to->log(level, text);
}

void Device::log(int level, const char* text) {
  std::string line(text);
  while (!line.empty() && line.back() == '\n') line.pop_back();
  if (const auto lost = kinect::lost_packets(line)) lost_ += static_cast<std::uint32_t>(*lost);
  if (level > FREENECT_LOG_WARNING) return;
  last_log_ = line;
  say("note " + line);
}

}  // namespace colift::capture
