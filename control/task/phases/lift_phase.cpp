#include "control/task/phases/lift_phase.hpp"
#include "hal/types/units.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace colift::control {
namespace {

constexpr double kMuchOfHis = 0.75;  // of the partner's load, taken over at once: he may have let go
constexpr double kSlowly_s = 0.1;    // from half of the way that counts as lowering to all of it
constexpr double kMeanLoad = 0.005;  // of a cycle in the slow mean of the load: some 200 cycles

}  // namespace

void LiftPhase::begin_lift(Task from) {
  c_.attempts.lifted = true;
  // he may hold his end lower than before
  if (from == Task::Pause) object_.forget_partner_top();
  evidence_.start_lift();
  from_ = from;
  raises_ = partner_lowers_ = false;
  (void)raised();
}

bool LiftPhase::raised() {
  if (raises_) return true;
  if (c_.role == LiftController::Role::Lead && !c_.may_begin(Motion::Lift)) return false;
  raises_ = true;
  const TaskConfig& task = c_.config.task;
  moved_at_ = c_.now;
  if (from_ == Task::TestLift || from_ == Task::Pause) {
    // what hung still when it was raised slowly is raised slowly
    const double left_m = task.lift_height_m - c_.arm.view().height_m;
    const bool tested = from_ == Task::TestLift || !c_.record.test_lifts.empty();
    lift_s_ = tested ? std::max(task.lift_s, left_m / task.lift.tested_speed_m_s) : task.lift_s;
    c_.arm.raise_on(c_.role, task.lift_height_m, lift_s_, c_.hand_line());
  } else {
    lift_s_ = task.lift_s;
    c_.arm.start_lift(c_.role, task.lift_height_m, lift_s_, c_.hand_line());
  }
  return true;
}

std::optional<TaskEvent> LiftPhase::lift() {
  object_.update();
  partner_.update();
  evidence_.update();
  if (auto gone = partner_.let_go()) return gone;
  if (auto end = object_.end_of_reach()) return end;
  if (!raised()) {
    c_.doing = "announces the lift";
    return std::nullopt;
  }
  const ArmView& arm = c_.arm.view();
  c_.done = arm.height_m / c_.config.task.lift_height_m;
  c_.doing =
      arm.role == LiftController::Role::Lead ? "lifts, the partner comes along" : "follows the partner";
  if (auto limit = object_.beyond_limits()) return limit;
  if (c_.in_state_s() > lift_s_ + c_.config.task.partner_timeout_s)
    return TaskEvent{Event::TimeOut,
                     fmt::format("{:.1f} cm after {:.0f} s", 1e2 * arm.height_m, c_.in_state_s())};
  if (!settled()) return std::nullopt;
  update_mean_load();
  if (auto lost = load_lost()) return lost;
  if (!load_settled()) return std::nullopt;
  return TaskEvent{Event::AtHeight, fmt::format("{:.1f} cm up, tilt {:.1f} deg, load {:.0f} N{}",
                                                1e2 * arm.height_m, hal::rad_to_deg(object_.tilt_rad()),
                                                arm.load_n, load_steady_ ? "" : ", which still changes")};
}

bool LiftPhase::settled() {
  if (!c_.arm.lift_at_rest()) {
    moved_at_ = updated_at_ = c_.now;
    steady_.start();
    start_mean_load();
    return false;
  }
  return hal::seconds(c_.now - moved_at_) >= c_.config.task.carry.settle_s;
}

bool LiftPhase::load_settled() {
  const CarryConfig& carry = c_.config.task.carry;
  const double load_n = c_.arm.view().load_n;
  steady_.update(load_n, hal::seconds(c_.now - updated_at_),
                 std::max(carry.steady_load_n, carry.steady_load_fraction * std::abs(load_n)));
  updated_at_ = c_.now;
  load_steady_ = steady_.steady_s() >= carry.steady_s;
  if (!load_steady_) c_.doing = "waits until the load has come to rest";
  return load_steady_ || hal::seconds(c_.now - moved_at_) >= carry.max_unsteady_s;
}

void LiftPhase::start_mean_load() {
  mean_load_n_ = NAN;
  carried_at_ = c_.now;
}

void LiftPhase::update_mean_load() {
  const double load_n = c_.arm.view().load_n;
  mean_load_n_ = std::isnan(mean_load_n_) ? load_n : mean_load_n_ + kMeanLoad * (load_n - mean_load_n_);
}

void LiftPhase::begin_hold() {
  start_mean_load();
  his_end_stays_at_ = c_.now;
  c_.record.frame_lifted.reset();
}

std::optional<TaskEvent> LiftPhase::hold() {
  const double hold_s = c_.config.task.hold_s;
  if (!c_.record.frame_lifted && c_.in_state_s() > 0.5 * hold_s) c_.record.frame_lifted = c_.picture();
  object_.update();
  partner_.update();
  evidence_.update();
  if (auto gone = partner_.let_go()) return gone;
  if (auto end = object_.end_of_reach()) return end;
  c_.done = c_.in_state_s() / std::max(hold_s, 1e-3);
  c_.doing = "holds the object up";
  if (c_.readings.frame)
    if (const auto load = summary_of_hold().load) share_robot_ = load->share_robot;
  if (auto limit = object_.beyond_limits()) return limit;
  if (auto partner = partner_gone_or_lowers()) return partner;
  if (auto lost = load_lost()) return lost;
  const bool over = object_.to_be_lowered();
  if (!over && c_.in_state_s() < hold_s - c_.config.task.intent_lead_s) return std::nullopt;
  if (!c_.may_begin(Motion::Lower) || (!over && c_.in_state_s() < hold_s)) return std::nullopt;
  return TaskEvent{Event::HoldOver, fmt::format("held for {:.1f} s", c_.in_state_s())};
}

std::optional<TaskEvent> LiftPhase::partner_gone_or_lowers() {
  const CarryConfig& carry = c_.config.task.carry;
  const double load_n = c_.arm.view().load_n;
  const bool fell =
      object_.motion() && object_.partner_fall_m() > std::max(carry.partner_fall_m, object_.end_noise_m());
  // what deviates quickly from the mean before it is news
  const bool heavier =
      load_n > carry.load_jump_factor * mean_load_n_ && load_n > mean_load_n_ + carry.load_jump_n;
  update_mean_load();
  // who follows goes down with him; who leads does so where his hand is seen to go down with his end, and
  // slowly: an end that he let go falls as far within a frame or two
  const bool follows = c_.arm.view().role == LiftController::Role::Follow;
  const double sunk_m = std::max(c_.config.task.lift.leader_rise_m, object_.end_noise_m());
  if (!object_.motion() || object_.partner_fall_m() < 0.5 * sunk_m) his_end_stays_at_ = c_.now;
  const bool sinks = object_.motion() && object_.partner_fall_m() > sunk_m && partner_.hand_stays() &&
                     hal::seconds(c_.now - his_end_stays_at_) > kSlowly_s;
  if (!heavier && (follows ? fell : sinks)) {
    partner_lowers_ = true;
    return TaskEvent{Event::HoldOver,
                     fmt::format("the partner lowers: his end by {:.0f} mm", 1e3 * object_.partner_fall_m())};
  }
  // a person who carries sways: an end that stays up is not let go for a few newtons, which are not nearly
  // all of what he bore
  const double his_n = std::max(mean_load_n_, 0.0) * (1.0 / c_.record.decision->decision.share - 1.0);
  const bool bears_his = load_n - mean_load_n_ > kMuchOfHis * his_n;
  const bool sways = partner_.his_end_is_up() && (partner_.hand_stays() || !bears_his);
  if (heavier && !sways)
    return TaskEvent{Event::PartnerLetGo, fmt::format("sudden gain of load: to {:.0f} N", load_n)};
  if (fell)
    return TaskEvent{Event::PartnerLetGo,
                     fmt::format("his end fell by {:.0f} mm", 1e3 * object_.partner_fall_m())};
  return std::nullopt;
}

std::optional<TaskEvent> LiftPhase::load_lost() {
  const CarryConfig& carry = c_.config.task.carry;
  const double load_n = c_.arm.view().load_n;
  if (mean_load_n_ < carry.standing_load_n || load_n > carry.load_loss_fraction * mean_load_n_)
    carried_at_ = c_.now;
  if (hal::seconds(c_.now - carried_at_) < carry.load_loss_s) return std::nullopt;
  return TaskEvent{
      Event::HandEmpty,
      fmt::format("sudden loss of load: {:.0f} N hang in the hand, {:.0f} N before", load_n, mean_load_n_)};
}

void LiftPhase::begin_lower() {
  const auto held = [](const LiftSample& c) { return c.state == Task::Hold; };
  if (std::any_of(c_.record.curve.begin(), c_.record.curve.end(), held)) c_.record.lift = summary_of_hold();
  share_robot_.reset();
  moved_at_ = unsupported_at_ = c_.now;
  seeks_ = found_ = lowers_ = false;
  // whoever comes here for a limit stands still while it is announced
  if (!lowered()) c_.arm.pause();
}

bool LiftPhase::lowered() {
  if (lowers_) return true;
  // he lowers already: nothing is left to be announced
  const bool follows = partner_lowers_ || c_.arm.view().role == LiftController::Role::Follow;
  if (!follows && !c_.may_begin(Motion::Lower)) return false;
  lowers_ = true;
  moved_at_ = unsupported_at_ = c_.now;
  c_.arm.lower();
  return true;
}

std::optional<TaskEvent> LiftPhase::lower() {
  object_.update();
  partner_.update();
  evidence_.update();
  if (auto gone = partner_.let_go()) return gone;
  if (auto end = object_.end_of_reach()) return end;
  if (!lowered()) {
    c_.doing = "announces that the object is lowered";
    return std::nullopt;
  }
  c_.done = 1.0 - c_.arm.view().height_m / std::max(c_.config.task.lift_height_m, 1e-3);
  c_.doing = seeks_ ? "sets the object down" : "lowers together with the partner";
  return judge_lowering();
}

std::optional<TaskEvent> LiftPhase::judge_lowering() {
  const ArmView& arm = c_.arm.view();
  const CarryConfig& carry = c_.config.task.carry;
  const double carried_n = std::isnan(mean_load_n_) ? 0.0 : mean_load_n_;
  const double limit_n = std::max(carry.standing_load_n, carry.standing_load_fraction * carried_n);
  // an object that slid in the hand is down before the palm is: pressed on, it would slide away. Without load
  // alone it may still hang between the partner and a foot
  const auto& motion = object_.motion();
  const double rise_m = motion ? motion->rise(object_.X_WH_grip().translation(), hal::Vec3::UnitZ()) : NAN;
  const bool seen_down = object_.seen_standing();
  if (arm.load_n > limit_n) unsupported_at_ = c_.now;
  const double supported_s = hal::seconds(c_.now - unsupported_at_);
  const bool early =
      motion && std::abs(rise_m) < carry.ground_tolerance_m && arm.load_n < carry.ground_load_n;
  // an arm that the ground pushed up is soft, and goes no farther down
  const bool comes_no_lower = seeks_ || c_.arm.lift_at_rest() || c_.arm.blocked();
  if (supported_s > carry.settle_s && seen_down && (early || comes_no_lower)) {
    c_.arm.pause();
    evidence_.standing();
    return TaskEvent{
        Event::OnGround,
        fmt::format("the hand {}, {:.0f} mm {} the height at which it grasped",
                    arm.load_n < 0.0 ? fmt::format("presses on it with {:.1f} N", -arm.load_n)
                                     : fmt::format("carries {:.1f} N (limit {:.1f})", arm.load_n, limit_n),
                    1e3 * std::abs(arm.height_m), arm.height_m < 0.0 ? "below" : "above")};
  }
  if (supported_s > carry.settle_s && !seen_down && c_.arm.lift_at_rest())
    return TaskEvent{Event::Obstructed,
                     fmt::format("the hand carries {:.1f} N, and the object is seen {:.0f} mm up", arm.load_n,
                                 1e3 * (motion ? std::max(rise_m, object_.partner_rise_m()) : arm.height_m))};
  if (c_.in_state_s() > lift_s_ + c_.config.task.partner_timeout_s)
    return TaskEvent{
        Event::TimeOut,
        fmt::format("the hand carries {:.0f} N (limit {:.0f}), and the object is seen {:.0f} mm up at "
                    "the hand, {:.0f} mm at the partner's end, after {:.0f} s",
                    arm.load_n, limit_n, 1e3 * rise_m, 1e3 * object_.partner_rise_m(), c_.in_state_s())};
  // at once when it stands: pressed on, a stiff object would push the hand up
  if (seeks_ && !found_ && arm.load_n <= limit_n) {
    found_ = true;
    c_.arm.stay();
  }
  const bool hangs_again = found_ && arm.load_n > limit_n && settled();
  if ((!seeks_ && c_.arm.lift_at_rest()) || hangs_again) {
    seeks_ = true;
    found_ = false;
    c_.arm.raise_on(LiftController::Role::Lead, -carry.seek_m, carry.seek_m / carry.seek_speed_m_s);
    moved_at_ = c_.now;
    return std::nullopt;
  }
  if (!seeks_ || found_ || !settled()) return std::nullopt;
  return TaskEvent{Event::TimeOut,
                   fmt::format("the hand still carries {:.0f} N, {:.0f} mm below where it grasped",
                               arm.load_n, 1e3 * carry.seek_m)};
}

KnownBefore LiftPhase::known_before() const {
  const planner::UncertainScene scene =
      uncertain_scene(c_.session.analysis(), *c_.record.decision->partner, c_.config.decision);
  KnownBefore known;
  known.cog = scene.cog;
  known.cog_covariance = scene.cog_covariance;
  known.partner = scene.partner;
  known.partner_covariance = scene.partner_covariance;
  known.grasp = planner::load_point(c_.chosen());
  known.mass_kg = c_.config.decision.known_mass_kg;
  if (const auto& tested = c_.test_lifts.known()) {
    known.cog = tested->cog;
    known.cog_covariance.topLeftCorner<2, 2>() = tested->belief.covariance();
    known.weighed = true;
  }
  return known;
}

// means over the time at the top
LiftSummary LiftPhase::summary_of_hold() const {
  LiftSummary s;
  s.load_steady = load_steady_;
  double load = 0.0;
  int n = 0, seen = 0;
  std::vector<CarriedSample> carried;
  for (const LiftSample& c : c_.record.curve) {
    if (c.state != Task::Hold) continue;
    if (c.X_WTnow_WTref) carried.push_back({c.wrench_W, c.palm_W, *c.X_WTnow_WTref});
    load += c.load_n;
    s.height_m += c.palm_height_m;
    ++n;
    if (std::isnan(c.tilt_rad)) continue;
    s.tilt_rad += c.tilt_rad;
    s.slip_m += c.slip_m;
    ++seen;
  }
  if (n == 0) return s;
  load /= n;
  s.load_n = load;
  s.height_m /= n;
  s.tilt_rad = seen ? s.tilt_rad / seen : NAN;
  s.slip_m = seen ? s.slip_m / seen : NAN;
  s.share_predicted = c_.record.decision->decision.share;
  if (auto known = balance_load(carried, known_before(), c_.config.load)) {
    s.mass_kg = known->mass_kg;
    s.share_robot = known->share_robot;
    s.load = *known;
  } else {
    s.load_reason = known.error().detail;
  }
  return s;
}

}  // namespace colift::control
