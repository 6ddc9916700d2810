#include "tools/live/board.hpp"

#include <algorithm>
#include <utility>

namespace colift::live {

using telemetry::Topic;

namespace {

constexpr int kControl = -1, kTime = -2;  // in place of a topic

}  // namespace

TopicRule rule_of(Topic topic) {
  switch (topic) {
    case Topic::Log:
      return {300, true};
    case Topic::Change:
      return {100, true};
    case Topic::Load:
      return {1800, false};  // a minute of curve
    case Topic::Tracked:
      return {0, false};  // who comes late would draw what is no longer seen
    default:
      return {};
  }
}

const std::string& Post::text() {
  if (!text_) {
    text_ = std::make_shared<const std::string>(publication_.encode ? publication_.encode() : std::string());
    publication_.encode = nullptr;  // with it go the copies that it held
  }
  return *text_;
}

std::shared_ptr<Post> Board::put(telemetry::Publication publication) {
  const auto index = static_cast<std::size_t>(publication.topic);
  if (index >= kLiveTopics) return nullptr;
  const TopicRule rule = rule_of(publication.topic);
  auto post = std::make_shared<Post>(std::move(publication));
  if (rule.history > 1)
    static_cast<void>(post->text());  // a long history must not hold what they were made of
  auto& kept = history_[index];
  kept.push_back(post);
  if (kept.size() > rule.history) kept.pop_front();
  return post;
}

void Outbox::push_control(std::string message, bool binary) {
  items_.push_back({std::move(message), binary, kControl});
  ++control_;
}

void Outbox::push_time(std::string message) {
  const auto waits =
      std::find_if(items_.begin(), items_.end(), [](const Item& i) { return i.topic == kTime; });
  if (waits == items_.end())
    items_.push_back({std::move(message), true, kTime});
  else
    waits->message = std::move(message);
}

void Outbox::push(Topic topic, std::string message) {
  const auto index = static_cast<std::size_t>(topic);
  if (index >= kLiveTopics) return;
  const auto of_topic = [&](const Item& item) { return item.topic == static_cast<int>(index); };
  const TopicRule rule = rule_of(topic);
  if (waiting_[index] > 0 && rule.history <= 1 && !rule.every) {
    // the newest takes the place of the one that waits: a slow client sees fewer pictures, not older ones
    std::find_if(items_.begin(), items_.end(), of_topic)->message = std::move(message);
    ++dropped_;
    return;
  }
  // enough for a history that is sent at once, and then the oldest goes
  if (waiting_[index] >= std::max(kMostOfATopic, rule.history)) {
    items_.erase(std::find_if(items_.begin(), items_.end(), of_topic));
    --waiting_[index];
    ++dropped_;
  }
  items_.push_back({std::move(message), true, static_cast<int>(index)});
  ++waiting_[index];
}

Outbox::Item Outbox::take() {
  Item item = std::move(items_.front());
  items_.pop_front();
  if (item.topic == kControl)
    --control_;
  else if (item.topic >= 0)
    --waiting_[static_cast<std::size_t>(item.topic)];
  return item;
}

}  // namespace colift::live
