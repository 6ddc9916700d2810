// From two depth frames to a decision, in one page: a table is seen, then a person takes hold of it, then the
// robot's grasp is chosen. The frames come from the ray caster with a Kinect's noise; a recorded or live
// camera gives the same DepthFrame.
//
//   build/example_01_see_a_partner picture.png

#include <fmt/format.h>

#include "control/session/decide.hpp"
#include "control/session/scene_analysis.hpp"
#include "sim_hal/synthetic/scenes.hpp"
#include "tools/visualization/scene/scene_picture.hpp"

int main(int argc, char** argv) {
  using namespace colift;
  constexpr std::uint64_t kSeed = 22;

  // a room with a table, and the same room with a person who holds it
  const sim_hal::SyntheticScene room = sim_hal::make_scene(sim_hal::ObjectKind::Table, kSeed);
  const sim_hal::PartnerPose person = sim_hal::make_partner(room, kSeed, /*two_hands=*/false);
  const auto film = [&](const sim_hal::World& world, std::uint64_t seed) {
    return sim_hal::measure(sim_hal::cast_rays(world, room.intrinsics, room.X_WC), {}, seed);
  };

  control::Config config;
  config.decision.check_reach = false;  // there is no robot in this room
  const planner::HandModel hand;
  const hal::SteadyClock clock;

  // what stands there, and where could the hand take it?
  control::SceneAnalysisInput first;
  first.frame = film(room.world, kSeed);
  first.X_WC = room.X_WC;
  const auto analysis = control::analyse_scene(first, control::Method::Fast, config, hand, clock);
  if (!analysis) return fmt::print(stderr, "{}\n", analysis.error().text()), 2;
  fmt::print("{}\n", analysis->reason);

  // where does the person hold it, and which grasp shares the load?
  control::PartnerInput second;
  second.frame = film(sim_hal::with_partner(room.world, person), kSeed + 1);
  const auto outcome = control::decide(*analysis, second, config, clock);
  if (!outcome) return fmt::print(stderr, "{}\n", outcome.error().text()), 2;
  fmt::print("{}\n{}\n", outcome->partner_reason, outcome->decision.reason);
  if (!outcome->partner || !outcome->decision.chosen) return 1;
  fmt::print(
      "truth: the contact is {:.0f} mm and the centre of gravity {:.0f} mm from where they were seen\n",
      1e3 * (outcome->partner->position - person.contact).norm(),
      1e3 * (analysis->scene.target->cog - room.cog).norm());

  picture::ScenePicture picture;
  picture.cloud = &analysis->cloud;
  picture.scene = &analysis->scene;
  picture.candidates = &outcome->candidates;
  picture.partner = outcome->partner;
  picture.partner_pixels = outcome->partner_pixels;
  picture.share = outcome->decision.share;
  picture.optimum = outcome->decision.optimum;
  picture.title = "A table, a person, a decision";
  picture.reason = outcome->decision.reason;
  if (argc > 1) {
    if (auto written = picture::write_scene_picture(argv[1], picture); !written)
      return fmt::print(stderr, "{}\n", written.error().text()), 2;
  }
  return 0;
}
