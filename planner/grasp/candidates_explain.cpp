#include <fmt/format.h>

#include <algorithm>
#include <limits>
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
      return "would slip or tip";
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

std::vector<Refusals> refusals(const std::vector<GraspCandidate>& candidates) {
  const auto miss = [](const GraspCandidate& c) {
    return c.miss_m.value_or(std::numeric_limits<double>::infinity());
  };
  std::map<std::string, Refusals> of_group;
  for (const GraspCandidate& c : candidates) {
    if (c.verdict == Verdict::Ok || c.verdict == Verdict::Chosen) continue;
    Refusals& group = of_group[group_of(c)];
    if (group.count++ == 0 || miss(c) < miss(*group.nearest)) group.nearest = &c;
  }
  std::vector<Refusals> out;
  for (auto& [why, group] : of_group) {
    group.why = why;
    out.push_back(std::move(group));
  }
  // names break ties, so the sentence is the same every time
  std::stable_sort(out.begin(), out.end(),
                   [](const Refusals& a, const Refusals& b) { return a.count > b.count; });
  return out;
}

std::string explain(const std::vector<GraspCandidate>& candidates) {
  if (candidates.empty())
    return "0 candidates: no surface of the object is narrow enough, and no rim or cylinder was seen";
  std::size_t free = 0;
  const GraspCandidate* nearest = nullptr;
  const GraspCandidate* firmest = nullptr;
  for (const GraspCandidate& c : candidates) {
    if (c.verdict == Verdict::Ok || c.verdict == Verdict::Chosen) {
      ++free;
      continue;
    }
    if (c.miss_m && (nearest == nullptr || *c.miss_m < *nearest->miss_m)) nearest = &c;
    if (c.verdict == Verdict::Unstable && c.stability &&
        (firmest == nullptr || *c.stability > *firmest->stability)) {
      firmest = &c;
    }
  }
  std::string text = fmt::format("{} of {} candidates are free", free, candidates.size());
  const char* separator = ": ";
  for (const Refusals& group : refusals(candidates)) {
    text += fmt::format("{}{} {}", separator, group.count, group.why);
    separator = ", ";
  }
  if (free > 0) return text;
  // a grip that only slips is nearer to a grasp than one that collides
  const GraspCandidate* miss = firmest != nullptr ? firmest : nearest;
  if (miss != nullptr) text += fmt::format("; nearest miss: candidate {}, {}", miss->id, miss->reason);
  return text;
}

}  // namespace colift::planner
