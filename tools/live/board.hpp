#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>

#include "tools/telemetry/channels/channels.hpp"

namespace colift::live {

/// Topics that are shown live; the rest is for recordings.
inline constexpr std::size_t kLiveTopics = static_cast<std::size_t>(telemetry::Topic::Depth);

/// What a client needs of the past, and what a slow one may miss.
struct TopicRule {
  std::size_t history = 1;  ///< How many messages somebody gets who comes late.
  bool every = false;       ///< Each one matters; else a newer one replaces one that still waits.
};
[[nodiscard]] TopicRule rule_of(telemetry::Topic topic);

/// One message; its text is made when the first client wants it, and once for all of them.
class Post {
 public:
  explicit Post(telemetry::Publication publication) : publication_(std::move(publication)) {}
  [[nodiscard]] telemetry::Topic topic() const { return publication_.topic; }
  [[nodiscard]] hal::Timestamp at() const { return publication_.at; }
  [[nodiscard]] const std::string& text();

 private:
  telemetry::Publication publication_;
  std::shared_ptr<const std::string> text_;
};

/// The newest messages of every live topic. For one thread.
class Board {
 public:
  /// The post as it is kept; null for a topic that is not live.
  std::shared_ptr<Post> put(telemetry::Publication publication);
  /// Oldest first.
  [[nodiscard]] const std::deque<std::shared_ptr<Post>>& history(telemetry::Topic topic) const {
    return history_[static_cast<std::size_t>(topic)];
  }

 private:
  std::array<std::deque<std::shared_ptr<Post>>, kLiveTopics> history_;
};

/// What waits to be sent to one client. Never longer than its limits, however slow the client is.
class Outbox {
 public:
  /// Messages of the protocol itself.
  void push_control(std::string message, bool binary);
  /// The robot's time; one that still waits is replaced.
  void push_time(std::string message);
  /// A message of a topic. One of the same topic that still waits is replaced, unless every one of them
  /// matters.
  void push(telemetry::Topic topic, std::string message);

  struct Item {
    std::string message;
    bool binary = true;
    int topic = -1;  ///< -1: control; -2: time.
  };
  [[nodiscard]] bool empty() const { return items_.empty(); }
  /// The oldest, which leaves.
  [[nodiscard]] Item take();
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
  /// So many control messages wait that nobody can be reading.
  [[nodiscard]] bool hopeless() const { return control_ > kMostControl; }

 private:
  static constexpr std::size_t kMostOfATopic = 400, kMostControl = 200;

  std::deque<Item> items_;
  std::array<std::size_t, kLiveTopics> waiting_{};
  std::size_t control_ = 0;
  std::uint64_t dropped_ = 0;
};

}  // namespace colift::live
