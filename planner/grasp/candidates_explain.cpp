#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

#include "planner/grasp/grasp_candidates.hpp"

namespace colift::planner {
namespace {

/// What a collision is with. Which finger it is says the candidate's own reason; here it would only make the
/// list long.
std::string obstacle_of(const std::string& reason) {
  const auto speaks_of = [&](const char* words) { return reason.find(words) != std::string::npos; };
  if (speaks_of("unobserved space")) return "would move through unobserved space";
  if (speaks_of("the ground")) return "would meet the ground";
  if (speaks_of("beside the object")) return "would meet something beside the object";
  if (speaks_of("the object")) return "would meet the object";
  return "would collide";
}

/// What a refusal is counted under.
std::string group_of(const GraspCandidate& c) {
  switch (c.verdict) {
    case Verdict::TooWide:
      return "too wide for the hand";
    case Verdict::Unstable:
      return "the grip would slip";
    case Verdict::Unreachable:
      return "out of the arm's reach";
    case Verdict::OverLimit:
      return "over a force or torque limit";
    case Verdict::NearPartner:
      return "too near the partner";
    case Verdict::Collision:
      return obstacle_of(c.reason);
    case Verdict::Ok:
    case Verdict::Chosen:
      break;
  }
  return "";
}

}  // namespace

std::string explain(const std::vector<GraspCandidate>& candidates) {
  if (candidates.empty())
    return "0 candidates: no surface of the object is narrow enough, and no rim or cylinder was seen";
  std::size_t free = 0;
  std::map<std::string, int> fallen;
  const GraspCandidate* nearest = nullptr;
  const GraspCandidate* firmest = nullptr;
  for (const GraspCandidate& c : candidates) {
    if (c.verdict == Verdict::Ok || c.verdict == Verdict::Chosen) {
      ++free;
      continue;
    }
    ++fallen[group_of(c)];
    if (c.miss_m && (nearest == nullptr || *c.miss_m < *nearest->miss_m)) nearest = &c;
    if (c.verdict == Verdict::Unstable && c.stability &&
        (firmest == nullptr || *c.stability > *firmest->stability)) {
      firmest = &c;
    }
  }
  std::string text = fmt::format("{} of {} candidates are free", free, candidates.size());
  if (fallen.empty()) return text;

  // most frequent first; names break ties, so the sentence is the same every time
  std::vector<std::pair<int, std::string>> groups;
  for (const auto& [group, count] : fallen) groups.emplace_back(-count, group);
  std::sort(groups.begin(), groups.end());
  const char* separator = ": ";
  for (const auto& [count, group] : groups) {
    text += fmt::format("{}{} {}", separator, -count, group);
    separator = ", ";
  }
  if (free > 0) return text;
  // a grip that only slips is nearer to a grasp than one that collides
  const GraspCandidate* miss = firmest != nullptr ? firmest : nearest;
  if (miss != nullptr) text += fmt::format("; nearest miss: candidate {}, {}", miss->id, miss->reason);
  return text;
}

}  // namespace colift::planner
