// From the first look to the hand at the grasp: nothing touches the object yet.

#include <fmt/format.h>

#include <algorithm>

#include "control/session/map_check.hpp"
#include "control/session/picture_check.hpp"
#include "control/session/suggest.hpp"
#include "control/task/job.hpp"
#include "control/test_lift/next_place.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

using perception::PartnerEvent;
using perception::PartnerKind;

constexpr double kSamePlace_m = 0.06;   // where a grip failed, none is tried again
constexpr double kSecondWait_s = 10.0;  // for a partner who was there already
constexpr int kTries = 8;               // grasps for which a way is looked for
constexpr int kApproaches = 5;          // a partner who changes his mind more often is left alone

std::string seconds_text(double s) {
  return fmt::format("{:.1f} s", s);
}

}  // namespace

std::optional<Happening> Job::observe() {
  if (frame_) watch_.add_reference(std::move(*frame_), posture());
  const int have = watch_.reference_frames(), want = config_.task.reference_frames;
  doing_ = fmt::format("{} of {} frames of the scene", have, want);
  done_ = static_cast<double>(have) / want;
  if (have < want) {
    if (in_state_s() > config_.task.patience_s)
      return Happening{Event::TimeOut, look_trouble_.empty()
                                           ? "the camera showed nothing for " + seconds_text(in_state_s())
                                           : look_trouble_};
    return std::nullopt;
  }
  if (auto seen = watch_.understand(posture()); !seen) {
    // somebody walked through the picture: another one, for a while
    if (seen.error().code == hal::ErrorCode::NotFound && in_state_s() < config_.task.patience_s) {
      watch_.forget_reference();
      doing_ = look_trouble_ = seen.error().detail;
      return std::nullopt;
    }
    const bool camera_off = seen.error().where == kCameraOff;
    return Happening{camera_off ? Event::CameraOff : Event::NothingToCarry, seen.error().detail};
  }
  Look& look = watch_.look();
  if (!look.scene.target) {
    record_.look = look;
    return Happening{Event::NothingToCarry, look.because};
  }
  if (auto holes = picture_trouble(look.cloud, *look.scene.target)) {
    // the sun may go behind a cloud
    if (in_state_s() < config_.task.patience_s) {
      watch_.forget_reference();
      doing_ = look_trouble_ = *std::move(holes);
      return std::nullopt;
    }
    record_.look = look;
    return Happening{Event::NothingToCarry, *std::move(holes)};
  }
  take_look();
  return Happening{Event::SceneKnown, record_.look->because};
}

void Job::take_look() {
  Look& look = watch_.look();
  planner_->set_scene(std::make_shared<planner::CollisionScene>(planner::make_collision_scene(
                          watch_.map(), look.scene.ground->plane, {}, config_.motion.scene)),
                      watch_.map(), hal::Vec3::UnitZ());
  judge_reach(look.candidates);
  look.because = planner::explain(look.candidates);
  record_.look = look;
  judged_.clear();
}

std::optional<PartnerEvent> Job::watch_partner() {
  // what comes late and steadily is slow, not silent: the arm's pace answers for that
  if (!frame_) return watch_.no_frame(now_ - picture_late_);
  auto sight = watch_.watch_partner(*frame_, posture());
  if (!sight) {
    partner_note_ = sight.error().detail;
    return std::nullopt;
  }
  partner_note_ = sight->partner.because;
  if (sight->event) partner_note_ = sight->event->because;
  see_ms_ = sight->compute_ms;
  return sight->event;
}

std::optional<Happening> Job::await_partner() {
  const auto event = watch_partner();
  if (asked_ && stays_where_he_was()) {
    doing_ = asked_->because;
  } else if (event && event->kind == PartnerEvent::Kind::Grasped) {
    if (asked_) {  // what could be borne, could be borne with him elsewhere
      asked_.reset();
      bearable_.reset();
      accepts_bearable_ = false;
    }
    return Happening{Event::PartnerGrasped, event->because};
  } else {
    doing_ = partner_note_;
  }
  const double waited = hal::seconds(now_ - waits_since_);
  const double patience =
      moved_ && !asked_ ? std::min(kSecondWait_s, config_.task.patience_s) : config_.task.patience_s;
  if (waited > patience && asked_)
    return Happening{Event::NobodyCame, fmt::format("not where he was asked to, within {}: {}",
                                                    seconds_text(waited), asked_->why)};
  if (waited > patience)
    return Happening{Event::NobodyCame,
                     fmt::format("nobody took hold of the object within {}{}{}", seconds_text(waited),
                                 partner_note_.empty() ? "" : "; last seen: ", partner_note_)};
  return std::nullopt;
}

void Job::apply_refusals(std::vector<planner::GraspCandidate>& candidates) const {
  for (auto& c : candidates)
    for (const auto& r : refused_)
      if ((c.position - r.position).norm() < 1e-6 && c.approach.dot(r.approach) > 1.0 - 1e-9)
        c.verdict = planner::Verdict::Unreachable, c.because = r.because;
  for (auto& c : candidates)
    for (const auto& f : failed_grips_)
      if ((c.position - f.position).norm() < kSamePlace_m)
        c.verdict = planner::Verdict::Unstable, c.because = f.why;
}

void Job::judge_reach(std::vector<planner::GraspCandidate>& candidates) {
  const double lift = config_.task.lift_height_m;
  planner_->judge(candidates, lift);
  const Look& look = watch_.look();
  if (look.method != Method::Fast || !look.finder) return;
  const double step = config_.candidates.turn_step_deg, most = config_.candidates.max_turn_deg;
  for (planner::GraspCandidate& c : candidates) {
    if (c.verdict != planner::Verdict::Unreachable) continue;
    for (double turn = step; turn <= most && c.verdict == planner::Verdict::Unreachable; turn += step) {
      for (const double side : {1.0, -1.0}) {
        auto other = look.finder->turned(c, hal::deg_to_rad(side * turn));
        if (!other || other->verdict != planner::Verdict::Ok || !planner_->reach(*other, lift)) continue;
        other->because =
            fmt::format("the hand comes at {:.0f} deg to the face: straight, {}", turn, c.because);
        c = *std::move(other);
        break;
      }
    }
  }
}

bool Job::choose() {
  const auto grasp = watch_.tracker().grasp();
  if (!grasp) return false;
  const Judge reach = [this](std::vector<planner::GraspCandidate>& more) {
    judge_reach(more);
    apply_refusals(more);
  };
  apply_refusals(watch_.look().candidates);
  if (tests_.known()) return choose_level(*grasp, reach);
  auto outcome = decide_for(watch_.look(), *grasp, config_, stopwatch_, reach);
  if (!outcome) {
    failed_because_ = outcome.error().text();
    return false;
  }
  record_.decision = std::move(*outcome);
  if (!record_.decision->decision.chosen) {
    // the rule says already that no grasp fits
    failed_because_ = record_.decision->decision.because;
    if (failed_because_.starts_with("no grasp: ")) failed_because_.erase(0, 10);
  }
  return record_.decision->decision.chosen.has_value();
}

bool Job::stays_where_he_was() const {
  const auto grasp = watch_.tracker().grasp();
  const double near_m = std::min(kSamePlace_m, 0.5 * (asked_->to - asked_->from).norm());
  return grasp && (grasp->position - asked_->from).norm() < near_m;
}

// Where no grasp fits, the partner may be able to help; failed_because_ says so either way.
bool Job::ask_partner() {
  if (!record_.decision || !record_.decision->partner) return false;
  const hal::Vec3 from = record_.decision->partner->position;
  hal::Vec3 to;
  std::string request;
  if (tests_.known()) {
    std::vector<hal::Vec3> held{from};
    for (const FeltLift& t : tests_.felt()) held.push_back(t.partner);
    const auto place = next_place(judged_, judged_, held, tests_.known()->belief, config_.test_lift);
    if (!place) return false;
    to = place->position, request = place->because;
  } else {
    const Look& look = watch_.look();
    const auto better = suggest_to_partner(*record_.decision, look.candidates, look.scene.target->cog,
                                           hal::Vec3::UnitZ(), config_.decision);
    if (!better) return false;
    to = better->position, request = better->because;
  }
  failed_because_ += "; " + request;
  const int most = tests_.known() ? config_.test_lift.asks : config_.task.asks;
  if (options_.dry_run || times_asked_ >= most) return false;
  ++times_asked_;
  asked_ = {from, to, request, failed_because_};
  record_.asked.push_back({now_ - began_, to, request});
  return true;
}

std::optional<Happening> Job::decide() {
  if (frame_) record_.frame_partner = *frame_;
  const hal::Timestamp start = stopwatch_.now();
  const bool chosen = choose();
  record_.timing.decision_compute_ms = see_ms_ + 1e3 * hal::seconds(stopwatch_.now() - start);
  record_.timing.grasp_to_decision_s = hal::seconds(now_ - watch_.tracker().since());
  if (!chosen) return Happening{ask_partner() ? Event::PartnerAsked : Event::NoGraspFits, failed_because_};
  return Happening{Event::GraspChosen, record_.decision->decision.because};
}

std::optional<Happening> Job::plan() {
  auto happening = find_way();
  watch_.looked_away(robot_.clock->now() - now_);
  return happening;
}

Happening Job::find_way() {
  const hal::Timestamp start = stopwatch_.now();
  if (auto trouble = map_trouble(watch_.map(), watch_.look().cloud))
    return Happening{Event::NoWay, *std::move(trouble)};
  planner_->set_scene(
      std::make_shared<planner::CollisionScene>(planner::make_collision_scene(
          watch_.map(), watch_.look().scene.ground->plane, watch_.partner_points(), config_.motion.scene)),
      watch_.map(), hal::Vec3::UnitZ());
  std::string why;
  for (int i = 0; i < kTries; ++i) {
    auto& candidates = record_.decision->candidates;
    auto& chosen = candidates[*record_.decision->decision.chosen];
    auto plan = planner_->plan(loop_.commanded(), chosen, config_.task.lift_height_m);
    if (plan) {
      record_.timing.plan_ms = 1e3 * hal::seconds(stopwatch_.now() - start);
      record_.plan = std::move(*plan);
      if (options_.dry_run) return Happening{Event::NoWay, "a dry run ends here: nothing was moved"};
      return Happening{Event::PlanReady,
                       fmt::format("the way takes {:.1f} s",
                                   record_.plan->transit.duration_s() + record_.plan->approach.duration_s())};
    }
    why = plan.error().detail;
    // the next best, then: this one stays refused for the rest of this decision
    refused_.push_back(chosen);
    refused_.back().because = why;
    if (!choose()) break;
  }
  record_.timing.plan_ms = 1e3 * hal::seconds(stopwatch_.now() - start);
  return Happening{Event::NoWay, why};
}

bool Job::follow(const planner::Trajectory& way) {
  if (way.empty()) return true;
  const auto started = loop_.follow(way);
  if (!started) failed_because_ = started.error().detail;
  return started.has_value();
}

std::optional<Happening> Job::approach() {
  const planner::MotionPlan& plan = *record_.plan;
  const auto event = watch_partner();
  if (event && event->kind != PartnerEvent::Kind::Grasped) {
    const bool moved = event->kind == PartnerEvent::Kind::Moved;
    return Happening{moved ? Event::PartnerMoved : Event::PartnerLetGo, event->because};
  }
  if (loop_.blocked()) return Happening{Event::Blocked, loop_.why_blocked()};
  if (leg_ < 0) return Happening{Event::Blocked, failed_because_};
  const double whole = plan.transit.duration_s() + plan.approach.duration_s();
  const double behind = leg_ == 0 ? loop_.progress() * plan.transit.duration_s()
                                  : plan.transit.duration_s() + loop_.progress() * plan.approach.duration_s();
  done_ = whole > 0.0 ? behind / whole : 1.0;
  doing_ = leg_ == 0 ? "on the way to the pre-grasp" : "straight to the grasp";
  if (in_state_s() > 2.0 * whole / config_.task.slow_part + 5.0)
    return Happening{Event::TimeOut, "the way takes too long"};
  if (hand_.moving || !loop_.done()) return std::nullopt;
  if (leg_ == 0) {
    leg_ = 1;
    loop_.end_tare();
    if (!follow(plan.approach)) return Happening{Event::Blocked, failed_because_};
    return std::nullopt;
  }
  return Happening{Event::Arrived, ""};
}

std::optional<Happening> Job::halt() {
  if (!camera_lost_) return Happening{Event::CameraBack, ""};
  if (in_state_s() > config_.task.patience_s) return Happening{Event::TimeOut, ""};
  return std::nullopt;
}

std::optional<Happening> Job::back_off() {
  // the partner may take hold again meanwhile; that is seen once the way is clear
  (void)watch_partner();
  if (in_state_s() > 60.0) return Happening{Event::TimeOut, "the way back takes too long"};
  const bool in_vain = approaches_ >= kApproaches + static_cast<int>(record_.test_lifts.size());
  const auto back = [&](const char* where) {
    return Happening{in_vain ? Event::BackInVain : Event::BackHome, where};
  };
  if (leg_ == 2) {  // braking
    if (!loop_.at_rest()) return std::nullopt;
    if (off_because_ == Event::PartnerMoved && !was_near_ && !in_vain)
      return back("at rest, clear of the object");
    loop_.back(kBackSpeed);
    leg_ = 3;
    return std::nullopt;
  }
  if (loop_.blocked()) return Happening{Event::Blocked, loop_.why_blocked()};
  if (!loop_.done() || !loop_.at_rest()) return std::nullopt;
  if (leg_ == 3 && was_near_) {
    // clear of the object: who only moved his hand is followed from here
    if (off_because_ == Event::PartnerMoved && !in_vain) return back("clear of the object");
    leg_ = 4;
    if (!follow(record_.plan->home)) return Happening{Event::Blocked, failed_because_};
    return std::nullopt;
  }
  return back("back where it started");
}

}  // namespace colift::control
