#include "tools/experiments/test_lifts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/test_lift_eye.hpp"

namespace colift::experiments {
namespace {

constexpr double kSameGrasp_m = 0.004;  // two candidates so near to each other are one
constexpr double kNoLever_m = 10.0;     // the belief judges levers itself

// Grasps that suit any of the places where the centre of gravity may be: nearer to the partner and farther,
// on either side.
std::vector<planner::GraspCandidate> grasps_for(Sighting& sighting, const control::CarriedObject& object,
                                                const control::CogBelief& belief, control::Config config) {
  config.decision.max_lever_m = kNoLever_m;
  const Eigen::Vector2d partner = sighting.partner()->position.head<2>(), arm = belief.mean() - partner;
  const Eigen::Vector2d across = Eigen::Vector2d(-arm.y(), arm.x()).normalized();
  const double spread = std::sqrt(across.dot(belief.covariance() * across));
  std::vector<planner::GraspCandidate> all;
  for (const double aside : {0.0, -spread, spread}) {
    for (const double far : {1.0, 0.6, 0.8, 1.2}) {
      hal::Vec3 cog = object.cog;
      cog.head<2>() = partner + far * arm + aside * across;
      const auto outcome = sighting.decide(config, cog);
      if (!outcome) continue;
      for (const planner::GraspCandidate& c : outcome->candidates) {
        if (c.verdict != planner::Verdict::Ok && c.verdict != planner::Verdict::Chosen) continue;
        const bool known = std::any_of(all.begin(), all.end(), [&](const auto& k) {
          return (k.position - c.position).norm() < kSameGrasp_m && k.approach.dot(c.approach) > 0.999 &&
                 std::abs(k.closing.dot(c.closing)) > 0.999;
        });
        if (!known) all.push_back(c);
      }
    }
  }
  return all;
}

}  // namespace

GripSearch search_level_grip(Sighting& sighting, const sim_hal::Scenario& scenario,
                             const planner::GraspCandidate& first, double share_predicted,
                             const control::Config& config, const control::TestLiftConfig& test_config,
                             std::uint64_t seed) {
  control::Config small = config;
  small.task.lift_height_m = test_config.height_m;
  small.task.lift_s = test_config.raise_s;
  small.task.hold_s = test_config.hold_s;
  small.task.slow_part = test_config.slow_part;
  const control::CarriedObject object = control::carried_object(*sighting.look().scene.target);
  const hal::Vec3 partner = sighting.partner()->position;

  GripSearch search;
  std::vector<control::FeltLift> felt;
  planner::GraspCandidate grasp = first;
  double share = share_predicted, chance = NAN, least_tilt_rad = INFINITY;
  for (;;) {
    TriedGrip& tried = search.tried.emplace_back();
    tried.grasp = grasp;
    tried.chance = chance;
    sighting.watch().object_stands_again();
    control::TestLiftEye eye(object, partner, planner::load_point(grasp), test_config);
    tried.lift = try_grasp(sighting, scenario, grasp, small, seed,
                           [&](hal::DepthFrame frame, const control::RobotPosture& robot, LiftPart part) {
                             const hal::Timestamp at = frame.exposed_at;
                             const auto motion = sighting.watch().watch_object(std::move(frame), robot);
                             if (!motion) return eye.said();
                             if (part == LiftPart::Top) eye.at_top(at, *motion);
                             return part == LiftPart::Raising ? eye.rising(*motion) : eye.said();
                           });
    const auto moved = eye.moved();
    tried.drift_rad_s = eye.drift_rad_s();
    control::FeltLift test{tried.lift.felt,
                           tried.lift.palm_W,
                           partner,
                           planner::load_point(grasp),
                           {},
                           tried.drift_rad_s,
                           share};
    if (tried.lift.lifted && moved) test.X_WTnow_WTref = *moved;
    felt.push_back(test);
    if (!tried.lift.lifted || !moved) {
      search.because = tried.because =
          tried.lift.lifted ? "the camera did not see the object" : "test lift: " + tried.lift.because;
      return search;
    }
    auto known = understand_test_lift(object, felt, test_config);
    if (!known) {
      search.because = tried.because = known.error().text();
      return search;
    }
    search.because = tried.because = known->because;
    tried.known = std::move(*known);
    if (tried.known->next != control::TestLift::Next::Regrasp) {
      search.level = search.tried.size() - 1;
      return search;
    }
    if (tried.known->bearable && tried.known->seen.tilt_rad < least_tilt_rad) {
      least_tilt_rad = tried.known->seen.tilt_rad;
      search.level = search.tried.size() - 1;
    }
    if (static_cast<int>(search.tried.size()) >= test_config.grips) {
      search.because = fmt::format("after {} grips: {}", search.tried.size(), search.because);
      return search;
    }
    const auto grasps = grasps_for(sighting, object, tried.known->belief, config);
    const auto next = next_grip(grasps, partner, felt, tried.known->belief, 0.5, test_config);
    if (!next) {
      search.because += "; no grasp fits it";
      return search;
    }
    grasp = grasps[next->index];
    share = next->share;
    chance = next->chance;
  }
}

}  // namespace colift::experiments
