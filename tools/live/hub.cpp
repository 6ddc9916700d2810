#include "tools/live/hub.hpp"

#include <algorithm>

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
    const auto half = waiting_.begin() + kMostWaiting / 2;
    auto kept = std::stable_partition(waiting_.begin(), half,
                                      [](const auto& p) { return telemetry::is_lasting(p.topic); });
    if (kept == half) kept = waiting_.begin();
    dropped += static_cast<std::uint64_t>(half - kept);
    waiting_.erase(kept, half);
  }
  waiting_.push_back(publication);
  return waiting_.size() == 1;
}

void Hub::call(Caller* caller) {
  if (callers_.size() >= config_.most_callers && !callers_.empty()) {
    Caller* idle = callers_.front();
    callers_.erase(callers_.begin());
    ++turned_away;
    idle->turn_out();
  }
  callers_.push_back(caller);
}

void Hub::renew(Caller* caller) {
  const auto found = std::find(callers_.begin(), callers_.end(), caller);
  if (found != callers_.end()) std::rotate(found, found + 1, callers_.end());
}

void Hub::hang_up(Caller* caller) {
  std::erase(callers_, caller);
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
