#include "sim_hal/emulator/camera/openni2/emulated_stream.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim_hal/synthetic/kinect/kinect_code.hpp"

namespace colift::sim_hal {
namespace {

constexpr int kWidth = 640;
constexpr double kFocal_px = 575.8;
constexpr int kShift = 8;  // pixels, by registration with a colour image that is not there
constexpr double kTicksPerMicrosecond = 60.0;
constexpr int kMaxDepth_mm = 10000;

/// Millimetres of a raw code; 0 where it has no depth.
std::uint16_t mm_of(std::uint16_t code) {
  if (code >= kKinectCodes) return 0;
  const float z = kinect_depths_m()[static_cast<std::size_t>(code) + 1];
  return z > 0.0f && z < 10.0f ? static_cast<std::uint16_t>(std::lround(1000.0f * z)) : 0;
}

/// In a millimetre.
int units_of(const OniVideoMode& mode) {
  return mode.pixelFormat == ONI_PIXEL_FORMAT_DEPTH_100_UM ? 10 : 1;
}

float field_of_view(int pixels) {
  return static_cast<float>(2.0 * std::atan(0.5 * pixels / kFocal_px));
}

template <class Value>
OniStatus give(const Value& value, void* data, int* size) {
  if (*size < static_cast<int>(sizeof value)) return ONI_STATUS_BAD_PARAMETER;
  std::memcpy(data, &value, sizeof value);
  *size = static_cast<int>(sizeof value);
  return ONI_STATUS_OK;
}

}  // namespace

bool EmulatedStream::runs() const {
  const std::lock_guard lock(mutex_);
  return runs_;
}

OniStatus EmulatedStream::start() {
  const std::lock_guard lock(mutex_);
  runs_ = true;
  return ONI_STATUS_OK;
}

void EmulatedStream::stop() {
  std::unique_lock lock(mutex_);
  runs_ = false;
  delivered_.wait(lock, [this] { return !delivers_; });
}

int EmulatedStream::getRequiredFrameSize() {
  const std::lock_guard lock(mutex_);
  return 2 * mode_.resolutionX * mode_.resolutionY;
}

OniBool EmulatedStream::isPropertySupported(int property) {
  switch (property) {
    case ONI_STREAM_PROPERTY_CROPPING:  // without it OpenNI2 records what it cannot play
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
    case ONI_STREAM_PROPERTY_MAX_VALUE:
    case ONI_STREAM_PROPERTY_MIN_VALUE:
    case ONI_STREAM_PROPERTY_STRIDE:
    case ONI_STREAM_PROPERTY_MIRRORING:
      return TRUE;
    default:
      return FALSE;
  }
}

OniStatus EmulatedStream::getProperty(int property, void* data, int* size) {
  const std::lock_guard lock(mutex_);
  switch (property) {
    case ONI_STREAM_PROPERTY_CROPPING:
      return give(OniCropping{FALSE, 0, 0, 0, 0}, data, size);
    case ONI_STREAM_PROPERTY_HORIZONTAL_FOV:
      return give(field_of_view(kWidth), data, size);
    case ONI_STREAM_PROPERTY_VERTICAL_FOV:
      return give(field_of_view(480), data, size);
    case ONI_STREAM_PROPERTY_VIDEO_MODE:
      return give(mode_, data, size);
    case ONI_STREAM_PROPERTY_MAX_VALUE:
      return give(std::min(units_of(mode_) * kMaxDepth_mm, 0xffff), data, size);
    case ONI_STREAM_PROPERTY_MIN_VALUE:
      return give(0, data, size);
    case ONI_STREAM_PROPERTY_STRIDE:
      return give(2 * mode_.resolutionX, data, size);
    case ONI_STREAM_PROPERTY_MIRRORING:
      return give(mirrored_, data, size);
    default:
      return ONI_STATUS_NOT_SUPPORTED;
  }
}

OniStatus EmulatedStream::setProperty(int property, const void* data, int size) {
  const std::lock_guard lock(mutex_);
  if (property == ONI_STREAM_PROPERTY_MIRRORING && size == static_cast<int>(sizeof mirrored_)) {
    std::memcpy(&mirrored_, data, sizeof mirrored_);
    return ONI_STATUS_OK;
  }
  if (property == ONI_STREAM_PROPERTY_CROPPING && size == static_cast<int>(sizeof(OniCropping))) {
    OniCropping asked{};
    std::memcpy(&asked, data, sizeof asked);
    return asked.enabled == FALSE ? ONI_STATUS_OK : ONI_STATUS_NOT_SUPPORTED;
  }
  if (property != ONI_STREAM_PROPERTY_VIDEO_MODE || size != static_cast<int>(sizeof mode_))
    return ONI_STATUS_NOT_SUPPORTED;
  OniVideoMode asked{};
  std::memcpy(&asked, data, sizeof asked);
  const bool known = std::any_of(kModes.begin(), kModes.end(), [&](const OniVideoMode& m) {
    return m.pixelFormat == asked.pixelFormat && m.resolutionX == asked.resolutionX &&
           m.resolutionY == asked.resolutionY && m.fps == asked.fps;
  });
  if (!known || runs_) return ONI_STATUS_BAD_PARAMETER;
  mode_ = asked;
  return ONI_STATUS_OK;
}

void EmulatedStream::deliver(const std::vector<std::uint16_t>& codes, std::uint32_t ticks, bool shifted) {
  std::unique_lock lock(mutex_);
  if (!runs_) return;
  if (counted_) ticks_ += static_cast<std::int32_t>(ticks - last_ticks_);
  counted_ = true;
  last_ticks_ = ticks;
  const OniVideoMode mode = mode_;
  const bool mirrored = mirrored_ != FALSE;
  delivers_ = true;
  lock.unlock();
  if (OniFrame* const frame = getServices().acquireFrame()) {
    fill(*frame, codes, mode, mirrored, shifted);
    raiseNewFrame(frame);  // OpenNI2's locks are taken here: ours is not
    getServices().releaseFrame(frame);
  }
  lock.lock();
  delivers_ = false;
  delivered_.notify_all();
}

void EmulatedStream::fill(OniFrame& frame, const std::vector<std::uint16_t>& codes, const OniVideoMode& mode,
                          bool mirrored, bool shifted) const {
  const int step = kWidth / mode.resolutionX;
  const int rows = std::min(mode.resolutionY, static_cast<int>(codes.size()) / kWidth / step);
  const int units = units_of(mode);
  auto* to = static_cast<std::uint16_t*>(frame.data);
  for (int v = 0; v < rows; ++v)
    for (int u = 0; u < mode.resolutionX; ++u) {
      const int seen = (mirrored ? mode.resolutionX - 1 - u : u) * step + (shifted ? kShift : 0);
      const auto at = static_cast<std::size_t>(v) * static_cast<std::size_t>(step) * kWidth +
                      static_cast<std::size_t>(std::min(seen, kWidth - 1));
      const int depth = units * mm_of(codes[at]);
      *to++ = depth <= 0xffff ? static_cast<std::uint16_t>(depth) : std::uint16_t{0};
    }
  const double us = std::max(0.0, static_cast<double>(ticks_) / kTicksPerMicrosecond);
  frame.sensorType = ONI_SENSOR_DEPTH;
  frame.timestamp = static_cast<std::uint64_t>(us);
  frame.frameIndex = 1 + static_cast<int>(std::lround(1e-6 * us * mode.fps));  // none for a picture not sent
  frame.videoMode = mode;
  frame.width = mode.resolutionX;
  frame.height = rows;
  frame.stride = 2 * mode.resolutionX;
  frame.dataSize = frame.stride * rows;
  frame.croppingEnabled = FALSE;
  frame.cropOriginX = frame.cropOriginY = 0;
}

}  // namespace colift::sim_hal
