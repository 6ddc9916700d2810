#include "control/test_lift/partner_request.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "control/session/place_words.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kNearlyAPlace_m = 0.03;  // he is told no finer, nor does the hand need finer steps
constexpr double kNoCase = 1e-3;  // of the likeliest case's weight: less changes no digit that is shown

// of places that are nearly the same the first
std::vector<hal::Vec3> thinned(std::vector<hal::Vec3> all) {
  std::vector<hal::Vec3> few;
  for (const hal::Vec3& p : all)
    if (std::none_of(few.begin(), few.end(),
                     [&](const hal::Vec3& f) { return (f - p).norm() < kNearlyAPlace_m; }))
      few.push_back(p);
  return few;
}

CogBelief likely(const CogBelief& belief) {
  double best = 0.0, sum = 0.0;
  for (const CogBelief::Case& c : belief.cases) best = std::max(best, c.weight);
  CogBelief out;
  out.grip_nm_rad = belief.grip_nm_rad;
  for (const CogBelief::Case& c : belief.cases)
    if (c.weight > kNoCase * best) out.cases.push_back(c), sum += c.weight;
  for (CogBelief::Case& c : out.cases) c.weight /= sum;
  return out;
}

}  // namespace

std::optional<PartnerRequest> next_partner_place(std::span<const planner::GraspCandidate> places,
                                                 std::span<const planner::GraspCandidate> grasps,
                                                 std::span<const hal::Vec3> held, const CogBelief& belief,
                                                 const TestLiftConfig& config) {
  if (held.empty() || belief.cases.empty()) return std::nullopt;
  const CogBelief cases = likely(belief);
  const Vec2 mean = cases.mean();
  const double max_turn_rad = hal::deg_to_rad(config.good_turn_deg);
  std::vector<hal::Vec3> his, ours;
  for (const planner::GraspCandidate& c : places) {
    const hal::Vec3 p = planner::load_point(c);
    if (std::abs(p.z() - held.front().z()) <= config.partner_height_tolerance_m &&
        std::none_of(held.begin(), held.end(),
                     [&](const hal::Vec3& h) { return (h - p).norm() < config.tried_partner_radius_m; }))
      his.push_back(p);
  }
  for (const planner::GraspCandidate& c : grasps)
    if (c.verdict == planner::Verdict::Ok || c.verdict == planner::Verdict::Chosen)
      ours.push_back(planner::load_point(c));
  his = thinned(std::move(his));
  ours = thinned(std::move(ours));

  std::optional<PartnerRequest> best;
  double best_worth = 0.0;
  std::vector<double> some(cases.cases.size());  // by case: the best of all grasps
  for (const hal::Vec3& place : his) {
    std::fill(some.begin(), some.end(), 0.0);
    double single = 0.0;
    PartnerRequest at{place, {}, 0.0, 0.0, {}};
    for (const hal::Vec3& grasp : ours) {
      if ((grasp - place).head<2>().norm() < config.min_hand_distance_m) continue;
      double chance = 0.0;
      for (std::size_t i = 0; i < some.size(); ++i) {
        const CogBelief::Case& c = cases.cases[i];
        const double share = lever_share(c.cog, place, grasp);
        if (share < config.min_share || share > config.max_share) continue;
        const double level =
            chance_level(c, cases.grip_nm_rad, place, grasp, max_turn_rad, config.belief.grip_sigma);
        some[i] = std::max(some[i], level);
        chance += c.weight * level;
      }
      if (chance <= single) continue;
      single = chance;
      at.robot = grasp;
      at.share = lever_share(mean, place, grasp);
    }
    for (std::size_t i = 0; i < some.size(); ++i) at.chance += cases.cases[i].weight * some[i];
    const double worth = 0.5 * (at.chance + single);
    if (at.chance < config.min_level_probability_elsewhere || worth <= best_worth) continue;
    best_worth = worth;
    best = at;
  }
  if (best) {
    const hal::Vec3& p = best->position;
    best->reason = fmt::format(
        "grasp {}, at ({:.2f}, {:.2f}, {:.2f}): the object is then level with a probability of {:.0f} %",
        place_words(held.front(), p, mean), p.x(), p.y(), p.z(), 100.0 * best->chance);
  }
  return best;
}

}  // namespace colift::control
