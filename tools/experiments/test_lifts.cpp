#include "tools/experiments/test_lifts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::experiments {
namespace {

constexpr int kInARow = 6;  // frames that have to agree: while the partner comes after, the object swings
constexpr double kSameGrasp_m = 0.004;  // two candidates so near to each other are one
constexpr double kNoLever_m = 10.0;     // the belief judges levers itself

hal::Vec3 grasp_point(const planner::GraspCandidate& c) {
  return c.position + c.depth_m * c.approach;
}

control::CarriedObject carried(const Sighting& sighting) {
  const perception::Target& target = *sighting.look().scene.target;
  control::CarriedObject object;
  object.partner = sighting.partner()->position;
  object.cog = target.cog;
  object.cog_covariance = target.cog_covariance;
  const hal::OrientedBox& box = target.shape;
  for (const auto& [u, v] : {std::pair{-0.5, -0.5}, {0.5, -0.5}, {0.5, 0.5}, {-0.5, 0.5}})
    object.feet.push_back(box.center + box.axes * box.size.cwiseProduct(hal::Vec3(u, v, -0.5)));
  return object;
}

/// What the camera tells of one test lift.
class Eye {
 public:
  Eye(control::Watch& watch, const control::CarriedObject& object, const hal::Vec3& grasp,
      const control::TestLiftConfig& config)
      : watch_(watch), object_(object), grasp_(grasp), config_(config) {}

  control::Raise look(hal::DepthFrame frame, const control::RobotPosture& robot, LiftPart part) {
    const double at_s = hal::seconds(frame.exposed_at);
    const auto motion = watch_.watch_object(std::move(frame), robot);
    if (!motion) return said_;
    const control::Hanging now = hanging(object_, grasp_, motion->X_WTnow_WTref);
    if (part == LiftPart::Top) {
      // small turns add up like vectors
      const Eigen::AngleAxisd turn(motion->X_WTnow_WTref.linear());
      turn_ += turn.angle() * turn.axis();
      shift_ += motion->X_WTnow_WTref * object_.cog - object_.cog;
      ++frames_;
      turns_.push_back(now.turn_rad);
      times_s_.push_back(at_s);
    }
    if (part != LiftPart::Raising) return said_;
    const control::Raise how = raise_on(now, config_);
    in_a_row_ = how == seen_ ? in_a_row_ + 1 : 1;
    seen_ = how;
    if (in_a_row_ >= kInARow) said_ = how;
    return said_;
  }

  /// Slope of the turn over the time at the top (rad/s), by least squares.
  [[nodiscard]] double drift_rad_s() const {
    double t = 0.0, y = 0.0, tt = 0.0, ty = 0.0;
    const auto n = static_cast<double>(turns_.size());
    for (std::size_t i = 0; i < turns_.size(); ++i) t += times_s_[i] / n, y += turns_[i] / n;
    for (std::size_t i = 0; i < turns_.size(); ++i) {
      tt += (times_s_[i] - t) * (times_s_[i] - t);
      ty += (times_s_[i] - t) * (turns_[i] - y);
    }
    return tt > 0.0 ? ty / tt : 0.0;
  }

  /// Mean motion at the top; none when the object was not seen there.
  [[nodiscard]] std::optional<hal::Pose> moved() const {
    if (frames_ == 0) return std::nullopt;
    const hal::Vec3 turn = turn_ / frames_;
    hal::Pose X = hal::Pose::Identity();
    if (turn.norm() > 1e-12)
      X.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    X.translation() = object_.cog + shift_ / frames_ - X.linear() * object_.cog;
    return X;
  }

 private:
  control::Watch& watch_;
  const control::CarriedObject& object_;
  hal::Vec3 grasp_;
  const control::TestLiftConfig& config_;
  control::Raise seen_ = control::Raise::On, said_ = control::Raise::On;
  int in_a_row_ = 0, frames_ = 0;
  std::vector<double> turns_, times_s_;
  hal::Vec3 turn_ = hal::Vec3::Zero(), shift_ = hal::Vec3::Zero();
};

// Grasps that suit any of the places where the centre of gravity may be: nearer to the partner and farther,
// on either side.
std::vector<planner::GraspCandidate> grasps_for(Sighting& sighting, const control::CarriedObject& object,
                                                const control::CogBelief& belief, control::Config config) {
  config.decision.max_lever_m = kNoLever_m;
  const Eigen::Vector2d partner = object.partner.head<2>(), arm = belief.mean() - partner;
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
  const control::CarriedObject object = carried(sighting);

  GripSearch search;
  std::vector<control::FeltLift> felt;
  planner::GraspCandidate grasp = first;
  double share = share_predicted, chance = NAN, least_tilt_rad = INFINITY;
  for (;;) {
    TriedGrip& tried = search.tried.emplace_back();
    tried.grasp = grasp;
    tried.chance = chance;
    Eye eye(sighting.watch(), object, grasp_point(grasp), test_config);
    tried.lift = try_grasp(sighting, scenario, grasp, small, seed,
                           [&](hal::DepthFrame frame, const control::RobotPosture& robot, LiftPart part) {
                             return eye.look(std::move(frame), robot, part);
                           });
    const auto moved = eye.moved();
    tried.drift_rad_s = eye.drift_rad_s();
    control::FeltLift test{
        tried.lift.felt, tried.lift.palm_W, grasp_point(grasp), {}, tried.drift_rad_s, share};
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
    const auto next = next_grip(grasps, object, felt, tried.known->belief, 0.5, test_config);
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
