// What a user waits for, piece by piece: the works of tests/instructions, timed, beside their goals. CPU time
// of one thread, medians.
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "bench_timing.hpp"
#include "tests/instructions/counted_work.hpp"

namespace {

constexpr std::size_t kRounds = 25;

struct Goal {
  std::string_view work;
  double ms;
};
constexpr Goal kGoals[] = {{"frame_to_target", 1.2},
                           {"surfaces", 1.0},
                           {"first_decide", 8.0},
                           {"decide_again", 2.0},
                           {"partner_in_frame", 0.6},
                           {"follower", 10.0},
                           {"collision_scene", 5.0},
                           {"person_in_scene", 5.0},
                           {"state_checks", 0.3},
                           {"inverse_kinematics", 0.4},
                           {"plan", 8.0}};

std::string goal_of(std::string_view work) {
  for (const Goal& goal : kGoals)
    if (goal.work == work) return fmt::format("{:.1f}", goal.ms);
  return "";
}

struct Spread {
  double median_ms, most_ms;
};

// The first round, which still fetches memory, is not counted.
Spread time(const std::function<void()>& work) {
  std::vector<double> rounds;
  for (std::size_t i = 0; i <= kRounds; ++i) {
    const double start = colift::bench::cpu_ms();
    work();
    if (i > 0) rounds.push_back(colift::bench::cpu_ms() - start);
  }
  const double most = *std::max_element(rounds.begin(), rounds.end());
  return {colift::bench::median(rounds), most};
}

}  // namespace

// Names after the program's select works.
int main(int argc, char** argv) {
  using namespace colift::counted;
  colift::bench::keep_memory();
  const std::vector<std::string> only(argv + 1, argv + std::max(argc, 1));
  std::vector<Work> works = perception_works();
  for (auto* more : {&planning_works, &simulation_works})
    for (Work& work : more()) works.push_back(std::move(work));
  fmt::print("| work | ms, median of {} | most | goal |\n| --- | ---: | ---: | ---: |\n", kRounds);
  for (const Work& work : works) {
    if (!only.empty() && std::find(only.begin(), only.end(), work.name) == only.end()) continue;
    const Spread ms = time(work.prepare());
    fmt::print("| {} | {:.2f} | {:.2f} | {} |\n", work.what, ms.median_ms, ms.most_ms, goal_of(work.name));
  }
}
