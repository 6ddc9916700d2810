#include "tools/dds/ros2_publisher.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "tools/dds/convert_parts.hpp"
#include "tools/dds/outlets.hpp"

namespace colift::ros2 {
namespace {

using hal::dds::Qos;
using telemetry::Topic;

/// How far stamps may be from the system's time before they are set anew.
constexpr hal::Duration kDrift = std::chrono::milliseconds(50);

/// A message that waits, with what makes ROS time of its robot's time.
struct Waiting {
  telemetry::Publication message;
  hal::Duration to_ros{0};
};

hal::Timestamp system_time() {
  return std::chrono::system_clock::now().time_since_epoch();
}

}  // namespace

struct Ros2Publisher::Impl {
  PublisherConfig config;
  std::unique_ptr<hal::dds::Participant> participant;
  std::vector<Outlet> out = outlets();
  std::vector<dds_entity_t> writers;  ///< One for each outlet.
  std::vector<bool> wanted = std::vector<bool>(telemetry::kTopics, false);

  mutable std::mutex mutex;
  std::condition_variable news, idle;
  std::deque<Waiting> queue;
  std::size_t queued_bytes = 0;
  bool ends = false, busy = false;
  PublisherCounts counts;
  std::optional<hal::Duration> to_ros;
  CameraTransform camera;
  std::thread thread;

  hal::Result<> open() {
    auto made = hal::dds::Participant::open(config.dds);
    if (!made) return tl::unexpected(made.error());
    participant = std::move(*made);
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Outlet& o = out[i];
      wanted[static_cast<std::size_t>(o.channel)] = true;
      if (const std::size_t first = first_of_topic(out, i); first < i) {
        writers.push_back(writers[first]);
        continue;
      }
      const auto writer = participant->writer(o.topic, *o.type, o.qos);
      if (!writer) return tl::unexpected(writer.error());
      writers.push_back(*writer);
    }
    thread = std::thread([this] { run(); });
    return {};
  }

  void run() {
    // whoever works goes before whoever watches
    (void)::setpriority(PRIO_PROCESS, static_cast<id_t>(::gettid()), 10);
    std::unique_lock lock(mutex);
    for (;;) {
      news.wait(lock, [&] { return ends || !queue.empty(); });
      if (queue.empty()) return;
      const Waiting next = std::move(queue.front());
      queue.pop_front();
      queued_bytes -= next.message.bytes;
      busy = true;
      lock.unlock();
      PublisherCounts sent;
      pass_on(next, sent);
      lock.lock();
      counts.written += sent.written, counts.failed += sent.failed;
      busy = false;
      if (queue.empty()) idle.notify_all();
    }
  }

  /// A simulation goes faster or slower than the system's clock. A depth image keeps what its camera model
  /// has, which comes right before it: both have the same stamp.
  void follow_time(const telemetry::Publication& p) {
    if (to_ros && p.topic == Topic::Depth) return;
    const hal::Duration now = system_time() - p.at;
    if (!to_ros || now - *to_ros > kDrift || *to_ros - now > kDrift) to_ros = now;
  }

  /// Drops the oldest of what comes all the time. What comes seldom stays, the newest of each channel.
  void make_room() {
    const auto drop = [this](auto at) {
      queued_bytes -= at->message.bytes;
      queue.erase(at);
      ++counts.dropped;
    };
    if (telemetry::is_lasting(queue.back().message.topic)) {
      const auto older = std::find_if(queue.begin(), queue.end() - 1, [this](const auto& p) {
        return p.message.topic == queue.back().message.topic;
      });
      if (older != queue.end() - 1) drop(older);
    }
    while (queue.size() > config.queue_messages || queued_bytes > config.queue_bytes) {
      const auto oldest = std::find_if(queue.begin(), queue.end(),
                                       [](const auto& p) { return !telemetry::is_lasting(p.message.topic); });
      if (oldest == queue.end()) return;
      drop(oldest);
    }
  }

  [[nodiscard]] static bool has_readers(dds_entity_t writer) {
    dds_publication_matched_status_t status;
    return dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK && status.current_count > 0;
  }

  void pass_on(const Waiting& waiting, PublisherCounts& sent) {
    const telemetry::Publication& p = waiting.message;
    std::string bytes;
    for (std::size_t i = 0; i < out.size(); ++i) {
      const Outlet& o = out[i];
      if (o.channel != p.topic || (o.qos != Qos::Latched && !has_readers(writers[i]))) continue;
      if (bytes.empty()) bytes = p.encode();
      try {
        if (o.channel == Topic::Transforms && o.qos == Qos::Latched && camera.repeats(bytes)) continue;
        (void)o.convert({bytes, p.at, waiting.to_ros}, [&](const void* message) {
          ++(dds_write(writers[i], message) == DDS_RETCODE_OK ? sent.written : sent.failed);
        });
      } catch (const Json::exception&) {
        ++sent.failed;
      }
    }
  }
};

Ros2Publisher::Ros2Publisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Ros2Publisher::~Ros2Publisher() {
  {
    const std::lock_guard lock(impl_->mutex);
    impl_->ends = true;
    impl_->queue.clear();
  }
  impl_->news.notify_all();
  if (impl_->thread.joinable()) impl_->thread.join();
}

hal::Result<std::unique_ptr<Ros2Publisher>> Ros2Publisher::open(const PublisherConfig& config) {
  auto impl = std::make_unique<Impl>();
  impl->config = config;
  if (auto opened = impl->open(); !opened) return tl::unexpected(opened.error());
  return std::unique_ptr<Ros2Publisher>(new Ros2Publisher(std::move(impl)));
}

void Ros2Publisher::publish(const telemetry::Publication& publication) {
  Impl& i = *impl_;
  if (!i.wanted[static_cast<std::size_t>(publication.topic)]) return;
  const std::lock_guard lock(i.mutex);
  i.follow_time(publication);
  ++i.counts.handed_in;
  i.queue.push_back({publication, *i.to_ros});
  i.queued_bytes += publication.bytes;
  i.make_room();
  i.news.notify_one();
}

bool Ros2Publisher::flush(std::chrono::milliseconds timeout) {
  Impl& i = *impl_;
  const auto end = std::chrono::steady_clock::now() + timeout;
  {
    std::unique_lock lock(i.mutex);
    if (!i.idle.wait_until(lock, end, [&] { return i.queue.empty() && !i.busy; })) return false;
  }
  for (const dds_entity_t writer : i.writers) {
    const auto left =
        std::chrono::duration_cast<std::chrono::nanoseconds>(end - std::chrono::steady_clock::now());
    if (left.count() <= 0 || dds_wait_for_acks(writer, left.count()) != DDS_RETCODE_OK) return false;
  }
  return true;
}

PublisherCounts Ros2Publisher::counts() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->counts;
}

}  // namespace colift::ros2
