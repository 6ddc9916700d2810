// A whole `decide`: two frames in, the robot's grasp out. CPU time of one thread, without reading the files.
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include "bench_timing.hpp"
#include "control/decide.hpp"
#include "sim_hal/mock/scenes.hpp"

namespace {

using namespace colift;
constexpr std::size_t kCandidates = 300;

// both frames seen, the hand held against them, the load shared: the same answer as the parts give one by one
void require(bool fact, const std::string& name, const std::string& what) {
  if (fact) return;
  fmt::print(stderr, "{}: {}; nothing is timed\n", name, what);
  std::exit(1);
}

}  // namespace

int main() {
  bench::keep_memory();
  const planner::HandModel hand;
  const hal::SteadyClock clock;
  std::vector<double> totals;
  fmt::print("| scene | candidates | feasible | look ms | of it ground, target | surfaces | candidates | decide ms | of it partner | whole ms |\n"
             "| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |\n");
  using enum sim_hal::ObjectKind;
  for (const auto& [kind, number] : {std::pair{Table, 1}, {Table, 2}, {Table, 3}, {Box, 1}, {Chair, 2}}) {
    const auto seed = static_cast<std::uint64_t>(number);
    const auto scene = sim_hal::make_scene(kind, seed);
    const auto partner = sim_hal::make_partner(scene, seed, false);
    const auto shoot = [&](const sim_hal::World& world, std::uint64_t draw) {
      return sim_hal::measure(sim_hal::cast_rays(world, scene.intrinsics, scene.X_WC), {}, draw);
    };
    control::LookInput input;
    input.frame = shoot(scene.world, seed);
    input.X_WC = scene.X_WC;
    input.base_frame_known = true;
    const control::PartnerInput second{std::nullopt, shoot(sim_hal::with_partner(scene.world, partner), seed + 100)};

    // grasps as dense as it takes for 300 of them
    control::Config config;
    std::size_t candidates = 0;
    for (config.candidates.step_m = 0.05; config.candidates.step_m > 0.002; config.candidates.step_m *= 0.8) {
      const auto look = control::look(input, control::Method::Fast, config, hand, clock);
      require(look && look->scene.target, scene.name, "no target");
      candidates = look->candidates.size();
      if (candidates >= kCandidates) break;
    }

    std::vector<double> look_ms, decide_ms, whole, ground_target, surfaces, candidates_ms, partner_ms;
    std::size_t feasible = 0;
    for (int i = 0; i < 31; ++i) {
      const double start = bench::cpu_ms();
      const auto look = control::look(input, control::Method::Fast, config, hand, clock);
      const double seen = bench::cpu_ms();
      require(look.has_value(), scene.name, "look failed");
      const auto outcome = control::decide(*look, second, config, clock);
      const double end = bench::cpu_ms();
      require(outcome && outcome->partner, scene.name, "no partner's grasp");
      if (i == 0) {
        const double off = (outcome->partner->position - partner.contact).norm();
        require(off < 0.03, scene.name, fmt::format("the partner's grasp is {:.0f} mm off", 1e3 * off));
        for (const auto& c : outcome->decision.verdicts) feasible += c.cost.has_value();
        continue;
      }
      look_ms.push_back(seen - start);
      decide_ms.push_back(end - seen);
      whole.push_back(end - start);
      ground_target.push_back(look->ms.ground + look->ms.target);
      surfaces.push_back(look->ms.surfaces);
      candidates_ms.push_back(look->ms.candidates);
      partner_ms.push_back(outcome->partner_ms);
    }
    using bench::median;
    totals.push_back(median(whole));
    fmt::print("| {} | {} | {} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} | {:.1f} |\n", scene.name, candidates, feasible, median(look_ms),
               median(ground_target), median(surfaces), median(candidates_ms), median(decide_ms), median(partner_ms), totals.back());
  }
  fmt::print("\nMedian of a whole decide: {:.1f} ms (goal 10).\n", bench::median(totals));
}
