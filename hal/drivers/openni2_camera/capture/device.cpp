#include "hal/drivers/openni2_camera/capture/device.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <utility>

#include "hal/drivers/capture_link/process/words_out.hpp"

namespace colift::capture {
namespace {

using namespace std::chrono_literals;
using hal::capture::CaptureEnd;
using hal::capture::CaptureState;
using hal::capture::FrameStamp;
using hal::capture::Stream;
using hal::openni2::DepthMode;

constexpr int kTurn_ms = 8;
constexpr auto kGiveUp = 2s;    // without a frame
constexpr auto kFileOver = 1s;  // the same of a recording that had frames

/// What OpenNI2 says of its last error, in one line.
std::string last_words() {
  std::string text = oniGetExtendedError();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\t' || text.back() == ' ')) text.pop_back();
  const std::size_t at = text.find_first_not_of("\t \n");
  return at == std::string::npos ? "no reason is given" : text.substr(at);
}

DepthMode mode_of(const OniVideoMode& m) {
  std::uint32_t unit_um = 0;
  if (m.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_1_MM) unit_um = hal::openni2::kUnit_1mm;
  if (m.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM) unit_um = hal::openni2::kUnit_100um;
  return {m.resolutionX, m.resolutionY, m.fps, unit_um};
}

template <class Value>
bool get(OniStreamHandle stream, int property, Value& value) {
  int size = sizeof value;
  return oniStreamGetProperty(stream, property, &value, &size) == ONI_STATUS_OK && size == sizeof value;
}

template <class Value>
bool set(OniStreamHandle stream, int property, const Value& value) {
  return oniStreamSetProperty(stream, property, &value, sizeof value) == ONI_STATUS_OK;
}

/// Of a fixed field of characters, which may have no end.
template <std::size_t N>
std::string text_in(const char (&field)[N]) {
  return {field, ::strnlen(field, N)};
}

}  // namespace

Device::Device(hal::capture::FrameRingWriter& ring, DeviceRequest request)
    : ring_(ring), request_(std::move(request)) {}

Device::~Device() {
  close();
}

std::optional<End> Device::open() {
  ring_.set_state(CaptureState::Opening);
  say("state opening");
  if (oniInitialize(ONI_API_VERSION) != ONI_STATUS_OK)
    return End{CaptureEnd::CannotOpen, "OpenNI2 does not start: " + last_words()};
  initialised_ = true;
  OniDeviceCallbacks calls{nullptr, on_gone, on_state};
  (void)oniRegisterDeviceCallbacks(&calls, this, &callbacks_);
  for (const auto step : {&Device::open_device, &Device::set_mode, &Device::as_seen, &Device::start})
    if (auto end = (this->*step)()) return end;
  frame_at_ = Clock::now();
  return std::nullopt;
}

std::optional<End> Device::open_device() {
  if (recorded()) {
    opened_uri_ = request_.file;
  } else {
    OniDeviceInfo* all = nullptr;
    int count = 0;
    if (oniGetDeviceList(&all, &count) != ONI_STATUS_OK)
      return End{CaptureEnd::CannotOpen, "the devices cannot be listed: " + last_words()};
    std::string seen;
    for (int i = 0; i < count; ++i) {
      const std::string uri = text_in(all[i].uri);
      seen += (seen.empty() ? "" : ", ") + uri;
      if (opened_uri_.empty() && (request_.uri.empty() || uri == request_.uri)) opened_uri_ = uri;
    }
    (void)oniReleaseDeviceList(all);
    if (opened_uri_.empty())
      return End{CaptureEnd::NoDevice,
                 count == 0 ? "OpenNI2 finds no device" : "no device " + request_.uri + "; there is " + seen};
  }
  if (oniDeviceOpen(opened_uri_.c_str(), &device_) == ONI_STATUS_OK) return std::nullopt;
  device_ = nullptr;
  return End{CaptureEnd::CannotOpen, opened_uri_ + " cannot be opened: " + last_words()};
}

std::optional<End> Device::set_mode() {
  const OniSensorInfo* const sensor = oniDeviceGetSensorInfo(device_, ONI_SENSOR_DEPTH);
  if (sensor == nullptr || oniDeviceCreateStream(device_, ONI_SENSOR_DEPTH, &stream_) != ONI_STATUS_OK) {
    stream_ = nullptr;
    return End{CaptureEnd::NoMode, opened_uri_ + " gives no depth"};
  }
  std::vector<DepthMode> offered;
  for (int i = 0; i < sensor->numSupportedVideoModes; ++i)
    offered.push_back(mode_of(sensor->pSupportedVideoModes[i]));
  // a recording has one mode, whatever is wanted
  const auto chosen = choose_mode(offered, recorded() ? hal::openni2::WantedMode{} : request_.mode);
  if (!chosen) {
    std::string all;
    for (const DepthMode& m : offered) all += (all.empty() ? "" : "; ") + text_of(m);
    return End{CaptureEnd::NoMode,
               "no mode is as it is wanted; the device has " + (all.empty() ? "none" : all)};
  }
  if (!recorded() && !set(stream_, ONI_STREAM_PROPERTY_VIDEO_MODE, sensor->pSupportedVideoModes[*chosen]))
    return End{CaptureEnd::CannotStart,
               text_of(offered[*chosen]) + " is offered and refused: " + last_words()};
  OniVideoMode now{};
  if (!get(stream_, ONI_STREAM_PROPERTY_VIDEO_MODE, now))
    return End{CaptureEnd::CannotStart, "the mode cannot be read: " + last_words()};
  mode_ = mode_of(now);
  const DepthMode& m = offered[*chosen];
  if (mode_.width != m.width || mode_.height != m.height || mode_.unit_um != m.unit_um)
    return End{CaptureEnd::CannotStart, "the mode was set to " + text_of(m) + " and is " + text_of(mode_)};
  return std::nullopt;
}

std::optional<End> Device::as_seen() {
  // the image as the depth sensor sees it: neither moved into that of another sensor, nor mirrored, which
  // devices do from the start, nor cut
  if (!recorded() && oniDeviceIsPropertySupported(device_, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) != FALSE) {
    OniImageRegistrationMode registration = ONI_IMAGE_REGISTRATION_OFF;
    (void)oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &registration,
                               sizeof registration);
    int size = sizeof registration;
    if (oniDeviceGetProperty(device_, ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION, &registration, &size) ==
            ONI_STATUS_OK &&
        registration != ONI_IMAGE_REGISTRATION_OFF)
      return End{CaptureEnd::CannotStart, "the registration of depth to colour cannot be switched off"};
  }
  OniBool mirrored = FALSE;
  // what a recording says is how it was recorded; to ask it for something else would change the answer alone
  if (!recorded()) (void)set(stream_, ONI_STREAM_PROPERTY_MIRRORING, mirrored);
  mirrored_ = get(stream_, ONI_STREAM_PROPERTY_MIRRORING, mirrored) && mirrored != FALSE;
  OniCropping cropping{FALSE, 0, 0, 0, 0};
  if (!recorded()) (void)set(stream_, ONI_STREAM_PROPERTY_CROPPING, cropping);
  // PlayerStream of OpenNI2 2.2 drops every frame of a recording that lacks it, without a word
  if (recorded() && !get(stream_, ONI_STREAM_PROPERTY_CROPPING, cropping))
    return End{CaptureEnd::NoMode,
               "the recording does not say how its image is cropped: OpenNI2 plays none of "
               "its frames then"};
  return std::nullopt;
}

std::optional<End> Device::start() {
  if (recorded()) {
    const OniBool repeat = FALSE;
    (void)oniDeviceSetProperty(device_, ONI_DEVICE_PROPERTY_PLAYBACK_REPEAT_ENABLED, &repeat, sizeof repeat);
    if (!get(stream_, ONI_STREAM_PROPERTY_NUMBER_OF_FRAMES, last_of_file_)) last_of_file_ = 0;
  }
  describe();
  if (!request_.record.empty() && (oniCreateRecorder(request_.record.c_str(), &recorder_) != ONI_STATUS_OK ||
                                   oniRecorderAttachStream(recorder_, stream_, FALSE) != ONI_STATUS_OK ||
                                   oniRecorderStart(recorder_) != ONI_STATUS_OK))
    return End{CaptureEnd::BadCall, request_.record + " cannot be recorded: " + last_words()};
  if (oniStreamStart(stream_) != ONI_STATUS_OK)
    return End{CaptureEnd::CannotStart, "the depth does not start: " + last_words()};
  return std::nullopt;
}

void Device::describe() const {
  OniDeviceInfo info{};
  if (oniDeviceGetInfo(device_, &info) == ONI_STATUS_OK)
    say("name " + text_in(info.vendor) + " " + text_in(info.name));
  std::array<char, 64> serial{};
  int size = static_cast<int>(serial.size()) - 1;
  if (oniDeviceGetProperty(device_, ONI_DEVICE_PROPERTY_SERIAL_NUMBER, serial.data(), &size) == ONI_STATUS_OK)
    say(std::string("serial ") + serial.data());
  float across_rad = 0.0f, down_rad = 0.0f;
  if (get(stream_, ONI_STREAM_PROPERTY_HORIZONTAL_FOV, across_rad) &&
      get(stream_, ONI_STREAM_PROPERTY_VERTICAL_FOV, down_rad))
    say("constants " + std::to_string(across_rad) + " " + std::to_string(down_rad));
  say("note " + text_of(mode_) + (mirrored_ ? ", mirrored" : ""));
}

std::optional<End> Device::turn() {
  if (gone_) return End{CaptureEnd::DeviceLost, "the device is gone"};
  OniStreamHandle streams[] = {stream_};
  int which = 0;
  const OniStatus status = oniWaitForAnyStream(streams, 1, &which, kTurn_ms);
  if (status == ONI_STATUS_TIME_OUT) return look_for_frames();
  OniFrame* frame = nullptr;
  if (status != ONI_STATUS_OK || oniStreamReadFrame(stream_, &frame) != ONI_STATUS_OK || frame == nullptr)
    return End{CaptureEnd::DeviceLost, "no frame can be read: " + last_words()};
  take(*frame);
  oniFrameRelease(frame);
  return look_for_frames();
}

void Device::take(const OniFrame& f) {
  const auto arrived = Clock::now();
  const hal::openni2::ImageView image{f.data,   f.dataSize, f.width,
                                      f.height, f.stride,   f.croppingEnabled != FALSE};
  last_index_ = f.frameIndex;
  std::optional<std::string> wrong;
  if (f.sensorType != ONI_SENSOR_DEPTH || mode_of(f.videoMode).unit_um != mode_.unit_um)
    wrong = "a frame that is not depth in the units of the mode";
  else
    wrong = copy_image(image, mode_, mirrored_, pixels_);
  if (wrong) {
    if (*wrong != complaint_) say("note " + *wrong);
    complaint_ = *wrong;
    return;
  }
  FrameStamp s;
  s.ticks = f.timestamp;
  s.index = static_cast<std::uint64_t>(std::max(f.frameIndex, 0));
  s.arrived_ns = std::chrono::nanoseconds(arrived.time_since_epoch()).count();
  s.width = static_cast<std::uint32_t>(mode_.width);
  s.height = static_cast<std::uint32_t>(mode_.height);
  s.unit_um = mode_.unit_um;
  if (!ring_.write(Stream::Depth, s, pixels_.data())) {
    complaint_ = "a frame is larger than the memory for it";
    return;
  }
  if (frames_++ == 0) {
    ring_.set_state(CaptureState::Streaming);
    say("state streaming");
  }
  complaint_.clear();
  frame_at_ = arrived;
  say("frame");
}

std::optional<End> Device::look_for_frames() const {
  const auto silent = Clock::now() - frame_at_;
  if (recorded() && frames_ > 0 &&
      (silent > kFileOver || (last_of_file_ > 0 && last_index_ >= last_of_file_)))
    return End{CaptureEnd::DeviceLost, "the recording is over"};
  if (silent > kGiveUp)
    return End{CaptureEnd::NoFrames, "no frame for 2 s" + (complaint_.empty() ? "" : "; " + complaint_)};
  return std::nullopt;
}

void Device::finish_recording() {
  if (recorder_ == nullptr) return;
  oniRecorderStop(recorder_);
  (void)oniRecorderDestroy(&recorder_);
  recorder_ = nullptr;
}

void Device::close() {
  finish_recording();
  if (stream_ != nullptr) {
    oniStreamStop(stream_);
    oniStreamDestroy(std::exchange(stream_, nullptr));
  }
  if (device_ != nullptr) (void)oniDeviceClose(std::exchange(device_, nullptr));
  if (callbacks_ != nullptr) oniUnregisterDeviceCallbacks(std::exchange(callbacks_, nullptr));
  if (std::exchange(initialised_, false)) oniShutdown();
}

void Device::on_gone(const OniDeviceInfo* info, void* self) {
  auto& d = *static_cast<Device*>(self);
  if (info != nullptr && text_in(info->uri) == d.opened_uri_) d.gone_ = true;
}

void Device::on_state(const OniDeviceInfo* info, OniDeviceState state, void* self) {
  if (state == ONI_DEVICE_STATE_ERROR) on_gone(info, self);
}

}  // namespace colift::capture
