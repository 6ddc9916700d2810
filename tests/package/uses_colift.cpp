#include <cmath>
#include <cstdio>

#include "control/session/look.hpp"
#include "planner/load_sharing/load_sharing.hpp"

int main() {
  using namespace colift;
  // the headers' example: two hands 0.8 m apart share 40 N
  const auto sharing = planner::LoadSharing::create(planner::SharingWeights::thesis());
  const double cost = sharing->cost({-0.4, 0, 0}, {0.4, 0, 0}, {{0, 0, 40}, {0, 0, 0}});
  // and the whole chain links: an empty frame has no ground
  control::LookInput input;
  input.frame.depth_m.assign(640 * 480, NAN);
  const auto seen = control::look(std::move(input), control::Method::Fast, {}, {}, hal::ManualClock());
  std::printf("%.1f %s\n", cost, seen->because.c_str());
  return cost == 800.0 && !seen->scene.ground ? 0 : 1;
}
