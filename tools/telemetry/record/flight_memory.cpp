#include "tools/telemetry/record/flight_memory.hpp"

#include <algorithm>
#include <utility>

namespace colift::telemetry {
namespace {

constexpr std::size_t kMostChanges = 200;

}  // namespace

void FlightMemory::note(Topic topic, std::uint32_t sequence, std::uint64_t log_time,
                        const std::string& payload) {
  if (is_lasting(topic)) collecting_.push_back({topic, sequence, log_time, payload});
}

void FlightMemory::keep(std::shared_ptr<const Chunk> chunk) {
  bytes_ += chunk->records.size();
  kept_.push_back({std::move(chunk), std::exchange(collecting_, {})});
  const auto span = static_cast<std::uint64_t>(1e9 * seconds_);
  while (kept_.size() > 1 &&
         (bytes_ > most_bytes_ || kept_[1].chunk->start_time + span < kept_.back().chunk->end_time))
    forget_oldest();
}

void FlightMemory::forget_oldest() {
  bytes_ -= kept_.front().chunk->records.size();
  for (Said& said : kept_.front().seldom) {
    if (said.topic != Topic::Change) {
      newest_[said.topic] = std::move(said);
      continue;
    }
    changes_.push_back(std::move(said));
    if (changes_.size() > kMostChanges) changes_.pop_front();
  }
  kept_.pop_front();
}

std::vector<std::shared_ptr<const Chunk>> FlightMemory::chunks() const {
  std::vector<std::shared_ptr<const Chunk>> all;
  for (const Kept& kept : kept_) all.push_back(kept.chunk);
  return all;
}

void FlightMemory::before(const std::function<void(Topic, std::uint32_t, const std::string&)>& visit) const {
  std::vector<const Said*> all;
  for (const Said& said : changes_) all.push_back(&said);
  for (const auto& [topic, said] : newest_) all.push_back(&said);
  std::stable_sort(all.begin(), all.end(),
                   [](const Said* a, const Said* b) { return a->log_time < b->log_time; });
  for (const Said* said : all) visit(said->topic, said->sequence, said->payload);
}

}  // namespace colift::telemetry
