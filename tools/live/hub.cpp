#include "tools/live/hub.hpp"

namespace colift::live {
namespace {

constexpr hal::Duration kTimeEvery = std::chrono::milliseconds(30);

}  // namespace

bool Hub::hand_in(const telemetry::Publication& publication) {
  ++published;
  if (static_cast<std::size_t>(publication.topic) >= kLiveTopics) return false;
  const std::lock_guard lock(waiting_mutex_);
  if (waiting_.size() >= kMostWaiting) {
    // the server's thread has not had the processor for long; the newest is worth more than the oldest
    waiting_.erase(waiting_.begin(), waiting_.begin() + kMostWaiting / 2);
    dropped += kMostWaiting / 2;
  }
  waiting_.push_back(publication);
  return waiting_.size() == 1;
}

void Hub::pass_on() {
  {
    const std::lock_guard lock(waiting_mutex_);
    taken_.swap(waiting_);
  }
  for (const auto& publication : taken_) now_ = publication.at;
  if (now_ && (!published_ || *now_ < *published_ || *now_ - *published_ >= kTimeEvery)) {
    published_ = now_;
    for (Listener* listener : listeners_) listener->tell_time(*now_);
  }
  for (auto& publication : taken_)
    if (const auto post = board_.put(std::move(publication)))
      for (Listener* listener : listeners_) listener->deliver(*post);
  taken_.clear();
}

}  // namespace colift::live
