// Paths of the arm around tables, boxes and walls: CoLift's search with shortcuts against stock OMPL with FCL
// on OctoMap, on the same joint positions in the same collision worlds. Every path is checked by the exact
// checker.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "../unit/planner/motion/planning_world.hpp"
#include "bench_timing.hpp"
#include "planner/motion/joint_random.hpp"
#include "planner/motion/reach.hpp"
#include "planner/motion/trajectory/timing.hpp"
#include "planner/motion/transit.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "stock_planning.hpp"

namespace colift::bench {
namespace {

using hal::JointVector;
using hal::Vec3;
using planner::GraspCandidate;
using sim_hal::Label;
using tests::TableAt;

constexpr int kProblemsEach = 10;
constexpr int kMinProblems = 100;  // in all
constexpr int kStraightEach = 2;   // of these, at most, that a straight line solves
constexpr double kLimitS = 20.0;   // of a problem, all tries together
constexpr int kTries = 3;          // as many as find_transit() has, each at half the step of the one before

class ThreadClock final : public hal::Clock {
 public:
  [[nodiscard]] hal::Timestamp now() const override {
    return std::chrono::duration_cast<hal::Timestamp>(std::chrono::duration<double, std::milli>(cpu_ms()));
  }
};

/// A world and grasps in it that are worth going to.
struct Setting {
  std::string kind;
  sim_hal::World world;
  std::vector<GraspCandidate> grasps;
};

void add_clutter(sim_hal::World& world, sim_hal::Draws& draws, int pieces) {
  for (int i = 0; i < pieces; ++i) {
    const double turn = draws.between(-1.3, 1.3), away = draws.between(0.45, 0.7);
    const Vec3 size(draws.between(0.06, 0.15), draws.between(0.06, 0.15), draws.between(0.2, 0.6));
    world.shapes.push_back(sim_hal::box({away * std::cos(turn), away * std::sin(turn), 0.5 * size.z()}, size,
                                        draws.between(0.0, 1.5), Label::Clutter));
  }
}

Setting table(std::uint64_t seed, bool clutter) {
  sim_hal::Draws draws(seed, 1);
  Setting s{clutter ? "table, clutter" : "table", {}, {}};
  tests::add_floor(s.world);
  TableAt t;
  t.x = draws.between(0.85, 1.0);
  t.y = draws.between(-0.15, 0.15);
  t.yaw_rad = draws.between(-0.5, 0.5);
  t.size.z() = draws.between(0.4, 0.7);
  tests::add_table(s.world, t);
  if (clutter) add_clutter(s.world, draws, 3);
  for (const double side : {0.5, 1.0, 1.5}) {
    for (double along = -0.3; along < 0.31; along += 0.1) {
      s.grasps.push_back(tests::plate_grasp(t, side * std::numbers::pi, along));
    }
  }
  return s;
}

/// A bar under the top of a table that is an obstacle: the hand goes in between top, legs and floor.
Setting under_a_top(std::uint64_t seed) {
  sim_hal::Draws draws(seed, 2);
  Setting s{"under a top", {}, {}};
  tests::add_floor(s.world);
  TableAt t;
  t.label = Label::Clutter;
  t.x = draws.between(0.72, 0.82);
  t.size = {0.5, 0.9, draws.between(0.68, 0.8)};
  tests::add_table(s.world, t);
  const double z = draws.between(0.28, 0.4), x = t.x + draws.between(-0.06, 0.06);
  s.world.shapes.push_back(sim_hal::box({x, 0, z}, {0.03, 0.6, 0.03}, 0.0, Label::Target));
  for (double y = -0.25; y < 0.26; y += 0.125) {
    s.grasps.push_back(tests::grasp_at({x - 0.015, y, z}, Vec3::UnitX(), Vec3::UnitZ(), 0.03));
  }
  return s;
}

/// A post behind a gap between two walls.
Setting through_a_gap(std::uint64_t seed) {
  sim_hal::Draws draws(seed, 3);
  Setting s{"through a gap", {}, {}};
  tests::add_floor(s.world);
  const double half = draws.between(0.15, 0.2), y = draws.between(-0.1, 0.1), x = draws.between(0.42, 0.5);
  for (const double side : {-1.0, 1.0}) {
    s.world.shapes.push_back(
        sim_hal::box({x, y + side * (half + 0.3), 0.45}, {0.06, 0.6, 0.9}, 0.0, Label::Clutter));
  }
  const double post = x + draws.between(0.3, 0.36);
  s.world.shapes.push_back(sim_hal::box({post, y, 0.4}, {0.03, 0.03, 0.8}, 0.0, Label::Target));
  for (double z = 0.3; z < 0.71; z += 0.08) {
    s.grasps.push_back(tests::grasp_at({post - 0.015, y, z}, Vec3::UnitX(), Vec3::UnitY(), 0.03));
  }
  return s;
}

/// The cross bar between a table's own legs, low under its top.
Setting between_legs(std::uint64_t seed) {
  sim_hal::Draws draws(seed, 4);
  Setting s{"between legs", {}, {}};
  tests::add_floor(s.world);
  TableAt t;
  t.x = draws.between(0.85, 0.95);
  t.size = {0.4, draws.between(0.55, 0.7), draws.between(0.6, 0.75)};
  tests::add_table(s.world, t);
  const double z = draws.between(0.2, 0.35);
  s.world.shapes.push_back(sim_hal::box({t.x, 0, z}, {0.025, t.size.y() - 0.04, 0.025}, 0.0, Label::Target));
  for (double y = -0.2; y < 0.21; y += 0.1) {
    s.grasps.push_back(tests::grasp_at({t.x - 0.0125, y, z}, Vec3::UnitX(), Vec3::UnitZ(), 0.025));
  }
  for (double along = -0.2; along < 0.21; along += 0.1) {
    s.grasps.push_back(tests::plate_grasp(t, std::numbers::pi, along));
  }
  return s;
}

struct Outcome {
  double plan_ms = 0.0, shortcut_ms = 0.0, length = 0.0;
  int tries = 0;
  bool found = false, exact = false, exact_at_once = false;
  [[nodiscard]] double whole_ms() const { return plan_ms + shortcut_ms; }
};

bool exactly_free(const planner::JointPath& path, planner::ExactChecker& exact, double step_rad) {
  exact.allow(planner::Contacts::None);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double far = planner::joint_distance(path[i - 1], path[i]);
    const int steps = std::max(1, static_cast<int>(std::ceil(far / step_rad)));
    for (int k = 0; k <= steps; ++k) {
      const JointVector q = path[i - 1] + (static_cast<double>(k) / steps) * (path[i] - path[i - 1]);
      if (exact.what_touches(q).with != planner::Touch::With::Nothing) return false;
    }
  }
  return true;
}

/// Stock OMPL with the chances that CoLift gives itself: a way that the exact check refuses is searched again
/// at half the step, as often and within the same time. The exact check's own time counts for neither.
Outcome plan_with_tries(StockPlanner& stock, const JointVector& start, const JointVector& goal,
                        double resolution, planner::ExactChecker& exact, double exact_step_rad) {
  Outcome o;
  for (o.tries = 1;; ++o.tries) {
    const double left_s = kLimitS - 1e-3 * o.whole_ms();
    const auto out = stock.plan(start, goal, left_s, resolution / (1 << (o.tries - 1)));
    o.plan_ms += out.plan_ms;
    o.shortcut_ms += out.simplify_ms;
    o.found = !out.path.empty();
    o.length = planner::length_of(out.path);
    o.exact = o.found && exactly_free(out.path, exact, exact_step_rad);
    if (o.tries == 1) o.exact_at_once = o.exact;
    if (o.exact || o.tries == kTries || o.whole_ms() >= 1e3 * kLimitS) return o;
  }
}

/// What one contender did on all problems.
struct Column {
  std::string name;
  std::vector<Outcome> all;

  [[nodiscard]] std::vector<double> times() const {
    std::vector<double> out;
    for (const Outcome& o : all) out.push_back(o.whole_ms());
    return out;
  }
  [[nodiscard]] int exact() const {
    return static_cast<int>(std::count_if(all.begin(), all.end(), [](const Outcome& o) { return o.exact; }));
  }
  [[nodiscard]] int exact_at_once() const {
    return static_cast<int>(
        std::count_if(all.begin(), all.end(), [](const Outcome& o) { return o.exact_at_once; }));
  }
  [[nodiscard]] int found() const {
    return static_cast<int>(std::count_if(all.begin(), all.end(), [](const Outcome& o) { return o.found; }));
  }
};

double percentile(std::vector<double> values, double part) {
  const auto at = static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

template <class Part>
std::vector<double> part_of(const Column& column, Part part) {
  std::vector<double> out;
  for (const Outcome& o : column.all) out.push_back(part(o));
  return out;
}

/// How many times longer `other` took than `ours`, for each problem that both solved with a way that the
/// exact check lets pass.
std::vector<double> ratios(const Column& ours, const Column& other) {
  std::vector<double> out;
  for (std::size_t i = 0; i < ours.all.size(); ++i)
    if (ours.all[i].exact && other.all[i].exact)
      out.push_back(other.all[i].whole_ms() / ours.all[i].whole_ms());
  return out;
}

/// Times of judging single grasps (us).
struct ReachTimes {
  std::vector<double> reachable, refused;
};

/// How the contenders' checkers and the exact one judge the places that problems are made of.
struct Agreement {
  int places = 0, only_spheres_refuse = 0, only_stock_refuses = 0, exact_refuses_what_both_allow = 0;
};

/// Joint positions that are worth planning between: home, pre-grasps, free ones near obstacles.
planner::JointPath places(planner::GraspReach& reach, planner::Checkers& checkers, StockPlanner& stock,
                          const std::vector<GraspCandidate>& grasps, const planner::JointBox& box,
                          std::uint64_t seed, ReachTimes& times, Agreement& agreement) {
  planner::FastChecker& fast = checkers.fast;
  planner::JointPath out;
  const planner::HandModel hand;
  for (const GraspCandidate& grasp : grasps) {
    planner::ReachRefusal why;
    const planner::ReachQuery query{planner::hand_pose(grasp, hand), Vec3::UnitZ(), 0.05};
    const double begin = cpu_ms();
    const bool reachable = !reach.find(query, 1, why).empty();
    (reachable ? times.reachable : times.refused).push_back(1e3 * (cpu_ms() - begin));
    for (auto& posture : reach.find(query, 3, why)) {
      out.push_back(posture.reach.pre_grasp_rad);
    }
  }
  planner::JointRandom random(seed);
  const std::size_t grasps_found = out.size();
  fast.allow(planner::Contacts::None);
  while (out.size() < grasps_found + 6) {
    const JointVector q = random.in(box);
    if (fast.is_free(q)) out.push_back(q);
  }
  out.push_back(tests::home_rad());
  checkers.exact.allow(planner::Contacts::None);
  std::erase_if(out, [&](const JointVector& q) {
    const bool by_fast = fast.is_free(q), by_stock = stock.is_free(q);
    const bool by_exact = checkers.exact.what_touches(q).with == planner::Touch::With::Nothing;
    ++agreement.places;
    agreement.only_spheres_refuse += !by_fast && by_stock;
    agreement.only_stock_refuses += by_fast && !by_stock;
    agreement.exact_refuses_what_both_allow += by_fast && by_stock && !by_exact;
    return !by_fast || !by_stock || !by_exact;
  });
  return out;
}

int run() {
  keep_memory();
  const hal::RobotModel& model = hal::built_in_robot();
  const planner::SphereModel spheres = planner::cover_with_spheres(model);
  const planner::PlannerConfig config;
  const auto arm = planner::arm_geometry(model);
  if (!arm) return 1;
  planner::MotionLimits limits;
  limits.velocity_rad_s = config.velocity_fraction * model.velocity_rad_s();
  const JointVector margin = JointVector::Constant(config.limit_margin_deg * std::numbers::pi / 180.0);
  const planner::JointBox box{model.lower_rad() + margin, model.upper_rad() - margin};
  const ThreadClock clock;

  std::vector<Setting> settings;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    settings.push_back(table(seed, false));
    settings.push_back(table(seed, true));
    settings.push_back(under_a_top(seed));
    settings.push_back(through_a_gap(seed));
    settings.push_back(between_legs(seed));
  }

  Column ours{"CoLift", {}}, coarse{"OMPL + FCL, resolution 0.01 (its default)", {}},
      fine{"OMPL + FCL, step 0.045 rad (Euclidean)", {}};
  std::vector<std::string> kinds;
  ReachTimes reach_times;
  Agreement agreement;
  int straight_all = 0;
  std::vector<double> trajectory_ms, exact_ms;
  // OMPL's resolution is a part of the space's extent; CoLift's step is the largest in any one joint, this
  // one Euclidean
  const double fine_resolution = config.step_rad / (box.upper_rad - box.lower_rad).norm();
  for (std::size_t w = 0; w < settings.size(); ++w) {
    const tests::PlanningWorld world = tests::see_from_all_sides(settings[w].world);
    planner::Checkers checkers{planner::FastChecker(model, spheres, world.scene),
                               planner::ExactChecker(model, world.map, world.scene->ground)};
    checkers.fast.set_hand(hal::coupled_posture(0.0));
    checkers.exact.set_hand(hal::coupled_posture(0.0));
    planner::GraspReach reach(model, *arm, config, checkers.fast);
    StockPlanner stock(model, spheres, world.map, box);
    const planner::JointPath at =
        places(reach, checkers, stock, settings[w].grasps, box, w, reach_times, agreement);
    if (at.size() < 2) continue;
    sim_hal::Draws draws(w, 9);
    int taken = 0, straight = 0;
    for (int i = 0; taken < kProblemsEach && i < 500; ++i) {
      // the last place is home: every other problem starts there
      const auto any = static_cast<std::size_t>(draws.below(static_cast<int>(at.size())));
      const JointVector start = i % 2 == 0 ? at.back() : at[any];
      const JointVector goal = at[static_cast<std::size_t>(draws.below(static_cast<int>(at.size()) - 1))];
      if (planner::joint_distance(start, goal) < 0.3) continue;
      checkers.fast.allow(planner::Contacts::None);
      const bool is_straight = checkers.fast.is_free(start, goal, config.step_rad);
      if (is_straight && straight >= kStraightEach) continue;
      straight += is_straight ? 1 : 0;
      straight_all += is_straight ? 1 : 0;
      ++taken;
      kinds.push_back(settings[w].kind);
      {
        Outcome o;
        planner::PlanTimes times;
        const auto found = planner::find_transit({model, config, limits, checkers, &clock}, box, start,
                                                 std::span(&goal, 1), 1, times);
        o.plan_ms = times.plan_ms;
        o.shortcut_ms = times.shortcut_ms;
        o.found = found.has_value();
        if (found) {
          o.length = planner::length_of(found->way_points);
          o.exact = exactly_free(planner::sampled(found->trajectory, config.exact_step_rad), checkers.exact,
                                 config.exact_step_rad);
          trajectory_ms.push_back(times.trajectory_ms);
          exact_ms.push_back(times.exact_ms);
        } else {
          fmt::print(stderr, "{} {}: {}\n", settings[w].kind, i, found.error().text());
        }
        ours.all.push_back(o);
      }
      for (const auto& [column, resolution] : {std::pair{&coarse, 0.01}, std::pair{&fine, fine_resolution}})
        column->all.push_back(
            plan_with_tries(stock, start, goal, resolution, checkers.exact, config.exact_step_rad));
    }
  }

  const auto count = static_cast<int>(ours.all.size());
  fmt::print(
      "{} problems in {} worlds; a straight line in joint space solves {}. Their starts and goals are free "
      "by "
      "all three checkers. Of the {} configurations that were tried, the spheres alone refuse {}, stock "
      "alone {}, "
      "the "
      "exact check {} that both allow.\n\n",
      count, settings.size(), straight_all, agreement.places, agreement.only_spheres_refuse,
      agreement.only_stock_refuses, agreement.exact_refuses_what_both_allow);
  fmt::print(
      "| up to {} tries | path found | free by the exact check | of these at once | plan ms, median / 95 % | "
      "shortcut ms "
      "| together | length rad |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      kTries);
  for (const Column* c : {&ours, &coarse, &fine}) {
    const auto plan = part_of(*c, [](const Outcome& o) { return o.plan_ms; });
    const auto cut = part_of(*c, [](const Outcome& o) { return o.shortcut_ms; });
    const auto length = part_of(*c, [](const Outcome& o) { return o.length; });
    // find_transit() does not tell how often it searched
    const std::string at_once = c == &ours ? "" : fmt::format("{}", c->exact_at_once());
    fmt::print("| {} | {} | {} | {} | {:.2f} / {:.2f} | {:.2f} / {:.2f} | **{:.2f} / {:.2f}** | {:.2f} |\n",
               c->name, c->found(), c->exact(), at_once, median(plan), percentile(plan, 0.95), median(cut),
               percentile(cut, 0.95), median(c->times()), percentile(c->times(), 0.95), median(length));
  }
  fmt::print("\nRatio of the medians: {:.0f} to OMPL's default, {:.0f} at the finer step (goal 30). ",
             median(coarse.times()) / median(ours.times()), median(fine.times()) / median(ours.times()));
  const auto to_coarse = ratios(ours, coarse), to_fine = ratios(ours, fine);
  fmt::print(
      "Problem by problem, where both have an exactly free path: median {:.0f} times ({} problems) and "
      "{:.0f} "
      "times "
      "({}), lowest tenth below {:.0f} and {:.0f}. ",
      median(to_coarse), to_coarse.size(), median(to_fine), to_fine.size(), percentile(to_coarse, 0.1),
      percentile(to_fine, 0.1));
  fmt::print(
      "After that CoLift takes {:.1f} / {:.1f} ms to round and time the path and {:.1f} / {:.1f} ms for the "
      "exact check.\n\n",
      median(trajectory_ms), percentile(trajectory_ms, 0.95), median(exact_ms), percentile(exact_ms, 0.95));

  fmt::print(
      "Judging one grasp (grasp, pre-grasp, straight approach, lift; every posture): {:.0f} / {:.0f} us for "
      "{} "
      "reachable ones, {:.0f} / {:.0f} us for {} refused ones.\n\n",
      median(reach_times.reachable), percentile(reach_times.reachable, 0.95), reach_times.reachable.size(),
      median(reach_times.refused), percentile(reach_times.refused, 0.95), reach_times.refused.size());
  fmt::print(
      "| kind | problems | CoLift, exact | ms, median / 95 % | OMPL at the finer step, exact | ms |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: |\n");
  for (const char* kind : {"table", "table, clutter", "under a top", "through a gap", "between legs"}) {
    Column a{"", {}}, b{"", {}};
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i] != kind) continue;
      a.all.push_back(ours.all[i]);
      b.all.push_back(fine.all[i]);
    }
    if (a.all.empty()) continue;
    fmt::print("| {} | {} | {} | {:.2f} / {:.2f} | {} | {:.0f} / {:.0f} |\n", kind, a.all.size(), a.exact(),
               median(a.times()), percentile(a.times(), 0.95), b.exact(), median(b.times()),
               percentile(b.times(), 0.95));
  }
  // a benchmark of ways that touch something, or of a handful of problems, says nothing
  return ours.exact() == ours.found() && count >= kMinProblems ? 0 : 1;
}

}  // namespace
}  // namespace colift::bench

int main() {
  return colift::bench::run();
}
