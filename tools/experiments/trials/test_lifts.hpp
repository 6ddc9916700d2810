#pragma once

#include <memory>
#include <string>
#include <vector>

#include "control/test_lift/partner_request.hpp"
#include "control/test_lift/test_lift.hpp"
#include "tools/experiments/trials/tried_grasps.hpp"

namespace colift::experiments {

/// One test lift of a search for a level grip.
struct TriedGrip {
  planner::GraspCandidate grasp;
  hal::Vec3 partner = hal::Vec3::Zero();  ///< As seen, W.
  int asked = 0;        ///< How often the partner had been asked to grasp elsewhere before it.
  double chance = NAN;  ///< That it would be level, before it was tried; unset where nothing was known yet.
  DirectLift lift;      ///< Of a few millimetres.
  double drift_rad_s = 0.0;
  std::optional<control::TestLift> known;
  std::string reason;  ///< What was learnt, or why nothing was.
};

struct GripSearch {
  std::vector<TriedGrip> tried;                 ///< At least one.
  std::optional<std::size_t> level = {};        ///< The one that may be lifted.
  std::vector<control::PartnerRequest> asked;   ///< Where the partner was asked to grasp, in order.
  sim_hal::Scenario scenario;                   ///< With the partner where he holds at the end,
  std::unique_ptr<Observation> elsewhere = {};  ///< and what is seen then; none where nobody was asked.
  std::string reason;
};

/// Test lifts, beginning with the decision's grasp: takes hold, raises slowly until the camera has seen
/// enough, puts down; takes hold elsewhere (control::next_grip) as long as the object turns. When no grip is
/// good, the least tilted of the bearable ones is. When there is none either, the partner is asked to take
/// hold elsewhere (control::next_partner_place) and goes there (partner_goes_to()); all is seen anew, and
/// what was learnt is kept. A grasp without a way, and a grip that comes off, count as tried. Each test lift
/// in a world of its own, where the object stands as it stood. `decided` chose a grasp with `config`.
[[nodiscard]] GripSearch search_level_grip(Observation& observation, const sim_hal::Scenario& scenario,
                                           const control::Outcome& decided, control::Method method,
                                           const control::Config& config, std::uint64_t seed);

}  // namespace colift::experiments
