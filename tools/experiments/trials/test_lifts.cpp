#include "tools/experiments/trials/test_lifts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/test_lift/level_grip.hpp"
#include "control/test_lift/test_lift_observer.hpp"
#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/trials/asked_partner.hpp"

namespace colift::experiments {
namespace {

constexpr double kSameGrasp_m = 0.004;  // two candidates so near to each other are one
constexpr double kFailed_m = 0.02;      // so near to a grip that failed no other is tried
constexpr double kWantedShare = 0.5;
constexpr std::uint64_t kAsked = 7970;  // stream of the seeds of where he really goes

bool possible(const planner::GraspCandidate& c) {
  return c.verdict == planner::Verdict::Ok || c.verdict == planner::Verdict::Chosen;
}

class Search {
 public:
  Search(const control::CarriedObject& object, control::Method method, const control::Config& config,
         std::uint64_t seed)
      : object_(object),
        method_(method),
        config_(config),
        test_config_(config.test_lift),
        seed_(seed),
        small_(config_for(method, control::TaskSaid{"test lift", test_config_.height_m, test_config_.hold_s},
                          {{"task.lift_s", fmt::format("{}", test_config_.raise_s)},
                           {"task.slow_fraction", fmt::format("{}", test_config_.slow_fraction)}})),
        at_any_lever_(
            config_for(method, control::TaskSaid{"test lift", config.task.lift_height_m, config.task.hold_s},
                       {{"decision.max_lever_m", fmt::format("{}", test_config_.max_lever_m)}})) {}

  GripSearch run(Observation& first, const sim_hal::Scenario& scenario, const control::Outcome& decided) {
    out_.scenario = scenario;
    observation_ = &first;
    held_.push_back(partner());
    const std::size_t rivals = static_cast<std::size_t>(std::max(0, test_config_.grips - 1));
    std::vector<std::size_t> order = next_best(decided, rivals);
    order.insert(order.begin(), *decided.decision.chosen);
    for (const std::size_t i : order)
      unknowing_.push_back({decided.candidates[i], decided.decision.scores[i]->share, NAN});
    while (!search_here() && ask()) {
    }
    return std::move(out_);
  }

 private:
  struct Choice {
    planner::GraspCandidate grasp;
    double share = 0.5, chance = NAN;
  };

  [[nodiscard]] const hal::Vec3& partner() const { return observation_->partner()->position; }

  // Grasps that suit any of the places where the centre of gravity may be: nearer to the partner and farther,
  // on either side.
  std::vector<planner::GraspCandidate> grasps() {
    std::vector<planner::GraspCandidate> all;
    for (const hal::Vec3& cog : control::likely_places(object_, partner(), *belief_)) {
      const auto outcome = observation_->decide(at_any_lever_, cog);
      if (!outcome) continue;
      for (const planner::GraspCandidate& c : outcome->candidates) {
        const bool known = !possible(c) || std::any_of(all.begin(), all.end(), [&](const auto& k) {
          return (k.position - c.position).norm() < kSameGrasp_m && k.approach.dot(c.approach) > 0.999 &&
                 std::abs(k.closing.dot(c.closing)) > 0.999;
        });
        if (!known) all.push_back(c);
      }
    }
    return all;
  }

  std::optional<Choice> next() {
    const auto failed = [&](const planner::GraspCandidate& c) {
      return std::any_of(failed_.begin(), failed_.end(),
                         [&](const hal::Vec3& f) { return (f - planner::load_point(c)).norm() < kFailed_m; });
    };
    if (!belief_) {
      unknowing_.erase(std::remove_if(unknowing_.begin(), unknowing_.end(),
                                      [&](const Choice& c) { return failed(c.grasp); }),
                       unknowing_.end());
      if (unknowing_.empty()) return std::nullopt;
      return unknowing_.front();
    }
    auto all = grasps();
    all.erase(std::remove_if(all.begin(), all.end(), failed), all.end());
    const auto grip = next_grip(all, partner(), measured_, *belief_, kWantedShare, test_config_);
    if (!grip) return std::nullopt;
    return Choice{all[grip->index], grip->share, grip->chance};
  }

  // Whether it may be lifted as it hung.
  bool try_grip(const Choice& choice) {
    TriedGrip& tried = out_.tried.emplace_back();
    tried.grasp = choice.grasp;
    tried.partner = partner();
    tried.asked = static_cast<int>(out_.asked.size());
    tried.chance = choice.chance;
    const hal::Vec3 grasp = planner::load_point(choice.grasp);
    control::TestLiftObserver eye(object_, partner(), grasp, test_config_);
    observation_->watch().object_stands_again();
    tried.lift = try_grasp(*observation_, out_.scenario, choice.grasp, small_, seed_,
                           [&](hal::DepthFrame frame, const control::RobotPosture& robot, LiftPart part) {
                             const hal::Timestamp at = frame.exposed_at;
                             const auto motion = observation_->watch().watch_object(frame, robot);
                             if (!motion) return eye.said();
                             if (part == LiftPart::Top) eye.at_top(at, *motion);
                             return part == LiftPart::Raising ? eye.rising(*motion) : eye.said();
                           });
    tried.drift_rad_s = eye.drift_rad_s();
    const auto moved = eye.moved();
    const auto fails = [&](std::string why) {
      failed_.push_back(grasp);
      out_.reason = tried.reason = std::move(why);
      return false;
    };
    if (!tried.lift.lifted) return fails("test lift: " + tried.lift.reason);
    if (!moved) return fails("the camera did not see the object");
    measured_.push_back(
        {tried.lift.measured, tried.lift.palm_W, partner(), grasp, *moved, tried.drift_rad_s, choice.share});
    auto known = analyse_test_lift(object_, measured_, test_config_);
    if (!known) {
      measured_.pop_back();
      return fails(known.error().text());
    }
    out_.reason = tried.reason = known->reason;
    belief_ = known->belief;
    tried.known = std::move(*known);
    return tried.known->next != control::TestLift::Next::Regrasp;
  }

  // Whether there is a grip that may be lifted while the partner holds where he does.
  bool search_here() {
    const std::size_t begun = out_.tried.size();
    failed_.clear();
    for (int grip = 0; grip < test_config_.grips; ++grip) {
      const auto choice = next();
      if (!choice) {
        out_.reason += "; no feasible grasp it";
        break;
      }
      if (try_grip(*choice)) {
        out_.level = out_.tried.size() - 1;
        return true;
      }
    }
    double min_tilt_rad = INFINITY;
    for (std::size_t i = begun; i < out_.tried.size(); ++i) {
      const auto& known = out_.tried[i].known;
      if (!known || !known->bearable || known->seen.tilt_rad >= min_tilt_rad) continue;
      min_tilt_rad = known->seen.tilt_rad;
      out_.level = i;
    }
    return out_.level.has_value();
  }

  // Whether the partner was asked, went elsewhere and is seen there.
  bool ask() {
    while (belief_ && static_cast<int>(out_.asked.size()) < test_config_.asks) {
      const auto place = control::next_partner_place(observation_->analysis().candidates, grasps(), held_,
                                                     *belief_, test_config_);
      if (!place) {
        out_.reason += "; nor is there a better place for the partner";
        return false;
      }
      out_.asked.push_back(*place);
      out_.scenario =
          partner_goes_to(out_.scenario, place->position, sim_hal::hash(seed_, kAsked, out_.asked.size()));
      auto seen = Observation::make(out_.scenario, method_, seed_, config_.task.lift_height_m);
      if (!seen) {
        out_.reason = fmt::format("asked to {}; {}", place->reason, seen.error().text());
        held_.insert(held_.begin(), place->position);
        continue;
      }
      out_.elsewhere = std::move(*seen);
      observation_ = out_.elsewhere.get();
      held_.insert(held_.begin(), partner());
      return true;
    }
    return false;
  }

  control::CarriedObject object_;
  control::Method method_;
  const control::Config& config_;
  const control::TestLiftConfig& test_config_;
  std::uint64_t seed_;
  control::Config small_, at_any_lever_;
  GripSearch out_;
  Observation* observation_ = nullptr;
  std::vector<hal::Vec3> held_;    // where the partner holds, and held before
  std::vector<hal::Vec3> failed_;  // grips that measured nothing, while he holds there
  std::vector<Choice> unknowing_;  // the decision's own, best first
  std::vector<control::MeasuredLift> measured_;
  std::optional<control::CogBelief> belief_;
};

}  // namespace

GripSearch search_level_grip(Observation& observation, const sim_hal::Scenario& scenario,
                             const control::Outcome& decided, control::Method method,
                             const control::Config& config, std::uint64_t seed) {
  const control::CarriedObject object = control::carried_object(*observation.analysis().scene.target);
  return Search(object, method, config, seed).run(observation, scenario, decided);
}

}  // namespace colift::experiments
