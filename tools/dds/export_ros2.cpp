#include "tools/dds/export_ros2.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <map>
#include <set>

#include "tools/dds/bag_metadata.hpp"
#include "tools/dds/cdr.hpp"
#include "tools/dds/convert_parts.hpp"
#include "tools/dds/message_definition.hpp"
#include "tools/dds/outlets.hpp"
#include "tools/telemetry/channels/built_in_texts.hpp"
#include "tools/telemetry/mcap/mcap_chunk.hpp"
#include "tools/telemetry/mcap/mcap_writer.hpp"
#include "tools/telemetry/replay/export_files.hpp"

namespace colift::ros2 {
namespace {

using hal::dds::Qos;
using telemetry::McapReader;
using telemetry::Topic;

constexpr std::size_t kChunkBytes = 4u << 20;
constexpr const char* kBagFile = "bag_0.mcap";

std::uint64_t nanoseconds(hal::Timestamp at) {
  return static_cast<std::uint64_t>(std::max<std::int64_t>(at.count(), 0));
}

/// A time of the file, which may be anything.
hal::Timestamp time_in(std::uint64_t ns) {
  return bounded(static_cast<std::int64_t>(std::min<std::uint64_t>(ns, INT64_MAX)), 1'000'000'000);
}

/// "2026-11-24T17:24:48Z" since 1970.
std::optional<hal::Duration> date_of(const std::string& text) {
  std::tm date{};
  const char* end = ::strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &date);
  if (end == nullptr || *end != '\0') return std::nullopt;
  const std::time_t seconds = ::timegm(&date);
  if (seconds < 0) return std::nullopt;
  return std::chrono::seconds(seconds);
}

/// Writes messages of ROS 2 into a bag's file.
class BagWriter {
 public:
  explicit BagWriter(std::unique_ptr<telemetry::ByteSink> sink) : writer_(std::move(sink)) {}

  hal::Result<> begin() { return writer_.begin("ros2", "colift " + telemetry::program_version()); }

  /// Announces a topic; returns its index. Errors: NotFound (a message without a definition).
  hal::Result<std::size_t> add(const char* topic, const dds_topic_descriptor_t& type, Qos qos) {
    const std::string name = ros2_type(type.m_typename);
    auto text = message_definition(name);
    if (!text) return tl::unexpected(text.error());
    const auto id = static_cast<std::uint16_t>(topics_.size() + 1);
    auto schema =
        std::find_if(schemas_.begin(), schemas_.end(), [&](const auto& s) { return s.second.name == name; });
    if (schema == schemas_.end())
      schema = schemas_.insert({id, {id, name, "ros2msg", std::move(*text)}}).first;
    channels_[id] = {id, schema->first, topic, "cdr", {{"offered_qos_profiles", offered_qos(qos)}}};
    topics_.push_back({topic, name, qos, 0});
    return topics_.size() - 1;
  }

  hal::Result<> write(std::size_t topic, hal::Timestamp at, std::string_view cdr) {
    BagTopic& t = topics_[topic];
    const telemetry::Channel& channel = channels_.at(static_cast<std::uint16_t>(topic + 1));
    const std::uint64_t time = nanoseconds(at);
    builder_.add(&schemas_.at(channel.schema_id), channel,
                 {channel.id, static_cast<std::uint32_t>(++t.messages), time, time, cdr});
    start_ns_ = std::min(start_ns_, time), end_ns_ = std::max(end_ns_, time);
    return builder_.size() >= kChunkBytes ? close() : hal::Result<>();
  }

  hal::Result<> finish() {
    if (auto done = close(); !done) return done;
    return writer_.finish();
  }

  [[nodiscard]] std::string metadata() const {
    std::vector<BagTopic> used = topics_;
    std::erase_if(used, [](const BagTopic& t) { return t.messages == 0; });
    return bag_metadata(kBagFile, std::min(start_ns_, end_ns_), end_ns_, used);
  }

 private:
  hal::Result<> close() {
    if (builder_.empty()) return {};
    return writer_.add(builder_.close(), schemas_, channels_);
  }

  telemetry::McapWriter writer_;
  telemetry::ChunkBuilder builder_;
  std::vector<BagTopic> topics_;
  std::map<std::uint16_t, telemetry::Schema> schemas_;
  std::map<std::uint16_t, telemetry::Channel> channels_;
  std::uint64_t start_ns_ = UINT64_MAX, end_ns_ = 0;
};

/// One export: the recording's messages in the order of the file.
class Converter {
 public:
  Converter(const McapReader& file, BagWriter& bag) : file_(file), bag_(bag) {}

  hal::Result<> run(telemetry::Exported& out) {
    if (auto done = announce(); !done) return done;
    find_date(out);
    auto cursor = file_.messages(wanted_);
    while (const auto message = cursor.next()) {
      const auto topic = topics_.find(message->channel_id);
      if (topic == topics_.end()) continue;
      if (auto done = convert(topic->second, *message); !done) return done;
    }
    add_notes(out);
    if (converted_ == 0)
      return hal::failure(hal::ErrorCode::BadInput, "export",
                          "the recording has no message for a topic of ROS 2");
    return described_ ? hal::Result<>() : write_robot();
  }

 private:
  hal::Result<> announce() {
    std::map<std::string, Topic> by_name;
    for (std::size_t i = 0; i < outlets_.size(); ++i) {
      const Outlet& o = outlets_[i];
      by_name[telemetry::channel_of(o.channel).topic] = o.channel;
      if (const std::size_t first = first_of_topic(outlets_, i); first < i) {
        bag_topics_.push_back(bag_topics_[first]);
        continue;
      }
      const auto topic = bag_.add(o.topic, *o.type, o.qos);
      if (!topic) return tl::unexpected(topic.error());
      bag_topics_.push_back(*topic);
      if (o.channel == Topic::Description) robot_ = *topic;
    }
    for (const auto& [id, channel] : file_.info().channels) {
      const auto known = by_name.find(channel.topic);
      if (known == by_name.end()) {
        without_.push_back(channel.topic);
        continue;
      }
      topics_[id] = known->second;
      wanted_.insert(channel.topic);
    }
    return {};
  }

  void find_date(telemetry::Exported& out) {
    const auto run = file_.metadata("colift.run");
    const auto started =
        run ? run->entries.find("started") : std::map<std::string, std::string>::const_iterator();
    const auto date = run && started != run->entries.end() ? date_of(started->second) : std::nullopt;
    begins_ = time_in(file_.info().statistics.start_time);
    if (date)
      to_ros_ = *date - begins_;
    else
      out.notes.emplace_back("the recording has no date: the bag begins in 1970, as the robot's clock does");
  }

  /// Older recordings have the robot's model as an attachment alone. Readers go by times, not by places.
  hal::Result<> write_robot() {
    const auto urdf = file_.attachment("robot.urdf");
    hal::dds::Sample<std_msgs_msg_dds__String_> message(std_msgs_msg_dds__String__desc);
    hal::dds::set(message->data, urdf ? urdf->data : telemetry::built_in_robot_urdf());
    return bag_.write(robot_, begins_ + to_ros_, to_cdr(std_msgs_msg_dds__String__desc, &*message));
  }

  hal::Result<> convert(Topic topic, const telemetry::Message& message) {
    const std::string bytes(message.data);
    const hal::Timestamp at = time_in(message.log_time);
    for (std::size_t i = 0; i < outlets_.size(); ++i) {
      const Outlet& o = outlets_[i];
      if (o.channel != topic) continue;
      hal::Result<> written;
      try {
        if (topic == Topic::Transforms && o.qos == Qos::Latched && camera_.repeats(bytes)) continue;
        const bool said = o.convert({bytes, at, to_ros_}, [&](const void* sample) {
          written = bag_.write(bag_topics_[i], at + to_ros_, to_cdr(*o.type, sample));
        });
        if (said) ++converted_;
        described_ = described_ || (said && topic == Topic::Description);
        // of what is in CDR already, "nothing to say" is one that cannot be read
        if (!said && (topic == Topic::Depth || topic == Topic::Description)) ++failed_;
      } catch (const Json::exception&) {
        ++failed_;
      }
      if (!written) return written;
    }
    return {};
  }

  void add_notes(telemetry::Exported& out) const {
    if (failed_ > 0) out.notes.push_back(fmt::format("{} messages could not be converted", failed_));
    if (!without_.empty())
      out.notes.push_back(
          fmt::format("without a message of ROS 2, so left out: {}", fmt::join(without_, ", ")));
  }

  const McapReader& file_;
  BagWriter& bag_;
  std::vector<Outlet> outlets_ = outlets();
  std::vector<std::size_t> bag_topics_;    ///< Of each outlet.
  std::size_t robot_ = 0;                  ///< Its description's topic in the bag.
  bool described_ = false;                 ///< The recording itself has said it.
  std::map<std::uint16_t, Topic> topics_;  ///< Of the recording's channels.
  std::set<std::string> wanted_;
  std::vector<std::string> without_;
  CameraTransform camera_;
  hal::Timestamp begins_{0};
  hal::Duration to_ros_{0};
  std::uint64_t converted_ = 0, failed_ = 0;
};

}  // namespace

hal::Result<telemetry::Exported> export_ros2(const McapReader& file, const std::filesystem::path& folder) {
  if (auto made = telemetry::make_folder(folder); !made) return tl::unexpected(made.error());
  telemetry::Exported out;
  const std::filesystem::path to = folder / kBagFile;
  const auto write = [&]() -> hal::Result<std::string> {
    auto sink = telemetry::create_file(to);
    if (!sink) return tl::unexpected(sink.error());
    BagWriter bag(std::move(*sink));
    if (auto done = bag.begin(); !done) return tl::unexpected(done.error());
    if (auto done = Converter(file, bag).run(out); !done) return tl::unexpected(done.error());
    if (auto done = bag.finish(); !done) return tl::unexpected(done.error());
    return bag.metadata();
  };
  auto metadata = write();
  if (metadata)
    if (auto done = telemetry::write_whole(folder / "metadata.yaml", *metadata); !done)
      metadata = tl::unexpected(done.error());
  if (!metadata) {
    // half a bag would look like a whole one
    std::error_code ignored;
    std::filesystem::remove(to, ignored);
    return tl::unexpected(metadata.error());
  }
  out.files = {to, folder / "metadata.yaml"};
  out.count = out.files.size();
  return out;
}

}  // namespace colift::ros2
