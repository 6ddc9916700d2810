// From the closing hand to the way home: the object is held, or about to be.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "control/task/job.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

constexpr double kHandPatience_s = 8.0;  // initialisation and full strokes take under 4 s
constexpr double kOpen_rad = 0.1;
constexpr double kSettle_s = 0.3;        // after a motion, before its end is believed
constexpr double kLeaderRise_m = 0.008;  // the partner's end rose by this: he leads
constexpr double kFingerTolerance_rad = 0.45;
constexpr int kInARow = 3;          // frames that have to agree before a limit ends a lift
constexpr double kFell_m = 0.02;    // the partner's end came down by this while held: he let go
constexpr double kLetGoLoad = 1.4;  // ... or the load grew by this factor
constexpr double kLetGoLoad_n = 6.0;
constexpr double kReadyPatience_s = 20.0;
constexpr int kGrips = 2;           // a grip that failed is tried elsewhere, once
constexpr double kMoved_m = 0.004;  // an object that moved by more stands in another scene
constexpr double kGravity_m_s2 = 9.81;
constexpr double kStands_m = 0.002, kBearsItself_n = 0.5;

// The joint with the least way left to one of its limits, in words.
std::string nearest_limit(const hal::RobotModel& model, const hal::JointVector& q_rad) {
  const hal::JointVector to_lower = q_rad - model.lower_rad(), to_upper = model.upper_rad() - q_rad;
  Eigen::Index joint = 0;
  const double left_rad = to_lower.cwiseMin(to_upper).minCoeff(&joint);
  return fmt::format("A{} is {:.1f} deg from its limit", joint + 1, hal::rad_to_deg(left_rad));
}

}  // namespace

std::optional<Happening> Job::close() {
  doing_ = "the fingers close";
  const auto partner = watch_partner();
  if (partner && partner->kind == perception::PartnerEvent::Kind::LetGo)
    return Happening{Event::PartnerLetGo, partner->because};
  if (in_state_s() > kHandPatience_s) return Happening{Event::HandEmpty, "the hand does not come to rest"};
  if (hand_.moving || in_state_s() < 0.1) return std::nullopt;
  if (!hand_.held) return Happening{Event::HandEmpty, "the fingers met nothing"};
  return Happening{Event::HandHeld, "every finger is stopped by the object"};
}

std::optional<Happening> Job::verify() {
  const auto partner = watch_partner();
  if (partner && partner->kind == perception::PartnerEvent::Kind::LetGo)
    return Happening{Event::PartnerLetGo, partner->because};
  // still for a moment, and as wide as the object was seen to be
  if (in_state_s() < kSettle_s) return std::nullopt;
  const auto& chosen = record_.decision->candidates[*record_.decision->decision.chosen];
  const double expected = planner::stopped_angle(rig_.hand, chosen);
  double widest = 0.0;
  for (const double q : hand_.finger_rad) widest = std::max(widest, std::abs(q - expected));
  double force = 0.0;
  for (const double f : hand_.tip_force_n) force += std::isnan(f) ? 0.0 : f;
  const std::string facts =
      fmt::format("fingers within {:.0f} deg of the seen width, pads press with {:.0f} N",
                  hal::rad_to_deg(widest), force);
  if (!hand_.held) return Happening{Event::GripBad, "the grip was lost: " + facts};
  if (widest > kFingerTolerance_rad)
    return Happening{Event::GripBad, "that is not the seen object: " + facts};
  return Happening{Event::GripGood, facts};
}

void Job::watch_object() {
  if (!frame_) return;
  motion_ = watch_.watch_object(*frame_, posture());
  const hal::Vec3 up = hal::Vec3::UnitZ();
  LiftSample sample;
  sample.t_s = hal::seconds(now_ - began_);
  sample.state = state_;
  const hal::Pose X_WH = palm();
  sample.palm_height_m = X_WH.translation().z() - X_WH_closed_.translation().z();
  sample.load_n = loop_.view().load_n;
  sample.object_rise_m = sample.tilt_rad = sample.slip_m = NAN;
  if (motion_) {
    const hal::Vec3 grasp = X_WH_closed_.translation();
    partner_rise_m_ = motion_->rise(record_.decision->partner->position, up);
    partner_top_m_ = std::max(partner_top_m_, partner_rise_m_);
    tilt_rad_ = motion_->tilt(up);
    // along the lift: across it a flat or round object may not show how far it went
    slip_m_ = std::abs(motion_->rise(grasp, up) - (X_WH.translation() - grasp).dot(up));
    sample.object_rise_m = motion_->rise(watch_.look().scene.target->cog, up);
    sample.tilt_rad = tilt_rad_;
    sample.slip_m = slip_m_;
    loop_.see_partner(partner_rise_m_);
    tilting_ = hal::rad_to_deg(tilt_rad_) > config_.task.max_tilt_deg ? tilting_ + 1 : 0;
    slipping_ = slip_m_ > config_.task.max_slip_m ? slipping_ + 1 : 0;
  }
  record_.curve.push_back(sample);
}

std::optional<Happening> Job::await_ready() {
  watch_object();
  doing_ = "watches whether the partner is ready";
  if (!hand_.held) return Happening{Event::HandEmpty, "the hand has lost the object"};
  if (hand_.hot) return Happening{Event::GripBad, hand_.warning.str()};
  if (motion_ && partner_rise_m_ > kLeaderRise_m) {
    role_ = LiftController::Role::Follow;
    return Happening{
        Event::PartnerReady,
        fmt::format("the partner lifts already, by {:.0f} mm: the robot follows", 1e3 * partner_rise_m_)};
  }
  if (frame_ && (!motion_ || std::abs(partner_rise_m_) < kLeaderRise_m)) {
    const auto event = watch_partner();
    if (event && event->kind == perception::PartnerEvent::Kind::LetGo)
      return Happening{Event::PartnerLetGo, event->because};
  }
  if (in_state_s() > kReadyPatience_s) return Happening{Event::TimeOut, "the partner does not come to rest"};
  if (in_state_s() < config_.task.ready_s ||
      watch_.tracker().state() != perception::PartnerTracker::State::Holding)
    return std::nullopt;
  role_ = LiftController::Role::Lead;
  return Happening{config_.test_lift.on ? Event::TestDue : Event::PartnerReady,
                   fmt::format("the partner has held still for {:.1f} s: the robot leads", in_state_s())};
}

std::optional<Happening> Job::beyond_limits() const {
  if (!hand_.held) return Happening{Event::HandEmpty, "the hand has lost the object"};
  // it has gripped up by itself already
  if (hand_.slips) return Happening{Event::HandUnfit, "the fingers feel the object slip"};
  if (hand_.hot) return Happening{Event::HandUnfit, hand_.warning.str()};
  if (tilting_ >= kInARow)
    return Happening{Event::LimitReached, fmt::format("the object tilts by {:.1f} deg (limit {:.1f})",
                                                      hal::rad_to_deg(tilt_rad_), config_.task.max_tilt_deg)};
  if (slipping_ >= kInARow)
    return Happening{Event::LimitReached, fmt::format("the object slips {:.0f} mm in the hand (limit {:.0f})",
                                                      1e3 * slip_m_, 1e3 * config_.task.max_slip_m)};
  if (loop_.view().load_n > config_.task.max_load_n)
    return Happening{Event::LimitReached, fmt::format("the load of {:.0f} N is above the limit of {:.0f} N",
                                                      loop_.view().load_n, config_.task.max_load_n)};
  return std::nullopt;
}

std::optional<Happening> Job::serve_lift() const {
  if (!loop_.end_of_reach()) return std::nullopt;
  return Happening{Event::EndOfReach,
                   fmt::format("{:.1f} cm up, the palm cannot go on straight: {}",
                               1e2 * loop_.view().height_m, nearest_limit(rig_.model, loop_.commanded()))};
}

std::optional<Happening> Job::lift() {
  watch_object();
  if (auto stuck = serve_lift()) return stuck;
  done_ = loop_.view().height_m / config_.task.lift_height_m;
  doing_ = loop_.view().role == LiftController::Role::Lead ? "lifts, the partner comes along"
                                                           : "follows the partner";
  if (auto limit = beyond_limits()) return limit;
  if (in_state_s() > lift_s_ + config_.task.patience_s)
    return Happening{Event::TimeOut,
                     fmt::format("{:.1f} cm after {:.0f} s", 1e2 * loop_.view().height_m, in_state_s())};
  if (!loop_.lift_at_rest()) {
    settled_at_ = now_;
    return std::nullopt;
  }
  if (hal::seconds(now_ - settled_at_) < kSettle_s) return std::nullopt;
  return Happening{Event::AtHeight,
                   fmt::format("{:.1f} cm up, tilt {:.1f} deg, load {:.0f} N", 1e2 * loop_.view().height_m,
                               hal::rad_to_deg(tilt_rad_), loop_.view().load_n)};
}

std::optional<Happening> Job::hold() {
  if (frame_ && !record_.frame_lifted && in_state_s() > 0.5 * config_.task.hold_s)
    record_.frame_lifted = *frame_;
  watch_object();
  if (auto stuck = serve_lift()) return stuck;
  done_ = in_state_s() / std::max(config_.task.hold_s, 1e-3);
  doing_ = "holds the object up";
  if (auto limit = beyond_limits()) return limit;
  const double load = loop_.view().load_n;
  // slow mean of the load; what deviates quickly is news
  const double a = std::isnan(hold_load_n_) ? 1.0 : 0.005;
  if (std::isnan(hold_load_n_)) hold_load_n_ = load;
  const bool fell = motion_ && partner_top_m_ - partner_rise_m_ > kFell_m;
  const bool heavier = load > kLetGoLoad * hold_load_n_ && load > hold_load_n_ + kLetGoLoad_n;
  hold_load_n_ += a * (load - hold_load_n_);
  if (loop_.view().role == LiftController::Role::Follow && fell && !heavier)
    return Happening{Event::HoldOver, "the partner lowers"};
  if (fell || heavier)
    return Happening{Event::PartnerLetGo, heavier ? fmt::format("the load grew to {:.0f} N", load)
                                                  : fmt::format("his end fell by {:.0f} mm",
                                                                1e3 * (partner_top_m_ - partner_rise_m_))};
  if (in_state_s() < config_.task.hold_s) return std::nullopt;
  return Happening{Event::HoldOver, fmt::format("held for {:.1f} s", in_state_s())};
}

std::optional<Happening> Job::lower() {
  watch_object();
  if (auto stuck = serve_lift()) return stuck;
  done_ = 1.0 - loop_.view().height_m / std::max(config_.task.lift_height_m, 1e-3);
  doing_ = "lowers together with the partner";
  // an object that slid in the hand is down before the palm is: pressed on, it would slide away. Without load
  // alone it may still hang between the partner and a foot
  const hal::Vec3 grasp = X_WH_closed_.translation();
  const bool down = motion_ && std::abs(motion_->rise(grasp, hal::Vec3::UnitZ())) < kStands_m;
  if (!down || loop_.view().load_n > kBearsItself_n) unloaded_since_ = now_;
  if (hal::seconds(now_ - unloaded_since_) > kSettle_s) {
    loop_.stay();
    return Happening{Event::OnGround, fmt::format("it bears itself, {:.0f} mm above where it was gripped",
                                                  1e3 * loop_.view().height_m)};
  }
  if (!loop_.lift_at_rest()) {
    settled_at_ = now_;
    return std::nullopt;
  }
  if (hal::seconds(now_ - settled_at_) < kSettle_s) return std::nullopt;
  return Happening{Event::OnGround, fmt::format("the load is {:.0f} N", loop_.view().load_n)};
}

std::optional<Happening> Job::release() {
  doing_ = "the fingers open";
  if (in_state_s() > kHandPatience_s) return Happening{Event::TimeOut, "the hand does not open"};
  if (hand_.moving || hand_.held || in_state_s() < 0.2) return std::nullopt;
  // a finger that stayed around the object would drag it along; of one that does not answer nobody knows
  bool open = true;
  for (std::size_t f = 0; f < hand_.finger_rad.size(); ++f)
    open = open && (hand_.finger_rad[f] < kOpen_rad || f == without_puck_);
  if (!open) return std::nullopt;
  return Happening{Event::HandOpen, without_puck_ ? "as far as it answers" : ""};
}

void Job::back_to_pre_grasp() {
  // from where the arm is commanded now, which is the grasp but for what lift and lowering left over
  std::vector<hal::JointVector> points{loop_.commanded()};
  const planner::Trajectory& way = record_.plan->retreat;
  const double s = way.duration_s();
  constexpr int kPoints = 12;
  for (int i = 1; i <= kPoints; ++i) points.push_back(way.sample(s * i / kPoints).q_rad);
  planner::MotionLimits limits;
  limits.velocity_rad_s = limits.velocity_rad_s.cwiseMin(0.9 * config_.guard_arm.max_velocity_rad_s);
  auto back = planner::make_trajectory_along(points, limits, s);
  if (!back || !follow(*back)) failed_because_ = back ? failed_because_ : back.error().detail;
}

// how far the object stands from where the scene was seen, on which everything was decided
double Job::object_moved_m() const {
  if (!motion_) return 0.0;
  double most_m = 0.0;
  // a turn shows at the corners
  const hal::OrientedBox& box = watch_.look().scene.target->obb;
  for (int corner = 0; corner < 8; ++corner) {
    const hal::Vec3 half(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
    const hal::Vec3 p = box.center + box.axes * box.size.cwiseProduct(half);
    most_m = std::max(most_m, (motion_->X_WTnow_WTref * p - p).norm());
  }
  return most_m;
}

// where a grip failed, none is tried again
void Job::refuse_grip(const std::string& why) {
  const auto& chosen = record_.decision->candidates[*record_.decision->decision.chosen];
  failed_grips_.push_back({chosen.position, why});
}

std::optional<Happening> Job::retreat() {
  doing_ = leg_ == 0 ? "straight back" : "home";
  if (loop_.blocked()) return Happening{Event::Blocked, loop_.why_blocked()};
  if (in_state_s() > 60.0) return Happening{Event::TimeOut, "the way home takes too long"};
  watch_object();
  if (!loop_.done() || !loop_.at_rest()) return std::nullopt;
  if (leg_ == 0) {
    leg_ = 1;
    const auto& home = record_.plan->home;
    if ((home.goal() - home_rad_).norm() < 1e-3) {
      if (!follow(home)) return Happening{Event::Blocked, failed_because_};
      return std::nullopt;
    }
    auto way = planner_->plan_to(loop_.commanded(), home_rad_);
    if (!way || !follow(*way)) return Happening{Event::Blocked, way ? failed_because_ : way.error().detail};
    return std::nullopt;
  }
  if (!failed_) return Happening{Event::BackHome, ""};
  const double moved_m = object_moved_m();
  const int grips = kGrips + static_cast<int>(record_.test_lifts.size());
  if (!regrasp_ && (approaches_ >= grips || lifted_ || without_puck_))
    return Happening{Event::BackInVain, failed_because_};
  if (moved_m > kMoved_m)
    if (const std::string trouble = take_scene_as_moved(); !trouble.empty())
      return Happening{Event::BackInVain, fmt::format("{}; the object stands {:.0f} mm from where it was: {}",
                                                      failed_because_, 1e3 * moved_m, trouble)};
  return Happening{Event::TryAgain, failed_because_};
}

void Job::summarise_hold() {
  // means over the time at the top
  LiftSummary s;
  double load = 0.0;
  int n = 0, seen = 0;
  for (const LiftSample& c : record_.curve) {
    if (c.state != Task::Hold) continue;
    load += c.load_n;
    s.height_m += c.palm_height_m;
    ++n;
    if (std::isnan(c.tilt_rad)) continue;
    s.tilt_rad += c.tilt_rad;
    s.slip_m += c.slip_m;
    ++seen;
  }
  if (n == 0) return;
  load /= n;
  s.height_m /= n;
  s.tilt_rad = seen ? s.tilt_rad / seen : NAN;
  s.slip_m = seen ? s.slip_m / seen : NAN;
  s.share_predicted = record_.decision->decision.share;
  // what the robot bears says the mass when the lever is known: the centre of gravity between both hands
  const hal::Vec3 grasp = X_WH_closed_.translation(), partner = record_.decision->partner->position;
  const Eigen::Vector2d span = (grasp - partner).head<2>();
  const hal::Vec3& cog = tests_.known() ? tests_.known()->cog : watch_.look().scene.target->cog;
  const double lever = (cog - partner).head<2>().dot(span) / span.squaredNorm();
  if (lever > 0.05) s.mass_kg = load / (kGravity_m_s2 * lever);
  const double mass = options_.known_mass_kg > 0.0 ? options_.known_mass_kg : s.mass_kg;
  if (mass > 0.0) s.share_robot = load / (mass * kGravity_m_s2);
  record_.lift = s;
}

}  // namespace colift::control
