#include "hal/drivers/kinect/kinect_stream.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "hal/drivers/kinect/lost_packets.hpp"

namespace colift::hal::kinect {
namespace {

using capture::FrameStamp;
using capture::RawFrame;
using capture::Stream;

/// Against gravity, from the accelerometer: y is up, x right, z backwards on a level device. The sign of x
/// and z has not been tried on a device.
std::optional<Vec3> up_of(const FrameStamp& s) {
  if (s.has_accel == 0) return std::nullopt;
  const Vec3 a(s.accel[0], -s.accel[1], -s.accel[2]);
  const double g = a.norm() / kCountsPerG;
  if (!(g > 0.8 && g < 1.2)) return std::nullopt;  // shaken, or nonsense
  return a.normalized();
}

/// What the device says of its geometry; nothing when no Kinect is like that.
std::optional<DepthConstants> constants_of(const std::vector<double>& said) {
  if (said.size() != 4) return std::nullopt;
  const DepthConstants c{said[0], said[1], said[2], said[3]};
  return plausible(c) ? std::optional(c) : std::nullopt;
}

}  // namespace

Result<> KinectStream::find_source() {
  if (source_) return {};
  auto found = kinect_source(config);
  if (!found) return tl::unexpected(found.error());
  source_ = std::move(*found);
  call_ = source_->call;
  return {};
}

void KinectStream::started() {
  times_.forget();
  before_.pixels.clear();
  device_at_ = infrared_at_ = Timestamp::min();
  if (infrared) ask_for_infrared();
}

void KinectStream::heard() {
  if (report.own_constants) return;
  if (const auto c = constants_of(news().constants)) {
    table = DepthTable(*c);
    report.own_constants = true;
  }
}

void KinectStream::ask_for_infrared() const {
  send_line("infrared on");
  if (config.infrared_brightness > 0) send_line(fmt::format("brightness {}", config.infrared_brightness));
}

Timestamp KinectStream::exposed(Timestamp measured) const {
  return measured - duration_of(1e-3 * config.latency_ms);
}

bool KinectStream::is_size(const RawFrame& raw, int height) {
  if (raw.stamp.width == static_cast<std::uint32_t>(kWidth) &&
      raw.stamp.height == static_cast<std::uint32_t>(height))
    return true;
  reject(fmt::format("a frame of {} x {} pixels, expected {} x {}", raw.stamp.width, raw.stamp.height, kWidth,
                     height));
  return false;
}

std::optional<DepthFrame> KinectStream::take() {
  std::swap(raw_, before_);
  if (!read(Stream::Depth, raw_) || !is_size(raw_, kHeight)) {
    std::swap(raw_, before_);
    return std::nullopt;
  }
  const auto t = times_.note(static_cast<std::uint32_t>(raw_.stamp.ticks), arrival(raw_.stamp));
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
  return frame;
}

std::optional<InfraredFrame> KinectStream::take_infrared() {
  if (!read(Stream::Infrared, infrared_raw_) || !is_size(infrared_raw_, kInfraredHeight)) return std::nullopt;
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

}  // namespace colift::hal::kinect
