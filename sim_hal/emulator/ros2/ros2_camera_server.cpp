#include "sim_hal/emulator/ros2/ros2_camera_server.hpp"

#include <ros2_messages.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "hal/dds/message_parts.hpp"
#include "hal/dds/participant.hpp"
#include "hal/dds/samples.hpp"
#include "hal/types/time.hpp"

namespace colift::sim_hal {
namespace {

using namespace std::chrono_literals;
using hal::dds::Sample;
using Image = sensor_msgs_msg_dds__Image_;
using Info = sensor_msgs_msg_dds__CameraInfo_;
using Kind = Ros2CameraFault::Kind;

constexpr double kMax_mm = 65535.0;

hal::Duration system_time() {
  return std::chrono::duration_cast<hal::Duration>(std::chrono::system_clock::now().time_since_epoch());
}

/// The node, its publishers and what they need.
struct Node {
  std::unique_ptr<hal::dds::Participant> participant;
  std::int32_t image = 0, info = 0;

  static hal::Result<Node> open(const Ros2CameraServerConfig& config) {
    auto participant =
        hal::dds::Participant::open({config.domain, config.interface, "emulated_depth_camera"});
    if (!participant) return tl::unexpected(participant.error());
    Node node;
    node.participant = std::move(*participant);
    const auto image =
        node.participant->writer(config.image, sensor_msgs_msg_dds__Image__desc, hal::dds::Qos::SensorData);
    if (!image) return tl::unexpected(image.error());
    const auto info =
        node.participant->writer(config.info, sensor_msgs_msg_dds__CameraInfo__desc, hal::dds::Qos::Reliable);
    if (!info) return tl::unexpected(info.error());
    node.image = *image, node.info = *info;
    return node;
  }
};

}  // namespace

struct Ros2CameraServer::Impl {
  Impl(Ros2CameraServerConfig c, std::unique_ptr<VideoSource> s, Node n)
      : config(std::move(c)), source(std::move(s)), node(std::move(n)) {}

  Ros2CameraServerConfig config;
  std::unique_ptr<VideoSource> source;
  std::optional<Node> node;
  hal::SteadyClock clock;
  std::thread thread;

  mutable std::mutex mutex;
  std::condition_variable wake;
  bool stops = false;
  std::optional<hal::Timestamp> began;  ///< Times of faults count from here.
  Report report;

  /// Of this thread alone.
  std::vector<std::uint16_t> picture;
  std::optional<hal::Duration> same_stamp;

  [[nodiscard]] std::optional<double> active(Kind kind) const {
    const std::lock_guard lock(mutex);
    if (!began) return std::nullopt;
    const double t_s = hal::seconds(clock.now() - *began);
    for (auto f = config.faults.rbegin(); f != config.faults.rend(); ++f)
      if (f->kind == kind && f->active(t_s)) return f->value;
    return std::nullopt;
  }

  /// False: it is to stop.
  bool wait_until(hal::Timestamp due) {
    std::unique_lock lock(mutex);
    wake.wait_for(lock, due - clock.now(), [&] { return stops; });
    return !stops;
  }

  void run() {
    hal::Timestamp due = clock.now();
    for (std::uint64_t frame = 0; wait_until(due); ++frame) {
      const double rate_hz = active(Kind::Slow).value_or(config.rate_hz);
      // a machine that stood still skips what it missed
      due = std::max(due, clock.now() - 100ms) + hal::duration_of(1.0 / rate_hz);
      if (active(Kind::Unplug)) {
        node.reset();
        continue;
      }
      if (!node) {
        auto again = Node::open(config);
        if (!again) continue;
        node = std::move(*again);
      }
      if (active(Kind::Silent)) continue;
      const hal::Timestamp exposed = clock.now();
      const hal::Duration stamp = system_time();
      if (!active(Kind::Freeze) || picture.empty()) take_picture(frame);
      const double render_ms = 1e3 * hal::seconds(clock.now() - exposed);
      if (const auto late_ms = active(Kind::Late))
        if (!wait_until(exposed + hal::duration_of(*late_ms / 1e3))) return;
      publish(stamp);
      const std::lock_guard lock(mutex);
      ++report.frames;
      report.worst_render_ms = std::max(report.worst_render_ms, render_ms);
    }
  }

  void take_picture(std::uint64_t frame) {
    const std::vector<float> depth_m = source->look(frame);
    picture.resize(depth_m.size());
    for (std::size_t i = 0; i < depth_m.size(); ++i) {
      const double mm = 1e3 * static_cast<double>(depth_m[i]);
      picture[i] = mm > 0.0 && mm < kMax_mm ? static_cast<std::uint16_t>(std::lround(mm)) : std::uint16_t{0};
    }
  }

  void publish(hal::Duration stamp) {
    if (const auto jump_ms = active(Kind::Jump)) stamp += hal::duration_of(*jump_ms / 1e3);
    if (!active(Kind::Restamp))
      same_stamp.reset();
    else if (!same_stamp)
      same_stamp = stamp;
    stamp = same_stamp.value_or(stamp);

    const hal::CameraIntrinsics& k = source->camera();
    Sample<Info> info(sensor_msgs_msg_dds__CameraInfo__desc);
    hal::dds::set_header(info->header, stamp, config.frame_id);
    info->width = static_cast<std::uint32_t>(k.width) / (active(Kind::Resized) ? 2U : 1U);
    info->height = static_cast<std::uint32_t>(k.height);
    hal::dds::set_pinhole(*info, k.fx, k.fy, k.cx, k.cy);
    (void)dds_write(node->info, &*info);

    Sample<Image> image(sensor_msgs_msg_dds__Image__desc);
    hal::dds::set_header(image->header, stamp, config.frame_id);
    image->width = static_cast<std::uint32_t>(k.width);
    image->height = static_cast<std::uint32_t>(k.height);
    image->step = 2 * image->width;
    hal::dds::set(image->encoding, "16UC1");
    std::size_t size = picture.size();
    if (const auto percent = active(Kind::Short))
      size = static_cast<std::size_t>(static_cast<double>(size) * *percent / 100.0);
    std::uint8_t* to = hal::dds::resize(image->data, 2 * size);
    const bool blind = active(Kind::Blind).has_value();
    for (std::size_t i = 0; i < size && !blind; ++i) {  // little endian
      to[2 * i] = static_cast<std::uint8_t>(picture[i] & 0xff);
      to[2 * i + 1] = static_cast<std::uint8_t>(picture[i] >> 8);
    }
    (void)dds_write(node->image, &*image);
  }
};

Ros2CameraServer::Ros2CameraServer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
  impl_->thread = std::thread([i = impl_.get()] { i->run(); });
}

Ros2CameraServer::~Ros2CameraServer() {
  stop();
}

hal::Result<std::unique_ptr<Ros2CameraServer>> Ros2CameraServer::start(const Ros2CameraServerConfig& config,
                                                                       std::unique_ptr<VideoSource> source) {
  auto node = Node::open(config);
  if (!node) return tl::unexpected(node.error());
  return std::unique_ptr<Ros2CameraServer>(
      new Ros2CameraServer(std::make_unique<Impl>(config, std::move(source), std::move(*node))));
}

void Ros2CameraServer::begin() {
  const std::lock_guard lock(impl_->mutex);
  impl_->began = impl_->clock.now();
}

void Ros2CameraServer::stop() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->stops = true;
  }
  impl_->wake.notify_all();
  if (impl_->thread.joinable()) impl_->thread.join();
  impl_->node.reset();
}

ServedCamera::Report Ros2CameraServer::report() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->report;
}

}  // namespace colift::sim_hal
