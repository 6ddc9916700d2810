#include "planner/motion/transit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "planner/motion/escape.hpp"
#include "planner/motion/rrt_connect.hpp"
#include "planner/motion/shortcut.hpp"
#include "planner/motion/trajectory/timing.hpp"

namespace colift::planner {
namespace {

using hal::ErrorCode;
using hal::JointVector;

/// Joint positions that a search draws per second on the machine of docs/benchmarks.md: plan_s in work.
constexpr double kSamplesPerSecond = 100000.0;

hal::Result<FoundPath> search(TransitTools& tools, const FreeSpace& space, const JointBox& box,
                              const JointVector& from, std::span<const JointVector> goals,
                              std::uint64_t seed) {
  std::vector<JointVector> free_goals;
  std::vector<std::size_t> index;
  for (std::size_t i = 0; i < goals.size(); ++i) {
    if (space.edge(from, goals[i])) return FoundPath{{from, goals[i]}, i};
    if (!space.state(goals[i])) continue;
    free_goals.push_back(goals[i]);
    index.push_back(i);
  }
  if (free_goals.empty()) {
    return hal::failure(ErrorCode::NotFound, "goal",
                        fmt::format("{} at the goal", tools.checkers.fast.what_touches(goals[0]).text()));
  }
  const SearchBudget budget{
      std::max<std::size_t>(1, static_cast<std::size_t>(tools.config.planning_budget_s * kSamplesPerSecond)),
      tools.config.search.max_edge_rad};
  std::size_t used = 0;
  auto found = rrt_connect(space, box, from, free_goals, budget, seed, used);
  if (!found) {
    return hal::failure(
        ErrorCode::NotFound, "transit",
        fmt::format("no collision-free path to any of {} goal configurations was found with {} "
                    "random joint positions",
                    free_goals.size(), used));
  }
  found->goal = index[found->goal];
  return *std::move(found);
}

/// Whether a trajectory is free by the fast checker; around the start, where it had to leave something that
/// is too near, the exact one decides later.
bool fast_free(const Trajectory& trajectory, FastChecker& fast, double step_rad, const Departure& departure,
               double blend_rad) {
  const JointPath states = sampled(trajectory, step_rad);
  const double excused = departure.reach_rad > 0.0 ? departure.reach_rad + blend_rad : -1.0;
  for (std::size_t i = 1; i < states.size(); ++i) {
    if (joint_distance(states[i - 1], trajectory.start()) <= excused) continue;
    if (!fast.is_free(states[i - 1], states[i], step_rad)) return false;
  }
  return true;
}

}  // namespace

std::string exact_contact(const Trajectory& trajectory, ExactChecker& exact, double step_rad) {
  for (const JointVector& q : sampled(trajectory, step_rad)) {
    if (const Touch touch = exact.what_touches(q); touch.with != Touch::With::Nothing) return touch.text();
  }
  return {};
}

hal::Result<Transit> find_transit(TransitTools tools, const JointBox& limits_box, const JointVector& start,
                                  std::span<const JointVector> goals, std::uint64_t seed, PlanTimes& times) {
  FastChecker& fast = tools.checkers.fast;
  ExactChecker& exact = tools.checkers.exact;
  const PlannerConfig& config = tools.config;
  fast.allow(Contacts::None);
  exact.allow(Contacts::None);
  const JointBox box = limits_box.with(start);
  auto departure = depart(start, fast, exact, box, config.exact_step_rad, seed, config.search.escape);
  if (!departure) return hal::failure(ErrorCode::NotFound, "start", departure.error());

  hal::Error last{ErrorCode::NotFound, "transit", {}};
  for (int attempt = 0; attempt < config.search.attempts; ++attempt) {
    const double step_rad = config.step_rad / (1 << attempt);
    const FreeSpace space{
        [&](const JointVector& q) { return fast.is_free(q); },
        [&](const JointVector& a, const JointVector& b) { return fast.is_free(a, b, step_rad); }};
    const std::uint64_t round_seed = seed + 0x9e3779b97f4a7c15ULL * static_cast<std::uint64_t>(attempt);
    Transit out;
    out.note = departure->note;
    {
      const Timed timed(tools.clock, times.plan_ms);
      auto found = search(tools, space, box, departure->path.back(), goals, round_seed);
      if (!found) return tl::unexpected(last.detail.empty() ? found.error() : last);
      out.goal = found->goal;
      out.way_points = std::move(found->path);
    }
    {
      const Timed timed(tools.clock, times.shortcut_ms);
      out.way_points = shortcut(std::move(out.way_points), space, round_seed, config.search.shortcut);
      if (departure->path.size() > 1) out.way_points.insert(out.way_points.begin(), start);
    }
    {
      const Timed timed(tools.clock, times.trajectory_ms);
      bool free = false;
      // rounded as configured, less, not at all
      for (const double part : {1.0, 0.4, 0.0}) {
        out.blend_rad = part * config.blend_rad;
        auto made = make_slow_trajectory(tools.model, out.way_points, tools.limits, out.blend_rad,
                                         config.transit_speed_m_s);
        if (!made) return hal::failure(ErrorCode::NotFound, "transit", made.error().detail);
        out.trajectory = *std::move(made);
        free = fast_free(out.trajectory, fast, std::min(step_rad, config.exact_step_rad), *departure,
                         out.blend_rad);
        if (free || out.way_points.size() < 3) break;
      }
      if (!free) {
        last = {ErrorCode::NotFound, "transit",
                "the path is in collision between the states that were checked"};
        continue;
      }
    }
    const Timed timed(tools.clock, times.exact_ms);
    const std::string contact = exact_contact(out.trajectory, exact, config.exact_step_rad);
    if (contact.empty()) return out;
    last = {ErrorCode::NotFound, "exact check", fmt::format("in transit {}", contact)};
  }
  return tl::unexpected(last);
}

}  // namespace colift::planner
