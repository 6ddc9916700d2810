#include "tools/experiments/runs/people_scene.hpp"

#include <cmath>
#include <string>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace {

using Point = Eigen::Vector2d;
using sim_hal::Draws;
using sim_hal::ScenarioPerson;

constexpr double kOutside_m = 2.6;    // where a person comes from, beside the robot's axis
constexpr double kBefore_m = 0.30;    // he does not walk into the object: on the robot's side of it
constexpr double kStandOff_m = 0.75;  // a hand's reach from what he reaches for

std::string any_of(Draws& draws, std::initializer_list<const char*> states) {
  return std::data(states)[draws.below(static_cast<int>(states.size()))];
}

}  // namespace

PeopleTrial people_trial(const Trial& trial) {
  PeopleTrial out;
  const std::uint64_t seed = trial.own_seed(31);
  const int kinds = static_cast<int>(kPeopleScenes.size());
  out.scene = static_cast<PeopleScene>(trial.index % kinds);
  // every scene meets every object within 28 trials
  const int i = trial.index / kinds;
  out.scenario = mixed_layout(4 * i + (trial.index % kinds + i) % 4, trial.seed);
  Draws draws(seed, 7900);
  const double side = draws.chance(0.5) ? -1.0 : 1.0;
  const sim_hal::ScenarioObject& object = out.scenario.object;
  const Point middle = object.xyz.head<2>();
  // the near end, where the hand goes
  const Point ahead = middle.normalized();
  const Point near = middle - 0.5 * object.size[0] * ahead;
  const Point across = side * Point(-middle.y(), middle.x()).normalized();
  ScenarioPerson p;
  p.in_state = any_of(draws, {"approach", "approach", "close", "lift", "hold", "lower", "retreat"});
  p.enters_s = draws.between(0.0, 2.0);
  p.speed = draws.between(0.7, 1.4);
  p.hand_speed = draws.between(0.4, 1.6);
  Point end = 0.5 * (near + Point(0.25, 0.0)) + draws.between(-0.10, 0.25) * across;
  switch (out.scene) {
    case PeopleScene::WalkIn:
      p.action = "walk";
      break;
    case PeopleScene::Run:
      p.action = "walk";
      p.speed = 1.6;
      break;
    case PeopleScene::ReachHand:
      p.action = "reach";
      p.reach_to = "robot-hand";
      end = near - kBefore_m * ahead + kStandOff_m * across;
      break;
    case PeopleScene::Crouch:
      p.action = "crouch";
      end = near - kBefore_m * ahead + draws.between(0.15, 0.45) * across;
      break;
    case PeopleScene::FootUnder:
      p.in_state = any_of(draws, {"lift", "hold", "lower"});
      p.action = "reach";
      p.reach_to = "under-object";
      p.with_foot = true;
      end = near + (0.5 * object.size[1] + 0.40) * across;
      break;
    case PeopleScene::HandInFingers:
      p.in_state = any_of(draws, {"approach", "approach", "close"});
      p.action = "reach";
      p.reach_to = "between-fingers";
      end = near - kBefore_m * ahead + kStandOff_m * across;
      break;
    case PeopleScene::Second:
      p.action = "reach";
      p.reach_to = "object";
      end = middle + (0.5 * object.size[1] + 0.65) * across;
      break;
  }
  p.path = {end + kOutside_m * across, end};
  out.scenario.people = {p};
  out.scenario.name += ", " + std::string(kPeopleScenes[static_cast<std::size_t>(out.scene)]);
  return out;
}

}  // namespace colift::experiments
