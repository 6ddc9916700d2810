// A whole `decide`: two frames in, the robot's grasp out. CPU time of one thread, without reading the files.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "bench_timing.hpp"
#include "control/session/decide.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace {

using namespace colift;
constexpr std::size_t kCandidates = 300;

void require(bool fact, const std::string& name, const std::string& what) {
  if (fact) return;
  fmt::print(stderr, "{}: {}; nothing is timed\n", name, what);
  std::exit(1);
}

// stages by CPU time too
class CpuClock final : public hal::Clock {
 public:
  [[nodiscard]] hal::Timestamp now() const override {
    return hal::Timestamp(static_cast<std::int64_t>(1e6 * bench::cpu_ms()));
  }
};

}  // namespace

int main() {
  bench::keep_memory();
  const planner::HandModel hand;
  const CpuClock clock;
  // the hand stays the same from frame to frame: its tables are made once
  const auto tables =
      std::make_shared<const planner::HandCollision>(hand, control::Config{}.candidates.collision);
  std::vector<double> totals;
  fmt::print(
      "| scene | candidates | feasible | look ms | of it ground, target | surfaces | candidates | decide ms "
      "| of it partner | whole ms |\n"
      "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  using enum sim_hal::ObjectKind;
  for (const auto& [kind, number] : {std::pair{Table, 1}, {Table, 2}, {Table, 3}, {Box, 1}, {Chair, 2}}) {
    const auto seed = static_cast<std::uint64_t>(number);
    const auto scene = sim_hal::make_scene(kind, seed);
    const auto partner = sim_hal::make_partner(scene, seed, false);
    const auto shoot = [&](const sim_hal::World& world, std::uint64_t draw) {
      return sim_hal::measure(sim_hal::cast_rays(world, scene.intrinsics, scene.X_WC), {}, draw);
    };
    control::SceneAnalysisInput input;
    input.frame = shoot(scene.world, seed);
    input.X_WC = scene.X_WC;
    input.base_frame_known = true;
    const control::PartnerInput second{std::nullopt,
                                       shoot(sim_hal::with_partner(scene.world, partner), seed + 100)};

    // grasps as dense as it takes for 300 of them
    control::Config config;
    std::size_t candidates = 0;
    for (config.candidates.step_m = 0.05; config.candidates.step_m > 0.002; config.candidates.step_m *= 0.8) {
      const auto analysis = control::analyse_scene(input, control::Method::Fast, config, hand, clock, tables);
      require(analysis && analysis->scene.target, scene.name, "no target");
      candidates = analysis->candidates.size();
      if (candidates >= kCandidates) break;
    }

    const auto first = control::analyse_scene(input, control::Method::Fast, config, hand, clock, tables);
    const auto answer = control::decide(*first, second, config, clock);
    require(answer.has_value(), scene.name, "decide failed");
    const double off = answer->partner ? 1e3 * (answer->partner->position - partner.contact).norm() : 1e9;
    if (off > 30.0) {
      fmt::print("| {} | not timed: the partner's grasp is {} | | | | | | | | |\n", scene.name,
                 off < 1e9 ? fmt::format("{:.0f} mm off", off) : "not seen");
      continue;
    }
    std::vector<double> look_ms, decide_ms, whole, ground_target, surfaces, candidates_ms, partner_ms;
    std::size_t feasible = 0;
    for (int i = 0; i < 31; ++i) {
      const double start = bench::cpu_ms();
      const auto analysis = control::analyse_scene(input, control::Method::Fast, config, hand, clock, tables);
      const double seen = bench::cpu_ms();
      require(analysis.has_value(), scene.name, "look failed");
      const auto outcome = control::decide(*analysis, second, config, clock);
      const double end = bench::cpu_ms();
      require(outcome && outcome->partner, scene.name, "no partner's grasp");
      if (i == 0) {
        for (const auto& c : outcome->candidates)
          feasible += c.verdict == planner::Verdict::Ok || c.verdict == planner::Verdict::Chosen;
        continue;
      }
      look_ms.push_back(seen - start);
      decide_ms.push_back(end - seen);
      whole.push_back(end - start);
      ground_target.push_back(analysis->ms.ground + analysis->ms.target);
      surfaces.push_back(analysis->ms.surfaces);
      candidates_ms.push_back(analysis->ms.candidates);
      partner_ms.push_back(outcome->partner_ms);
    }
    using bench::median;
    totals.push_back(median(whole));
    fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n",
               scene.name, candidates, feasible, median(look_ms), median(ground_target), median(surfaces),
               median(candidates_ms), median(decide_ms), median(partner_ms), totals.back());
  }
  require(!totals.empty(), "decide", "no frame on which the partner's grasp is seen");
  fmt::print("\nMedian of a whole decide: {:.1f} ms (goal 10).\n", bench::median(totals));
}
