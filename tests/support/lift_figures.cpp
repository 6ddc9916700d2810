#include "tests/support/lift_figures.hpp"

#include <fmt/format.h>

#include <cmath>

namespace colift::tests {
namespace {

constexpr double kWantedShare = 0.5, kShareBudget = 0.07;

const char* word(control::RunRecord::Result outcome) {
  using Result = control::RunRecord::Result;
  return outcome == Result::Lifted ? "lifted" : outcome == Result::Aborted ? "aborted" : "refused";
}

}  // namespace

std::string line(const std::string& name, const SimulatedLift& lift) {
  if (lift.record.outcome != control::RunRecord::Result::Lifted)
    return fmt::format("{}: {}: {}", name, word(lift.record.outcome), lift.record.reason);
  return fmt::format(
      "{}: lifted {:.1f} cm, tilt {:.2f} deg, share {:.2f}, slip {:.1f} mm, partner off {:.0f} mm{}", name,
      1e2 * lift.height_m, lift.tilt_deg, lift.share_robot, 1e3 * lift.slip_m, 1e3 * lift.partner_error_m,
      lift.hit_something ? ", HIT SOMETHING" : "");
}

void see_from_beside_robot(sim_hal::Scenario& scenario) {
  // on the side to which the near face is turned
  const double side = scenario.object.yaw_deg < 0.0 ? 1.0 : -1.0;
  scenario.camera.xyz = {0.0, side * 1.6, 1.3};
  scenario.camera.look_at =
      hal::Vec3(scenario.object.xyz.x() - 0.15, scenario.object.xyz.y(), 0.6 * scenario.object.size[2]);
}

LiftFigures lift_random(sim_hal::RandomKind kind, control::Method method, std::uint64_t first, int count,
                        const std::function<void(const std::string&)>& done,
                        const std::function<void(sim_hal::Scenario&)>& arrange) {
  LiftFigures f;
  f.trials = count;
  std::vector<double> tilt, share_error, partner, slip;
  double sim_s = 0.0, wall_s = 0.0;
  for (std::uint64_t seed = first; seed < first + static_cast<std::uint64_t>(count); ++seed) {
    sim_hal::Scenario scenario = sim_hal::random_scenario(kind, seed);
    if (arrange) arrange(scenario);
    const SimulatedLift lift = simulate(scenario, method, seed);
    const std::string said = line(scenario.name, lift);
    if (done) done(said);
    partner.push_back(lift.partner_error_m);
    sim_s += lift.record.timing.sim_s;
    wall_s += lift.record.timing.wall_s;
    f.hit_something += lift.hit_something;
    if (lift.record.outcome != control::RunRecord::Result::Lifted) {
      f.not_lifted.push_back(said);
      continue;
    }
    ++f.lifted;
    tilt.push_back(lift.tilt_deg);
    share_error.push_back(std::abs(lift.share_robot - kWantedShare));
    slip.push_back(lift.slip_m);
  }
  int within = 0;
  for (const double e : share_error) within += e <= kShareBudget;
  f.share_within = f.lifted > 0 ? static_cast<double>(within) / f.lifted : 0.0;
  f.tilt_median_deg = quantile(tilt, 0.5);
  f.tilt_p95_deg = quantile(tilt, 0.95);
  f.share_error_p90 = quantile(share_error, 0.9);
  f.partner_p90_m = quantile(partner, 0.9);
  f.slip_p95_m = quantile(slip, 0.95);
  f.real_time = wall_s > 0.0 ? sim_s / wall_s : 0.0;
  return f;
}

}  // namespace colift::tests
