#pragma once

#include <array>
#include <string_view>

#include "sim_hal/scenario/scenario.hpp"
#include "tools/experiments/experiment.hpp"

namespace colift::experiments {

/// What somebody does beside a lift.
enum class PeopleScene { WalkIn, Run, ReachHand, Crouch, FootUnder, HandInFingers, Second };
inline constexpr std::array<std::string_view, 7> kPeopleScenes{
    "walk-in", "run", "reach", "crouch", "foot-under", "hand-in-fingers", "second-person"};

/// A lift of a table, box, pipe or chair into which somebody comes: what he does is the index in turn; when,
/// where and how fast are drawn from the seed.
struct PeopleTrial {
  sim_hal::Scenario scenario;
  PeopleScene scene = PeopleScene::WalkIn;
};
[[nodiscard]] PeopleTrial people_trial(const Trial& trial);

}  // namespace colift::experiments
