// A camera that CoLift does not know becomes one that it does: own_camera.hpp beside this file is the whole
// back end. Here a ray caster stands for the maker's library; the rest is as on a robot: the guard judges the
// frames, the scene is analysed. That the back end keeps its promises is shown by the suite that ships with
// CoLift (colift/contract/camera_contract.hpp; tests/package runs it on this very camera).
//
//   build/example_06_own_camera

#include <fmt/format.h>

#include "control/session/scene_analysis.hpp"
#include "hal/guards/guarded_camera.hpp"
#include "own_camera.hpp"
#include "sim_hal/synthetic/scenes.hpp"

int main() {
  using namespace colift;
  const sim_hal::SyntheticScene room = sim_hal::make_scene(sim_hal::ObjectKind::Table, 22);
  hal::ManualClock clock;
  const auto grab = [&](std::chrono::milliseconds) -> std::optional<example::RawImage> {
    clock.advance(std::chrono::milliseconds(33));
    example::RawImage raw;
    raw.exposed_at = clock.now();
    const auto seed = static_cast<std::uint64_t>(clock.now().count());
    for (const float depth_m :
         sim_hal::measure(sim_hal::cast_rays(room.world, room.intrinsics, room.X_WC), {}, seed).depth_m)
      raw.depth_mm.push_back(std::isnan(depth_m) ? 0
                                                 : static_cast<std::uint16_t>(std::lround(1e3f * depth_m)));
    return raw;
  };
  hal::GuardedCamera camera(std::make_unique<example::OwnCamera>(grab, room.intrinsics),
                            hal::CameraGuardConfig{}, clock);
  for (const auto& step : {camera.configure(), camera.activate()})
    if (!step) return fmt::print(stderr, "{}\n", step.error().text()), 2;

  auto frame = camera.next_frame(std::chrono::seconds(1));
  if (!frame) return fmt::print(stderr, "{}\n", frame.error().text()), 2;
  control::SceneAnalysisInput input;
  input.frame = std::move(*frame);
  input.X_WC = room.X_WC;
  const auto analysis = control::analyse_scene(std::move(input), control::Method::Fast, {},
                                               planner::HandModel{}, hal::SteadyClock());
  if (!analysis) return fmt::print(stderr, "{}\n", analysis.error().text()), 2;
  fmt::print("{}\n", analysis->reason);
  if (!analysis->scene.target) return 1;
  const double off_m = (analysis->scene.target->cog - room.cog).norm();
  fmt::print("its centre of gravity is {:.0f} mm from where it truly is; {} frames used\n", 1e3 * off_m,
             camera.health().accepted);
  return off_m < 0.05 ? 0 : 1;
}
