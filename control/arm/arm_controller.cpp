#include "control/arm/arm_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace colift::control {
namespace {

// Of the arm's cycle. What couples the joints comes over the link, one and a half cycles late: a spring of K
// N m/rad that is late by T takes K T from the damping, at 5 ms less than half of what the controller gives a
// wrist of 0.05 kg m^2.
constexpr double kMaxPeriod_s = 0.0055;

hal::ArmAbilities within(hal::ArmAbilities can, const hal::RobotModel& model, const SetpointLimits& limits) {
  can.max_superposed_nm = can.max_superposed_nm.cwiseMin(model.effort_nm()).cwiseMin(limits.superposed_nm);
  return can;
}

// Of what a joint may give: the arm may be pushed on before the controller gets the command.
constexpr double kOfEffort = 0.9;

// Somebody who pushes an arm far away from its set point stretches springs beyond what a joint gives, at
// which the controller ends the command mode: there the spring yields.
void limit_torque(hal::ImpedanceCommand& c, const hal::JointVector& q_rad,
                  const hal::JointVector& effort_nm) {
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double off_rad = c.q_rad[i] - q_rad[i], most_nm = kOfEffort * effort_nm[i];
    const double asked_nm = c.stiffness_nm_rad[i] * off_rad + c.tau_superposed_nm[i];
    if (!(std::abs(asked_nm) > most_nm)) continue;  // nor where the position is not known
    const double over_nm = asked_nm - std::copysign(most_nm, asked_nm);
    if (over_nm * off_rad > 0.0) c.stiffness_nm_rad[i] -= std::min(c.stiffness_nm_rad[i], over_nm / off_rad);
  }
}

}  // namespace

bool moves(ArmRequest::Kind kind) {
  using Kind = ArmRequest::Kind;
  return kind == Kind::Hold || kind == Kind::Follow || kind == Kind::Resume || kind == Kind::Back ||
         kind == Kind::StartLift || kind == Kind::RaiseOn || kind == Kind::Stay || kind == Kind::Lower ||
         kind == Kind::ResumeLift || kind == Kind::Pause || kind == Kind::Yield;
}

std::string describe_stall(const ArmView& view) {
  return fmt::format("the job's thread did not run for {:.2f} s: the arm stopped by itself", view.stall_s);
}

ArmController::ArmController(const hal::RobotModel& model, const planner::ArmGeometry& arm,
                             const TaskConfig& task, const LoadConfig& load, const SetpointLimits& limits,
                             const ForceMonitorConfig& force, const hal::ArmAbilities& abilities)
    : model_(&model),
      setpoints_(model, task, limits),
      load_(model, load),
      lift_(model, arm, task),
      palm_(model, task.lift.cartesian, task.stiffness_nm_rad, within(abilities, model, limits),
            limits.torque_slope_nm_s),
      palm_springs_(task.lift.control == "cartesian_impedance" && abilities.joint_impedance &&
                    abilities.superposed_torque),
      energy_allowed_j_(task.max_load_n * task.lift_height_m + task.lift.energy_margin_j),
      energy_band_j_(task.lift.energy_band_j),
      force_(model, force),
      yield_(force),
      stiffness_nm_rad_(task.stiffness_nm_rad),
      yield_stiffness_nm_rad_(std::min(force.yield_stiffness_nm_rad, task.stiffness_nm_rad)),
      yield_slope_nm_rad_s_(force.yield_slope_nm_rad_s),
      beat_timeout_s_(task.supervision.beat_timeout_s) {}

void ArmController::measured(const hal::Result<hal::ArmState>& state) {
  if (!state) {
    ++view_.missed;
    ++view_.misses;
    view_.link_lost = state.error().code != hal::ErrorCode::Timeout;
    view_.fault.set(state.error().text());
    return;
  }
  ++view_.cycles;
  view_.misses = 0;
  view_.link_lost = false;
  view_.state = *state;
  load_.update(state->measured_at, state->q_rad, state->tau_external_nm);
}

void ArmController::take(const ArmRequest& request) {
  using Kind = ArmRequest::Kind;
  view_.answered = request.id;
  if (moves(request.kind) && request.kind != Kind::Hold) view_.stalled = false;
  switch (request.kind) {
    case Kind::Hold:
      lifting_ = false;
      setpoints_.hold();
      break;
    case Kind::Follow:
      lifting_ = false;
      end_yield();
      view_.trajectory_refused = !setpoints_.follow(request.trajectory);
      break;
    case Kind::Resume:
      lifting_ = false;
      end_yield();
      view_.trajectory_refused = !setpoints_.resume(request.number);
      break;
    case Kind::Back:
      lifting_ = false;
      end_yield();
      view_.trajectory_refused = !setpoints_.back(request.number);
      break;
    case Kind::Slow:
      setpoints_.go_slow(request.number != 0.0);
      break;
    case Kind::Scale:
      setpoints_.set_scale(request.number);
      break;
    case Kind::Ease:
      if (!yielding_ && !lifting_) leave_palm();
      break;
    case Kind::Unload:
      setpoints_.superpose(hal::JointVector::Zero());
      compensation_.drop();
      // the palm may stand beside its set point, or lean on the object: the springs would throw the empty
      // hand there. What yields goes its own way
      if (palm_.weight() > 0.0 || !yielding_) leave_palm();
      palm_.engage(false);
      energy_.close();
      break;
    case Kind::StartTare:
      load_.start_tare();
      break;
    case Kind::EndTare:
      load_.end_tare();
      break;
    case Kind::StartLift:
      end_yield();
      start_lift_time();
      view_.end_of_reach = false;
      lift_.start(setpoints_.commanded(), request.line);
      view_.palm_springs = palm_springs_ && monitor_time_.period_s() <= kMaxPeriod_s;
      palm_.engage(view_.palm_springs);
      energy_.fill(energy_allowed_j_);
      lift_.lift(request.role, request.number, request.time_s);
      break;
    case Kind::RaiseOn:
      continue_lift();
      lift_.give_way(request.line);
      lift_.lift(request.role, request.number, request.time_s);
      break;
    case Kind::Stay:
      lift_.stay();
      break;
    case Kind::Lower:
      continue_lift();
      lift_.lower();
      break;
    case Kind::SeePartner:
      lift_.see_partner(request.number);
      break;
    case Kind::ResumeLift:
      if (lift_cut_off_ && setpoints_.at_rest()) continue_lift();
      break;
    case Kind::Pause:
      lifting_ = false;
      force_.clear();
      setpoints_.hold();
      break;
    case Kind::Yield:
      start_yield();
      break;
    case Kind::Expect:
      force_.expect(request.load);
      break;
  }
}

void ArmController::start_lift_time() {
  lifting_ = true;
  lift_cut_off_ = false;
  lift_time_.reset();
  (void)lift_time_.advance(view_.state.measured_at);
  lift_starts_ = setpoints_.starts();
}

void ArmController::heed_task(std::uint64_t beats) {
  if (view_.misses > 0) return;
  const double silent_s = task_beat_.update(beats, view_.state.measured_at);
  if (view_.stalled) view_.stall_s = std::max(view_.stall_s, silent_s);
  if (view_.stalled || silent_s <= beat_timeout_s_ || setpoints_.at_rest()) return;
  view_.stalled = true;
  ++view_.stalls;
  view_.stall_s = silent_s;
  lift_cut_off_ = std::exchange(lifting_, false);
  setpoints_.hold_urgently();
}

void ArmController::continue_lift() {
  end_yield();
  if (lifting_) return;
  start_lift_time();
  lift_.restart(setpoints_.commanded());
}

void ArmController::monitor_force() {
  (void)monitor_time_.advance(view_.state.measured_at);
  const bool in_contact = yielding_ || setpoints_.blocked();
  force_.update(view_.state, monitor_time_.step_s(), setpoints_.follows_trajectory(), in_contact);
  if (force_.quiet() && !in_contact && setpoints_.running() && setpoints_.at_rest())
    yield_.rest(palm_.weight() > 0.0
                    ? palm_.spring_nm()
                    : hal::JointVector(setpoints_.stiffness() * (setpoints_.commanded() - view_.state.q_rad)),
                monitor_time_.step_s());
  // in the cycle in which it is felt; what follows from it, the task decides
  if (force_.finding() && !yielding_) start_yield();
}

void ArmController::start_yield() {
  if (yielding_) return;
  yielding_ = true;
  lifting_ = false;
  superposed_nm_ = yield_superposed_nm_ = setpoints_.superposed();
  // An object that is set down meets the ground with a force that looks like a push: an arm that became soft
  // at once would leave it hanging on what compensates its load.
  if (force_.load() == HandLoad::Lowering) {
    setpoints_.hold();
    setpoints_.set_stiffness(yield_stiffness_nm_rad_);
    start_compensation();
    return;
  }
  const bool rests = setpoints_.at_rest();
  setpoints_.hold_urgently();
  // soft springs would let sag what stiff ones hold; what moved held nothing
  if (rests) setpoints_.superpose(superposed_nm_ + yield_.held_nm());
  yield_superposed_nm_ = setpoints_.superposed();
  setpoints_.set_stiffness(yield_stiffness_nm_rad_, yield_slope_nm_rad_s_);
  start_compensation();
}

void ArmController::start_compensation() {
  const hal::JointVector& q_rad = view_.state.q_rad;
  compensation_.start(yield_superposed_nm_,
                      q_rad.allFinite() ? palm_wrench(*model_, q_rad, yield_superposed_nm_).force.z() : 0.0);
}

void ArmController::leave_palm() {
  if (!view_.state.q_rad.allFinite()) return;
  setpoints_.servo(lift_.where_taken(setpoints_.commanded(), view_.state.q_rad), hal::JointVector::Zero());
}

void ArmController::end_yield() {
  if (!yielding_) return;
  yielding_ = false;
  force_.clear();
  if (setpoints_.superposed() == yield_superposed_nm_)
    setpoints_.superpose(compensation_.part() * superposed_nm_);
  compensation_.drop();
  setpoints_.set_stiffness(stiffness_nm_rad_);
  setpoints_.end_urgency();
}

void ArmController::serve_yield() {
  if (!yielding_ || !setpoints_.running() || !view_.state.q_rad.allFinite()) return;
  const double dt_s = monitor_time_.step_s();
  const hal::JointVector held_nm = compensation_.step(load_.load_n(), force_.quiet(), dt_s);
  // whoever unloads the arm meanwhile superposes something else
  if (setpoints_.superposed() == yield_superposed_nm_) {
    setpoints_.superpose(held_nm);
    yield_superposed_nm_ = setpoints_.superposed();
  }
  const hal::JointVector goal =
      yield_.step(view_.state.q_rad, setpoints_.commanded(), palm_.stiffness_nm_rad(setpoints_.stiffness()),
                  !force_.quiet(), dt_s);
  if ((goal - setpoints_.commanded()).isZero()) {
    // what has followed somebody brakes where it is; it does not return to where it was to stop
    if (!setpoints_.at_rest()) setpoints_.hold();
    return;
  }
  setpoints_.servo(goal, setpoints_.superposed());
}

void ArmController::serve_lift() {
  (void)lift_time_.advance(view_.state.measured_at);
  const double dt_s = lift_time_.step_s();
  if (!lifting_ || dt_s <= 0.0 || !setpoints_.running() || !view_.state.may_command) return;
  if (setpoints_.starts() != lift_starts_) {
    lift_starts_ = setpoints_.starts();
    lift_.restart(setpoints_.commanded());
  }
  const double energy_scale = lift_.rises() ? energy_.speed_scale(energy_band_j_) : 1.0;
  const auto command = lift_.step(dt_s, load_.wrench_W(), energy_scale * setpoints_.pace());
  view_.end_of_reach = !command;
  if (command) setpoints_.servo(command->q_rad, command->tau_superposed_nm);
}

std::optional<hal::ImpedanceCommand> ArmController::command() {
  if (view_.misses > 0) return std::nullopt;
  monitor_force();
  serve_lift();
  serve_yield();
  setpoints_.limit_stiffening(energy_.open() ? energy_.speed_scale(energy_band_j_) : 1.0);
  const hal::ImpedanceCommand joints = setpoints_.step(view_.state);
  hal::ImpedanceCommand command = with_palm_springs(joints);
  limit_torque(command, view_.state.q_rad, model_->effort_nm());
  // a contact stops the trajectory in the cycle in which it is felt; what follows from it, the task decides
  if (setpoints_.blocked() && !stopped_by_contact_) setpoints_.hold();
  stopped_by_contact_ = setpoints_.blocked();
  if (!view_.state.may_command) return std::nullopt;
  return command;
}

hal::ImpedanceCommand ArmController::with_palm_springs(const hal::ImpedanceCommand& joints) {
  if (palm_starts_ != setpoints_.starts()) {
    palm_.reset();
    energy_.interrupt();
  }
  palm_starts_ = setpoints_.starts();
  const hal::JointVector& q_rad = view_.state.q_rad;
  if (const auto felt_W = load_.wrench_W(); energy_.open() && felt_W && q_rad.allFinite())
    energy_.update(hal::hand_pose(*model_, q_rad), *felt_W);
  return palm_.apply(q_rad, joints, monitor_time_.step_s());
}

void ArmController::sent(const hal::Result<>& result) {
  if (result) return;
  if (view_.refused_commands++ == 0) view_.refusal.set(result.error().text());
}

const ArmView& ArmController::view() {
  view_.commanded_rad = setpoints_.commanded();
  view_.running = setpoints_.running();
  view_.at_rest = setpoints_.at_rest();
  view_.done = setpoints_.done();
  view_.progress = setpoints_.progress();
  view_.starts = setpoints_.starts();
  view_.slow = setpoints_.slow();
  view_.blocked = setpoints_.blockage();
  view_.wrench_W = load_.wrench_W();
  view_.load_n = load_.load_n();
  view_.felt_W = force_.felt();
  view_.force = force_.finding();
  view_.force_quiet = force_.quiet();
  view_.load_lost = yielding_ && compensation_.lost();
  view_.height_m = lift_.height_m();
  view_.lift_at_rest = lift_.at_rest();
  view_.role = lift_.role();
  if (energy_.open()) {
    view_.energy_j = energy_.level_j();
    view_.min_energy_j = energy_.min_level_j();
  }
  return view_;
}

}  // namespace colift::control
