#include <cmath>
#include <cstdio>

#include "control/session/library_layout.hpp"
#include "control/session/scene_analysis.hpp"
#include "planner/load_sharing/load_sharing.hpp"

int main() {
  using namespace colift;
  // program and library have to agree on the size of what goes from one to the other
  const auto here = control::layout_here(), library = control::layout_of_library();
  if (here != library)
    return std::printf("LookInput has %zu bytes here and %zu in the library\n", here.look_input,
                       library.look_input),
           1;
  // the headers' example: two hands 0.8 m apart share 40 N
  const auto sharing = planner::LoadSharing::create(planner::SharingWeights::thesis());
  const double cost = sharing->cost({-0.4, 0, 0}, {0.4, 0, 0}, {{0, 0, 40}, {0, 0, 0}});
  // and the whole chain links: an empty frame has no ground
  control::SceneAnalysisInput input;
  input.frame.depth_m.assign(640 * 480, NAN);
  const auto seen =
      control::analyse_scene(std::move(input), control::Method::Fast, {}, {}, hal::ManualClock());
  std::printf("%.1f %s\n", cost, seen->reason.c_str());
  return cost == 800.0 && !seen->scene.ground ? 0 : 1;
}
