#include "control/task/grasp_selector.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "control/test_lift/level_grip.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

constexpr double kSameSide = 0.8;      // cosine
constexpr double kLessDeep_m = 0.005;  // of two grasps that differ by less neither is the shallower one

double less_deep(const planner::GraspCandidate& grasp) {
  return grasp.depth_m - kLessDeep_m;
}

// Pads behind a face, with room to hold it less deep.
bool reaches_behind(const planner::GraspCandidate& c, const planner::CandidateConfig& config) {
  return c.kind != planner::GraspKind::Wrap && c.depth_m > config.min_hold_depth_m + 2 * kLessDeep_m;
}

}  // namespace

void GraspSelector::set_scene() {
  SceneAnalysis& analysis = c_.session.analysis();
  if (const auto& own = c_.options.policies.grasps; own && analysis.finder)
    use_candidates(analysis, own(analysis));
  judge_reach(analysis.candidates);
  if (!c_.options.policies.grasps)
    add_grasps(analysis, c_.config.candidates,
               [this](std::vector<planner::GraspCandidate>& more) { judge_reach(more); });
  analysis.reason = planner::explain(analysis.candidates);
  c_.record.analysis = analysis;
  judged_.clear();
}

void GraspSelector::begin_decision() {
  if (judged_.empty()) judged_ = c_.session.analysis().candidates;
  c_.session.analysis().candidates = judged_;
  add_shallower(c_.session.analysis().candidates);
  without_path_.clear();
}

void GraspSelector::apply_refusals(std::vector<planner::GraspCandidate>& candidates) const {
  for (auto& c : candidates)
    for (const auto& r : without_path_)
      if ((c.position - r.position).norm() < 1e-6 && c.approach.dot(r.approach) > 1.0 - 1e-9)
        c.verdict = planner::Verdict::Unreachable, c.reason = r.reason;
  for (auto& c : candidates)
    for (const FailedGrasp& f : failed_)
      if (f.covers(c)) c.verdict = f.verdict, c.reason = f.why;
}

void GraspSelector::judge_reach(std::vector<planner::GraspCandidate>& candidates) {
  const double lift = c_.config.task.lift_height_m;
  c_.motion_planner.judge(candidates, lift);
  const SceneAnalysis& analysis = c_.session.analysis();
  if (!analysis.finder) return;
  const double step = c_.config.candidates.turn_step_deg, most = c_.config.candidates.max_turn_deg;
  for (planner::GraspCandidate& c : candidates) {
    if (c.verdict != planner::Verdict::Unreachable) continue;
    for (double turn = step; turn <= most && c.verdict == planner::Verdict::Unreachable; turn += step) {
      for (const double side : {1.0, -1.0}) {
        auto other = analysis.finder->turned(c, side * turn * hal::kRadPerDeg);
        if (!other || other->verdict != planner::Verdict::Ok || !c_.motion_planner.reach(*other, lift))
          continue;
        other->reason = fmt::format("the hand comes at {:.0f} deg to the face: straight, {}", turn, c.reason);
        c = *std::move(other);
        break;
      }
    }
  }
}

hal::Result<Outcome> GraspSelector::decide(const perception::PartnerGrasp& partner, const Config& config,
                                           const Judge& reach) const {
  auto outcome = decide_for(c_.session.analysis(), partner, config, c_.stopwatch, reach, c_.mass_kg());
  if (outcome && c_.session.tracker().is_unseen())
    outcome->partner_reason =
        "the object rose behind the partner's body, which hides his hand: where he holds it is an estimate";
  return outcome;
}

bool GraspSelector::choose() {
  auto grasp = c_.session.tracker().grasp();
  if (!grasp) return false;
  if (const auto& own = c_.options.policies.partner) grasp = own(c_.session.analysis(), *grasp);
  const Judge reach = [this](std::vector<planner::GraspCandidate>& more) {
    judge_reach(more);
    apply_refusals(more);
  };
  apply_refusals(c_.session.analysis().candidates);
  if (c_.test_lifts.known()) return choose_level(*grasp, reach);
  auto outcome = decide(*grasp, c_.config, reach);
  if (!outcome) {
    c_.attempts.failure = outcome.error().text();
    return false;
  }
  c_.record.decision = std::move(*outcome);
  if (!take_own_choice()) return false;
  test_beyond_limits();
  const planner::Decision& decision = c_.record.decision->decision;
  if (!decision.chosen) {
    // the rule says already that no grasp fits
    std::string& failure = c_.attempts.failure = decision.reason;
    if (failure.starts_with("no grasp: ")) failure.erase(0, 10);
  }
  return decision.chosen.has_value();
}

// A lift whose bounds are not within the limits is tried out by millimetres first.
void GraspSelector::test_beyond_limits() {
  Outcome& outcome = *c_.record.decision;
  const auto& certificate = outcome.share.certificate;
  if (c_.config.certificate.on_breach != "test" || !outcome.decision.chosen || !certificate) return;
  if (certificate->breaches.empty() || c_.config.test_lift.on) return;
  c_.config.test_lift.on = true;
  outcome.decision.reason += fmt::format("; a test lift first, because {} (95 %)", certificate->breach_text);
}

bool GraspSelector::take_own_choice() {
  const auto& own = c_.options.policies.choice;
  Outcome& outcome = *c_.record.decision;
  planner::Decision& decision = outcome.decision;
  if (!own || !decision.chosen) return true;
  const SceneAnalysis& analysis = c_.session.analysis();
  const auto wanted = own(analysis, outcome);
  if (!wanted || *wanted == *decision.chosen) return true;
  planner::GraspCandidate& mine = outcome.candidates[*decision.chosen];
  if (auto done = choose_instead(outcome, *wanted,
                                 fmt::format("the caller's choice in place of candidate {}", mine.id));
      !done) {
    c_.attempts.failure = decision.reason = done.error().text();
    mine.verdict = planner::Verdict::Ok;
    mine.reason.clear();
    decision.chosen.reset();
    return false;
  }
  outcome.share =
      share_contract(outcome, analysis, uncertain_scene(analysis, *outcome.partner, c_.config.decision),
                     c_.config, c_.mass_kg());
  say_share(outcome);
  refuse_beyond_limits(outcome, c_.config.certificate);
  return outcome.decision.chosen.has_value();
}

// After test lifts: where the object is most likely to hang level. Where nothing promises that, the best of
// what was borne so far.
bool GraspSelector::choose_level(const perception::PartnerGrasp& partner, const Judge& reach) {
  Config config = c_.config;
  config.decision.max_lever_m = config.test_lift.max_lever_m;
  config.decision.share_strict.reset();  // of the grasp that is chosen in the end
  // centimetres beside a grasp that did not hold it level another one does not either
  config.candidates.refine_steps = 0;
  const auto decide_with = [&](const hal::Vec3& cog) {
    hal::Vec3& believed = c_.session.analysis().scene.target->cog;
    const hal::Vec3 of_shape = std::exchange(believed, cog);
    auto outcome = decide(partner, config, reach);
    believed = of_shape;
    return outcome;
  };
  const TestLift& known = *c_.test_lifts.known();
  const double epsilon = c_.config.decision.weights.epsilon;
  const double wanted = 1.0 / (1.0 + epsilon * epsilon);
  const auto measured = c_.test_lifts.measured();
  const auto tried = std::count_if(measured.begin(), measured.end(), [&](const MeasuredLift& t) {
    return (t.partner - partner.position).norm() < c_.config.test_lift.same_partner_m;
  });
  std::optional<LevelGrip> grip;
  if (tried < c_.config.test_lift.grips)
    grip = choose_level_grip(decide_with, c_.test_lifts.object(), partner.position, measured, known.belief,
                             wanted, c_.config.test_lift);
  if (grip) {
    c_.record.decision = std::move(grip->outcome);
    return renew_share(partner, known);
  }
  c_.attempts.failure =
      fmt::format("after {} test lifts no other grasp promises to hold the object level: {}", measured.size(),
                  known.reason);
  if (auto outcome = decide_with(known.cog)) c_.record.decision = std::move(*outcome);
  planner::Decision& decision = c_.record.decision->decision;
  auto& candidates = c_.record.decision->candidates;
  if (decision.chosen) candidates[*decision.chosen].verdict = planner::Verdict::Ok;
  decision.chosen.reset();
  if (!bearable_) return false;
  candidates.push_back(bearable_->grasp);
  decision.scores.emplace_back();
  decision.chosen = candidates.size() - 1;
  decision.share = bearable_->share;
  decision.reason = fmt::format("grasp {}: the most level of {} test lifts, {:.1f} deg", bearable_->grasp.id,
                                measured.size(), bearable_->tilt_rad / hal::kRadPerDeg);
  if (!renew_share(partner, known)) return false;
  accepts_bearable_ = true;
  return true;
}

// A test lift judges tilt and slip by itself; what it tells of the mass is compared with what hands may bear.
std::optional<std::string> GraspSelector::too_heavy() const {
  const auto& certificate = c_.record.decision->share.certificate;
  if (!certificate || c_.config.certificate.on_breach == "report") return std::nullopt;
  for (const Certificate::Breach& b : certificate->breaches)
    if (b.of == Certificate::Breach::Of::Load || b.of == Certificate::Breach::Of::PartnerLoad)
      return "not lifted: " + certificate->breach_text + " (95 %)";
  return std::nullopt;
}

bool GraspSelector::renew_share(const perception::PartnerGrasp& partner, const TestLift& known) {
  Outcome& outcome = *c_.record.decision;
  planner::UncertainScene scene = uncertain_scene(c_.session.analysis(), partner, c_.config.decision);
  scene.cog = known.cog;
  scene.cog_covariance.topLeftCorner<2, 2>() = known.belief.covariance();
  auto refusal = planner::too_far_from_share(outcome.decision.share, c_.config.decision);
  if (refusal) outcome.decision.chosen.reset();
  outcome.share = share_contract(outcome, c_.session.analysis(), scene, c_.config, c_.mass_kg());
  if (!refusal) refusal = too_heavy();
  if (refusal) {
    outcome.decision.reason = *refusal;
    outcome.decision.refused_for_share = true;
    outcome.decision.chosen.reset();
  }
  say_share(outcome);
  if (refusal) c_.attempts.failure = outcome.decision.reason;
  return !refusal;
}

void GraspSelector::refuse_path(const std::string& why) {
  without_path_.push_back(c_.chosen());
  without_path_.back().reason = why;
}

bool GraspSelector::something_between() const {
  const double limit_rad =
      planner::stopped_angle(c_.rig.hand, c_.chosen(), c_.config.task.grip.max_excess_width_m);
  const auto& finger_rad = c_.readings.hand.finger_rad;
  return std::any_of(finger_rad.begin(), finger_rad.end(), [&](double q) { return q < limit_rad; });
}

void GraspSelector::refuse_grip(const std::string& why) {
  const planner::GraspCandidate& grasp = c_.chosen();
  failed_.push_back({grasp.position, std::nullopt, c_.config.task.attempts.failed_grip_radius_m,
                     planner::Verdict::Unstable, why});
  if (!reaches_behind(grasp, c_.config.candidates) || !something_between()) return;
  // a panel under the rim of a plate goes on along it
  failed_.back().from_depth_m = less_deep(grasp);
  failed_.push_back(
      {grasp.position, grasp.approach, INFINITY, planner::Verdict::Collision, why, less_deep(grasp)});
}

void GraspSelector::refuse_approach(const std::string& why) {
  const planner::GraspCandidate& grasp = c_.chosen();
  failed_.push_back({grasp.position, grasp.approach, c_.config.task.attempts.touched_radius_m,
                     planner::Verdict::Collision, why});
}

bool GraspSelector::FailedGrasp::covers(const planner::GraspCandidate& c) const {
  if (c.depth_m < from_depth_m) return false;
  return (c.position - position).norm() < radius_m && (!approach || approach->dot(c.approach) > kSameSide);
}

void GraspSelector::add_shallower(std::vector<planner::GraspCandidate>& candidates) {
  const SceneAnalysis& analysis = c_.session.analysis();
  if (!analysis.finder) return;
  std::vector<planner::GraspCandidate> more;
  int next_id = 0;
  for (const planner::GraspCandidate& c : candidates) next_id = std::max(next_id, c.id + 1);
  for (const planner::GraspCandidate& c : candidates) {
    if (c.verdict != planner::Verdict::Ok || !reaches_behind(c, c_.config.candidates)) continue;
    if (std::none_of(failed_.begin(), failed_.end(),
                     [&](const FailedGrasp& f) { return f.from_depth_m > -INFINITY && f.covers(c); }))
      continue;
    planner::GraspCandidate shallow = c;
    shallow.gap_m = c_.rig.hand.gap(c) + c.depth_m - c_.config.candidates.min_hold_depth_m;
    auto judged = analysis.finder->turned(shallow, 0.0);
    if (!judged || judged->verdict != planner::Verdict::Ok) continue;
    judged->id = next_id++;
    more.push_back(std::move(*judged));
  }
  judge_reach(more);
  candidates.insert(candidates.end(), std::make_move_iterator(more.begin()),
                    std::make_move_iterator(more.end()));
}

void GraspSelector::keep_bearable(double share, double tilt_rad) {
  if (!bearable_ || tilt_rad < bearable_->tilt_rad) bearable_ = {c_.chosen(), share, tilt_rad};
}

void GraspSelector::forget_bearable() {
  bearable_.reset();
  accepts_bearable_ = false;
}

void GraspSelector::object_moved(const hal::Pose& X_Wnow_Wthen) {
  if (bearable_) planner::move(bearable_->grasp, X_Wnow_Wthen);
  for (FailedGrasp& f : failed_) {
    f.position = X_Wnow_Wthen * f.position;
    if (f.approach) f.approach = X_Wnow_Wthen.linear() * *f.approach;
  }
}

}  // namespace colift::control
