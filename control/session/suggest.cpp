#include "control/session/suggest.hpp"

#include <fmt/format.h>

#include <vector>

#include "hal/types/units.hpp"
#include "planner/grasp/task_choice.hpp"

namespace colift::control {
namespace {

// distance of the centre of gravity from the vertical plane through both hands
double lever(const hal::Vec3& partner, const hal::Vec3& robot, const hal::Vec3& cog, const hal::Vec3& up) {
  const hal::Vec3 normal = up.cross(robot - partner);
  return normal.norm() > 0.0 ? std::abs(normal.normalized().dot(cog - partner)) : 0.0;
}

std::string place_text(const hal::Vec3& p) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f})", p.x(), p.y(), p.z());
}

}  // namespace

std::optional<Suggestion> suggest_to_partner(const Outcome& outcome,
                                             std::span<const planner::GraspCandidate> candidates,
                                             const hal::Vec3& cog, const hal::Vec3& up,
                                             const planner::DecisionConfig& config) {
  if (!outcome.partner) return std::nullopt;
  const planner::SharingWeights& w = config.weights;
  const planner::CarryingAgent robot{hal::Vec3::Zero(), w.epsilon * w.epsilon, w.omega2_per_m};
  const std::vector<hal::Wrench> lift{{config.mass_kg * hal::kGravity_m_s2 * up, hal::Vec3::Zero()}};
  struct {
    double cost = 0.0;
    hal::Vec3 place, robot;
    bool found = false;
  } best;
  for (const planner::GraspCandidate& c : candidates) {
    const hal::Vec3 place = planner::load_point(c);
    if (std::abs(up.dot(place - outcome.partner->position)) > config.ask_height_m) continue;
    const planner::CarryingAgent person{place - cog, 1.0, w.omega1_per_m};
    const auto choice =
        planner::choose_beside(candidates, {&person, 1}, robot, cog, lift, config.near_partner_m);
    if (!choice || !choice->best) continue;
    const hal::Vec3 at = planner::load_point(candidates[*choice->best]);
    const double cost = choice->costs[*choice->best];
    if ((best.found && cost >= best.cost) || lever(place, at, cog, up) > config.max_lever_m) continue;
    best = {cost, place, at, true};
  }
  if (!best.found) return std::nullopt;

  Suggestion s;
  s.position = best.place;
  const double away_m = (best.place - outcome.partner->position).norm();
  if (!outcome.decision.chosen) {
    s.reason =
        fmt::format("if the partner grasped at {}, {:.2f} m from his hand, the robot could grasp at {}",
                    place_text(best.place), away_m, place_text(best.robot));
    return s;
  }
  s.gain = 1.0 - best.cost / outcome.decision.cost;
  if (*s.gain < config.ask_gain) return std::nullopt;
  s.reason = fmt::format(
      "the partner should rather grasp at {}, {:.2f} m from his hand: both together would need "
      "{:.0f} % less effort",
      place_text(best.place), away_m, 1e2 * *s.gain);
  return s;
}

}  // namespace colift::control
