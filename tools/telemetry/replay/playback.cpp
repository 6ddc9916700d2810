#include "tools/telemetry/replay/playback.hpp"

#include <algorithm>
#include <limits>
#include <string>
#include <utility>

namespace colift::telemetry {
namespace {

std::set<std::string> names_of(const std::set<Topic>& topics) {
  std::set<std::string> names;
  for (const Topic topic : topics) names.insert(channel_of(topic).topic);
  return names;
}

hal::Timestamp time_of(const Message& message) {
  // a damaged file may say anything
  constexpr auto kMost = static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return hal::Timestamp(static_cast<std::int64_t>(std::min(message.log_time, kMost)));
}

}  // namespace

Playback::Playback(const McapReader& file, const std::set<Topic>& topics, std::vector<TelemetrySink*> sinks)
    : cursor_(file.messages(names_of(topics))), sinks_(std::move(sinks)) {
  for (const Topic topic : topics) {
    const ChannelInfo& ours = channel_of(topic);
    for (const auto& [id, channel] : file.info().channels)
      if (channel.topic == ours.topic && channel.message_encoding == ours.encoding) topics_[id] = topic;
  }
}

bool Playback::find_next() {
  while (!next_ && !ended_) {
    next_ = cursor_.next();
    if (!next_)
      ended_ = true;
    else if (topics_.count(next_->channel_id) == 0)
      next_.reset();
  }
  return next_.has_value();
}

std::optional<hal::Timestamp> Playback::next_at() {
  if (!find_next()) return std::nullopt;
  return time_of(*next_);
}

void Playback::play(hal::Timestamp until) {
  while (find_next() && time_of(*next_) <= until) {
    const std::string text(next_->data);
    const Publication publication{topics_.at(next_->channel_id), time_of(*next_), [text] { return text; },
                                  text.size()};
    next_.reset();
    for (TelemetrySink* sink : sinks_) sink->publish(publication);
  }
}

}  // namespace colift::telemetry
