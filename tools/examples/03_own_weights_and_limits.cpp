// One scene, one partner, three wishes: share equally, let the robot take 65 % of the load, and never ask the
// partner for more than 12 N. The scene is analysed once; a decision takes a fraction of a millisecond.
//
//   build/example_03_own_weights_and_limits

#include <fmt/format.h>

#include "control/session/decide.hpp"
#include "control/session/scene_analysis.hpp"
#include "sim_hal/synthetic/scenes.hpp"

int main() {
  using namespace colift;
  constexpr std::uint64_t kSeed = 22;
  const sim_hal::SyntheticScene room = sim_hal::make_scene(sim_hal::ObjectKind::Table, kSeed);
  const sim_hal::PartnerPose person = sim_hal::make_partner(room, kSeed, /*two_hands=*/false);

  control::Config config;
  config.decision.check_reach = false;  // there is no robot in this room
  config.decision.mass_kg = 4.0;
  const hal::SteadyClock clock;
  control::SceneAnalysisInput input;
  input.frame = sim_hal::measure(sim_hal::cast_rays(room.world, room.intrinsics, room.X_WC), {}, kSeed);
  input.X_WC = room.X_WC;
  const auto analysis =
      control::analyse_scene(std::move(input), control::Method::Fast, config, planner::HandModel{}, clock);
  if (!analysis) return fmt::print(stderr, "{}\n", analysis.error().text()), 2;

  control::PartnerInput partner;
  partner.position_W = person.contact;  // given, not observed
  const auto decide = [&](const char* request, const control::Config& wished) -> std::optional<double> {
    const auto outcome = control::decide(*analysis, partner, wished, clock);
    if (!outcome) return fmt::print(stderr, "{}\n", outcome.error().text()), std::nullopt;
    const planner::Decision& decision = outcome->decision;
    fmt::print("{}\n  {}\n", request, decision.reason);
    if (!decision.chosen) return std::nullopt;
    const planner::AgentWrenches& forces = decision.scores[*decision.chosen]->wrenches;
    fmt::print("  the robot lifts with {:.1f} N, the partner with {:.1f} N\n", forces.robot.force.z(),
               forces.partner.force.z());
    return forces.partner.force.z();
  };

  const auto equal = decide("equal shares", config);

  control::Config strong = config;
  strong.decision.weights.epsilon = *planner::epsilon_for_share(0.65);
  const auto relieved = decide("the robot takes 65 %", strong);

  control::Config careful = config;
  careful.decision.limits.partner.force_n = 12.0;
  const auto limited = decide("at most 12 N for the partner", careful);

  const bool good = equal && relieved && limited && *relieved < *equal && *limited <= 12.0 + 1e-9;
  return good ? 0 : 1;
}
