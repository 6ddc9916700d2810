#include "hal/drivers/ros2_camera/ros2_camera.hpp"

#include <fmt/format.h>
#include <ros2_messages.h>

#include <algorithm>
#include <utility>

#include "hal/dds/participant.hpp"
#include "hal/dds/ros2_names.hpp"
#include "hal/dds/samples.hpp"
#include "hal/drivers/ros2_camera/message_views.hpp"

namespace colift::hal {
namespace {

using namespace std::chrono_literals;
using dds::Qos;
using dds::Taken;
using Image = sensor_msgs_msg_dds__Image_;
using Info = sensor_msgs_msg_dds__CameraInfo_;
using Health = DeviceHealth::State;

constexpr int kMostPublishers = 8;
constexpr Duration kStale = 100ms;

/// Publishers that a reader is matched with.
std::vector<dds_instance_handle_t> publishers_of(dds_entity_t reader) {
  dds_instance_handle_t all[kMostPublishers] = {};
  const dds_return_t n = dds_get_matched_publications(reader, all, kMostPublishers);
  return {all, all + std::clamp<dds_return_t>(n, 0, kMostPublishers)};
}

/// Stays with one publisher as long as it is there.
class Source {
 public:
  bool takes(dds_entity_t reader, dds_instance_handle_t writer) {
    if (writer == writer_) return true;
    const auto there = publishers_of(reader);
    if (writer_ != 0 && std::find(there.begin(), there.end(), writer_) != there.end()) return false;
    writer_ = writer;
    return true;
  }
  void forget() { writer_ = 0; }

 private:
  dds_instance_handle_t writer_ = 0;
};

}  // namespace

struct Ros2Camera::Impl {
  Ros2CameraConfig config;
  const Clock& clock;
  std::unique_ptr<dds::Participant> participant;
  dds_entity_t images = 0, infos = 0, clocks = 0, waitset = 0;
  bool opened = false, active = false;

  Source image_source, info_source, clock_source;
  std::optional<ros2::CameraModel> model;
  std::string frame, info_frame;
  std::optional<Timestamp> last_stamp;
  /// Of /clock, and when it came.
  std::optional<std::pair<Timestamp, Timestamp>> simulated;

  std::uint64_t accepted = 0, rejected = 0;
  std::string last_error;
  Timestamp frame_at{0};  ///< When the last good one was taken.

  Impl(Ros2CameraConfig c, const Clock& k) : config(std::move(c)), clock(k), frame(config.frame) {}
  ~Impl() {
    if (waitset > 0) (void)dds_delete(waitset);
  }

  void reject(const std::string& why) {
    ++rejected;
    last_error = why;
  }

  Result<> open() {
    dds::DdsConfig d;
    const auto domain = dds::domain_or_environment(config.domain);
    if (!domain) return tl::unexpected(domain.error());
    d.domain = *domain;
    d.interface = config.interface;
    d.node = "colift_camera";
    auto made = dds::Participant::open(d);
    if (!made) return tl::unexpected(made.error());
    const auto image = (*made)->reader(config.image, sensor_msgs_msg_dds__Image__desc, Qos::SensorData);
    if (!image) return tl::unexpected(image.error());
    const auto info = (*made)->reader(config.info, sensor_msgs_msg_dds__CameraInfo__desc, Qos::SensorData);
    if (!info) return tl::unexpected(info.error());
    if (config.time == "clock") {
      const auto time = (*made)->reader("/clock", rosgraph_msgs_msg_dds__Clock__desc, Qos::Newest);
      if (!time) return tl::unexpected(time.error());
      clocks = *time;
    }
    images = *image, infos = *info;
    waitset = dds_create_waitset((*made)->handle());
    if (waitset < 0 || dds_set_status_mask(images, DDS_DATA_AVAILABLE_STATUS) != DDS_RETCODE_OK ||
        dds_waitset_attach(waitset, images, 0) != DDS_RETCODE_OK)
      return failure(ErrorCode::DeviceFault, "ros2.camera", "Cyclone DDS gives no waitset");
    participant = std::move(*made);
    return {};
  }

  /// ROS time now.
  [[nodiscard]] std::optional<Timestamp> ros_now() const {
    if (clocks == 0) return std::chrono::system_clock::now().time_since_epoch();
    if (!simulated) return std::nullopt;
    return simulated->first;
  }

  void take_clock() {
    if (clocks == 0) return;
    const Taken<rosgraph_msgs_msg_dds__Clock_> all(clocks);
    for (int i = 0; i < all.size(); ++i)
      if (const auto* c = all.at(i); c && clock_source.takes(clocks, all.writer(i)))
        simulated = {ros2::time_of(c->clock), clock.now()};
  }

  void take_infos() {
    const Taken<Info> all(infos);
    for (int i = 0; i < all.size(); ++i) {
      const Info* m = all.at(i);
      if (m == nullptr) continue;
      if (!info_source.takes(infos, all.writer(i))) {
        reject("a second publisher of " + config.info + " was not listened to");
        continue;
      }
      const ros2::InfoView info = ros2::view_of(*m);
      const auto read = ros2::model_of(info);
      if (!read)
        reject(read.error().text());
      else if (!model)
        model = *read, info_frame = std::string(info.frame_id);
      else if (!(*model == *read) || info.frame_id != info_frame)
        reject("the camera's model changed while it was used; it was calibrated anew or is another one");
    }
  }

  /// When the light of an image was measured, on the robot's clock.
  Result<Timestamp> exposed_at(Timestamp stamp) const {
    const auto wrong = [](std::string what) {
      return failure(ErrorCode::BadReply, "ros2.image", std::move(what));
    };
    const auto now = ros_now();
    if (!now) return wrong("nobody publishes /clock");
    const double age_s = seconds(*now - stamp);
    if (age_s < -config.future_s)
      return wrong(
          fmt::format("its stamp lies {:.3f} s in the future (limit {} s)", -age_s, config.future_s));
    if (age_s > config.max_age_s)
      return wrong(fmt::format("it is {:.3f} s old (limit {} s)", age_s, config.max_age_s));
    if (last_stamp && stamp <= *last_stamp) return wrong("it is not newer than the one before");
    return clock.now() - std::max(*now - stamp, Duration{0});
  }

  Result<DepthFrame> frame_of(const Image& m) {
    const auto wrong = [](std::string what) {
      return failure(ErrorCode::BadReply, "ros2.image", std::move(what));
    };
    const ros2::ImageView image = ros2::view_of(m);
    if (m.header.stamp.nanosec >= 1'000'000'000u) return wrong("its stamp has more than 10^9 ns");
    const auto exposed = exposed_at(image.stamp);
    if (!exposed) return tl::unexpected(exposed.error());
    if (!model) return wrong("there is no camera model yet on " + config.info);
    if (image.frame_id != info_frame || (!frame.empty() && image.frame_id != frame))
      return wrong("its frame id is not that of the camera");
    auto depth = ros2::depth_of(image, *model);
    if (!depth) return tl::unexpected(depth.error());
    if (frame.empty()) frame = std::string(image.frame_id);
    last_stamp = image.stamp;
    DepthFrame out;
    out.exposed_at = *exposed;
    out.intrinsics = model->intrinsics;
    out.depth_m = std::move(*depth);
    return out;
  }

  /// The newest good image of those that came; those before it were overtaken.
  std::optional<DepthFrame> take() {
    take_clock();
    take_infos();
    const Taken<Image> all(images);
    std::optional<DepthFrame> newest;
    for (int i = all.size() - 1; i >= 0 && !newest; --i) {
      const Image* m = all.at(i);
      if (m == nullptr) continue;
      if (!image_source.takes(images, all.writer(i))) {
        reject("a second publisher of " + config.image + " was not listened to");
        continue;
      }
      if (auto read = frame_of(*m))
        newest = std::move(*read);
      else if (model || accepted > 0)
        reject(read.error().text());
      else if (last_error.empty())
        last_error = read.error().text();  // the first images may come before their model
    }
    if (newest) frame_at = clock.now();
    return newest;
  }

  void wait(Duration left) {
    dds_attach_t what = 0;
    (void)dds_waitset_wait(waitset, &what, 1, std::max(left, Duration{0}).count());
  }

  [[nodiscard]] bool silent() const { return seconds(clock.now() - frame_at) > config.silent_s; }

  [[nodiscard]] std::string words_of_loss() const {
    if (publishers_of(images).empty()) return "nobody publishes " + config.image;
    return last_error.empty() ? "no frame on " + config.image : last_error;
  }

  Result<> first_frame() {
    constexpr auto kWhere = "ros2.configure";
    const Timestamp end = clock.now() + duration_of(config.open_s);
    for (;;) {
      if (take()) {
        if (publishers_of(images).size() <= 1) return {};
        return failure(ErrorCode::DeviceFault, kWhere, "more than one publisher of " + config.image);
      }
      const Timestamp now = clock.now();
      if (now >= end) break;
      wait(std::min(end - now, Duration{kStale}));
    }
    if (publishers_of(images).empty())
      return failure(
          ErrorCode::LinkLost, kWhere,
          fmt::format("nobody publishes {} on interface {}; a driver on this machine has to be told to use "
                      "it, with ROS_LOCALHOST_ONLY=1 or ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST",
                      config.image, config.interface));
    return failure(ErrorCode::DeviceFault, kWhere, words_of_loss());
  }
};

Ros2Camera::Ros2Camera(Ros2CameraConfig config, const Clock& clock)
    : impl_(std::make_unique<Impl>(std::move(config), clock)) {}

Ros2Camera::~Ros2Camera() = default;

Result<> Ros2Camera::configure() {
  Impl& c = *impl_;
  if (!c.participant)
    if (auto opened = c.open(); !opened) return opened;
  if (c.opened) {
    // frames come again by themselves; nobody waits for them in the middle of a job
    if (c.take() || !c.silent()) return {};
    return failure(ErrorCode::LinkLost, "ros2.configure", c.words_of_loss());
  }
  if (auto first = c.first_frame(); !first) return first;
  c.opened = true;
  c.last_error.clear();
  return {};
}

Result<> Ros2Camera::activate() {
  if (!impl_->opened)
    return failure(ErrorCode::NotReady, "ros2.activate", "the camera is not open, call configure() first");
  impl_->active = true;
  impl_->frame_at = impl_->clock.now();
  return {};
}

void Ros2Camera::deactivate() noexcept {
  impl_->active = false;
}

Result<DepthFrame> Ros2Camera::next_frame(std::chrono::milliseconds timeout) {
  constexpr auto kWhere = "ros2.next_frame";
  Impl& c = *impl_;
  if (!c.active)
    return failure(ErrorCode::NotReady, kWhere, "the camera does not stream, call activate() first");
  const Timestamp deadline = c.clock.now() + std::max(timeout, 0ms);
  for (;;) {
    if (auto frame = c.take()) {
      ++c.accepted;
      return std::move(*frame);
    }
    if (c.silent()) return failure(ErrorCode::LinkLost, kWhere, c.words_of_loss());
    const Timestamp now = c.clock.now();
    if (now >= deadline)
      return failure(ErrorCode::Timeout, kWhere, fmt::format("no frame within {} ms", timeout.count()));
    c.wait(std::min(deadline - now, Duration{kStale}));
  }
}

DeviceHealth Ros2Camera::health() const {
  const Impl& c = *impl_;
  DeviceHealth h;
  h.accepted = c.accepted;
  h.rejected = c.rejected;
  h.last_error = c.last_error;
  if (!c.opened)
    h.state = c.last_error.empty() ? Health::Absent : Health::Failed;
  else if (!c.active)
    h.state = Health::Opening;
  else if (c.silent())
    h.state = Health::Lost;
  else
    h.state = c.clock.now() - c.frame_at > kStale ? Health::Stalled : Health::Streaming;
  return h;
}

}  // namespace colift::hal
