#include "tools/telemetry/replay/page_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <optional>
#include <set>

#include "tools/telemetry/replay/playback.hpp"

namespace colift::telemetry {
namespace {

using namespace std::chrono_literals;

/// At most one message in this time; 0: every one.
hal::Duration interval_of(Topic topic) {
  switch (topic) {
    case Topic::Joints:
      return 40ms;
    case Topic::Load:
      return 60ms;
    case Topic::Transforms:
    case Topic::Status:
    case Topic::Tactile:
    case Topic::Bodies:
      return 100ms;
    case Topic::Calibration:
    case Topic::Preview:
    case Topic::Devices:
    case Topic::Timing:
      return 1s;
    case Topic::Cloud:
      return 2s;
    default:
      return 0ms;
  }
}

/// What a page draws; the simulation's truth is none of its business.
std::set<Topic> topics_of_a_page() {
  std::set<Topic> topics;
  for (const ChannelInfo& channel : channels())
    if (channel.encoding == "json" && channel.id < Topic::Depth && channel.id != Topic::Truth)
      topics.insert(channel.id);
  return topics;
}

/// Writes lines while they fit, and counts what all of them would need.
class Lines final : public TelemetrySink {
 public:
  Lines(std::size_t largest, int thinning, std::string& out)
      : largest_(largest), thinning_(thinning), out_(out) {}

  void publish(const Publication& publication) override {
    auto& last = last_[static_cast<std::size_t>(publication.topic)];
    const hal::Duration interval = thinning_ * interval_of(publication.topic);
    const bool goes_on = last && publication.at >= *last;
    if (goes_on && publication.at - *last < interval) return;
    last = publication.at;
    const std::string text = publication.encode();
    if (text.empty() || text.find('\n') != std::string::npos) return;  // no message of ours
    const std::string head = fmt::format("{} {} ", channel_of(publication.topic).topic,
                                         std::max<std::int64_t>(0, publication.at.count()));
    bytes_ += head.size() + text.size() + 1;
    if (bytes_ > largest_) return;
    out_ += head;
    out_ += text;
    out_ += '\n';
  }

  [[nodiscard]] std::size_t bytes() const { return bytes_; }

 private:
  const std::size_t largest_;
  const int thinning_;
  std::string& out_;
  std::size_t bytes_ = 0;
  std::array<std::optional<hal::Timestamp>, kTopics> last_{};
};

std::size_t pass(const McapReader& file, std::size_t largest, int thinning, std::string& out) {
  Lines lines(largest, thinning, out);
  Playback playback(file, topics_of_a_page(), {&lines});
  while (const auto at = playback.next_at()) playback.play(*at);
  return lines.bytes();
}

}  // namespace

std::string page_recording(const McapReader& file, std::size_t largest) {
  constexpr int kThinnest = 4096;
  std::string out;
  std::size_t bytes = pass(file, largest, 1, out);
  for (int thinning = 2; bytes > largest && thinning <= kThinnest; thinning *= 2) {
    // as much as is needed, guessed from what there was; the last guess is taken as it is
    while (thinning < kThinnest && bytes / static_cast<std::size_t>(thinning) > largest) thinning *= 2;
    out.clear();
    bytes = pass(file, largest, thinning, out);
  }
  return out;
}

}  // namespace colift::telemetry
