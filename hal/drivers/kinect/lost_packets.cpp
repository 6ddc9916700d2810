#include "hal/drivers/kinect/lost_packets.hpp"

#include <algorithm>
#include <charconv>

#include "hal/drivers/kinect/kinect_facts.hpp"

namespace colift::hal::kinect {
namespace {

constexpr std::size_t kPacketBits = 1748UL * 8, kPixelBits = 11;
constexpr std::ptrdiff_t kMinSeen = 200;  // of 1271 pixels
constexpr int kTooMany = 6;

}  // namespace

std::optional<int> lost_packets(std::string_view line) {
  // both streams' complaints look alike; the depth's is stream 70
  if (line.find("[Stream 70]") == std::string_view::npos) return std::nullopt;
  if (line.find("Lost too many packets") != std::string_view::npos) return kTooMany;
  constexpr std::string_view kLost = "Lost ";
  const std::size_t at = line.find(kLost);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view rest = line.substr(at + kLost.size());
  int n = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), n);
  const std::string_view after = rest.substr(static_cast<std::size_t>(end - rest.data()));
  if (error != std::errc{} || n <= 0 || !after.starts_with(" packets")) return std::nullopt;
  return n;
}

int stale_runs(std::span<const std::uint16_t> frame, std::span<const std::uint16_t> before) {
  if (frame.size() != before.size()) return 0;
  int same = 0, counted = 0;
  for (std::size_t run = 0;; ++run) {
    // a pixel that is cut by the packet's end belongs to neither
    const std::size_t from = (run * kPacketBits + kPixelBits - 1) / kPixelBits;
    const std::size_t to = std::min((run + 1) * kPacketBits / kPixelBits, frame.size());
    if (from >= to) break;
    const auto piece = frame.subspan(from, to - from);
    const auto seen =
        static_cast<std::ptrdiff_t>(piece.size()) - std::count(piece.begin(), piece.end(), kNoDepth);
    if (seen < kMinSeen) continue;
    ++counted;
    same += std::equal(piece.begin(), piece.end(), before.begin() + static_cast<std::ptrdiff_t>(from));
  }
  return 2 * same < counted ? same : 0;
}

}  // namespace colift::hal::kinect
