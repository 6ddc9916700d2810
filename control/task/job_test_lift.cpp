// The load is tested before it is lifted: some millimetres, slowly, to learn where the object is heavy.

#include <fmt/format.h>

#include <algorithm>

#include "control/task/job.hpp"
#include "control/test_lift/level_grip.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

constexpr double kSettle_s = 0.3;        // after a motion, before its end is believed
constexpr double kLeaderRise_m = 0.008;  // the partner's end is higher than the palm by this: he lifts
constexpr double kMostMoved_m = 0.06;    // an object that was put down farther away has to be seen anew
constexpr double kSamePlace_m = 0.05;    // the partner's, who is seen to some centimetres

const planner::GraspCandidate& chosen_of(const Outcome& outcome) {
  return outcome.candidates[*outcome.decision.chosen];
}

}  // namespace

double Job::test_height_m() const {
  return std::min(config_.test_lift.height_m, config_.task.lift_height_m);
}

void Job::begin_test_lift() {
  test_at_top_ = false;
  tests_.begin(carried_object(*watch_.look().scene.target), record_.decision->partner->position,
               planner::load_point(chosen_of(*record_.decision)), record_.decision->decision.share);
  settled_at_ = now_;
  const double part = test_height_m() / config_.test_lift.height_m;
  loop_.start_lift(LiftController::Role::Lead, test_height_m(), part * config_.test_lift.raise_s);
}

std::optional<Happening> Job::test_lift() {
  watch_object();
  if (auto stuck = serve_lift()) return stuck;
  if (auto limit = beyond_limits()) return limit;
  const double height_m = loop_.view().height_m;
  if (motion_ && partner_rise_m_ > height_m + kLeaderRise_m) {
    role_ = LiftController::Role::Follow;
    return Happening{Event::PartnerReady,
                     fmt::format("his end is {:.0f} mm up: the robot follows", 1e3 * partner_rise_m_)};
  }
  if (in_state_s() > config_.test_lift.raise_s / config_.task.slow_part + config_.task.patience_s)
    return Happening{Event::TimeOut, fmt::format("{:.0f} mm after {:.0f} s", 1e3 * height_m, in_state_s())};

  if (!test_at_top_) {
    doing_ = fmt::format("raises slowly to learn where it is heavy: {:.0f} mm", 1e3 * height_m);
    done_ = height_m / test_height_m();
    const bool enough = frame_ && motion_ && tests_.rising(*motion_) == Raise::Enough;
    if (enough) loop_.stay();
    if (enough || loop_.lift_at_rest()) {
      test_at_top_ = true;
      settled_at_ = now_;
    }
    return std::nullopt;
  }
  const double rested_s = hal::seconds(now_ - settled_at_);
  if (rested_s < kSettle_s) return std::nullopt;
  doing_ = fmt::format("measures mass and centre of gravity at {:.0f} mm", 1e3 * height_m);
  done_ = (rested_s - kSettle_s) / config_.test_lift.hold_s;
  if (frame_ && motion_) tests_.at_top(frame_at_, *motion_);
  if (loop_.view().wrench_W) tests_.feel(*loop_.view().wrench_W, palm().translation());
  if (rested_s < kSettle_s + config_.test_lift.hold_s) return std::nullopt;
  return judge_test_lift();
}

Happening Job::judge_test_lift() {
  auto known = tests_.end();
  TestLiftRecord& entry = record_.test_lifts.emplace_back();
  entry.at = now_ - began_;
  entry.candidate = chosen_of(*record_.decision).id;
  entry.height_m = loop_.view().height_m;
  if (!known) {
    entry.because = known.error().detail;
    const std::string why = "it cannot be told where the object is heavy: " + entry.because;
    refuse_grip(why);
    regrasp_ = static_cast<int>(record_.test_lifts.size()) < config_.test_lift.grips;
    return {Event::HangsAskew, why};
  }
  entry.known = *known;
  entry.because = known->because;
  const bool last_chance = accepts_bearable_ && known->bearable;
  if (known->next != TestLift::Next::Regrasp || last_chance) return {Event::HangsLevel, known->because};
  if (known->bearable && (!bearable_ || known->seen.tilt_rad < bearable_->tilt_rad))
    bearable_ = {chosen_of(*record_.decision), known->share, known->seen.tilt_rad};
  regrasp_ = true;
  return {Event::HangsAskew, known->because};
}

// After test lifts: where the object is most likely to hang level. Where nothing promises that, the best of
// what was borne so far.
bool Job::choose_level(const perception::PartnerGrasp& partner, const Judge& reach) {
  Config config = config_;
  config.decision.max_lever_m = kNoLever_m;
  const auto decide = [&](const hal::Vec3& cog) {
    hal::Vec3& believed = watch_.look().scene.target->cog;
    const hal::Vec3 of_shape = std::exchange(believed, cog);
    auto outcome = decide_for(watch_.look(), partner, config, stopwatch_, reach);
    believed = of_shape;
    return outcome;
  };
  const TestLift& known = *tests_.known();
  const double wanted = 1.0 / (1.0 + config_.decision.weights.epsilon * config_.decision.weights.epsilon);
  const auto felt = tests_.felt();
  const auto tried = std::count_if(felt.begin(), felt.end(), [&](const FeltLift& t) {
    return (t.partner - partner.position).norm() < kSamePlace_m;
  });
  std::optional<LevelGrip> grip;
  if (tried < config_.test_lift.grips)
    grip = choose_level_grip(decide, tests_.object(), partner.position, felt, known.belief, wanted,
                             config_.test_lift);
  if (grip) {
    record_.decision = std::move(grip->outcome);
    return true;
  }
  failed_because_ = fmt::format("after {} test lifts no other grasp promises to hold the object level: {}",
                                tests_.felt().size(), known.because);
  if (auto outcome = decide(known.cog)) record_.decision = std::move(*outcome);
  planner::Decision& decision = record_.decision->decision;
  auto& candidates = record_.decision->candidates;
  if (decision.chosen) candidates[*decision.chosen].verdict = planner::Verdict::Ok;
  decision.chosen.reset();
  if (!bearable_) return false;
  candidates.push_back(bearable_->grasp);
  decision.scores.emplace_back();
  decision.chosen = candidates.size() - 1;
  decision.share = bearable_->share;
  decision.because = fmt::format("grasp {}: the most level of {} test lifts, {:.1f} deg", bearable_->grasp.id,
                                 felt.size(), hal::rad_to_deg(bearable_->tilt_rad));
  accepts_bearable_ = true;
  return true;
}

std::string Job::take_scene_as_moved() {
  if (object_moved_m() > kMostMoved_m) return "that is another scene";
  const hal::Pose X = motion_->X_WTnow_WTref;
  if (auto seen = watch_.object_moved(X, posture()); !seen) return seen.error().detail;
  if (!watch_.look().scene.target) return "it is not seen there";
  take_look();
  tests_.move(X);
  if (bearable_) planner::move(bearable_->grasp, X);
  for (FailedGrip& f : failed_grips_) f.position = X * f.position;
  motion_.reset();
  return "";
}

}  // namespace colift::control
