#include "control/arm/arm_motion.hpp"

namespace colift::control {

ArmMotion::ArmMotion(const hal::RobotModel& model, const planner::ArmGeometry& arm, const TaskConfig& task,
                     const LoadConfig& load, const CycleLimits& limits)
    : cycle_(model, task, limits), load_(model, load), lift_(model, arm, task) {}

void ArmMotion::measured(const hal::Result<hal::ArmState>& state) {
  if (!state) {
    ++view_.missed;
    ++view_.misses;
    view_.link_lost = state.error().code != hal::ErrorCode::Timeout;
    view_.trouble.set(state.error().text());
    return;
  }
  ++view_.cycles;
  view_.misses = 0;
  view_.link_lost = false;
  view_.state = *state;
  load_.update(state->measured_at, state->q_rad, state->tau_external_nm);
}

void ArmMotion::take(const ArmRequest& request) {
  using Kind = ArmRequest::Kind;
  view_.answered = request.id;
  switch (request.kind) {
    case Kind::Hold:
      lifting_ = false;
      cycle_.hold();
      break;
    case Kind::Follow:
      lifting_ = false;
      view_.way_refused = !cycle_.follow(request.way);
      break;
    case Kind::Resume:
      lifting_ = false;
      view_.way_refused = !cycle_.resume(request.number);
      break;
    case Kind::Back:
      lifting_ = false;
      view_.way_refused = !cycle_.back(request.number);
      break;
    case Kind::Slow:
      cycle_.go_slow(request.number != 0.0);
      break;
    case Kind::Unload:
      cycle_.superpose(hal::JointVector::Zero());
      break;
    case Kind::StartTare:
      load_.start_tare();
      break;
    case Kind::EndTare:
      load_.end_tare();
      break;
    case Kind::StartLift:
      lifting_ = true;
      view_.end_of_reach = false;
      lift_time_.reset();
      (void)lift_time_.advance(view_.state.measured_at);
      lift_starts_ = cycle_.starts();
      lift_.start(cycle_.commanded());
      lift_.lift(request.role, request.number, request.time_s);
      break;
    case Kind::RaiseOn:
      lift_.lift(request.role, request.number, request.time_s);
      break;
    case Kind::Stay:
      lift_.stay();
      break;
    case Kind::Lower:
      lift_.lower();
      break;
    case Kind::SeePartner:
      lift_.see_partner(request.number);
      break;
  }
}

void ArmMotion::serve_lift() {
  (void)lift_time_.advance(view_.state.measured_at);
  const double dt_s = lift_time_.step_s();
  if (!lifting_ || dt_s <= 0.0 || !cycle_.running() || !view_.state.may_command) return;
  if (cycle_.starts() != lift_starts_) {
    lift_starts_ = cycle_.starts();
    lift_.restart(cycle_.commanded());
  }
  const auto command = lift_.step(dt_s, load_.wrench_W(), cycle_.pace());
  view_.end_of_reach = !command;
  if (command) cycle_.servo(command->q_rad, command->tau_superposed_nm);
}

std::optional<hal::ImpedanceCommand> ArmMotion::command() {
  if (view_.misses > 0) return std::nullopt;
  serve_lift();
  const hal::ImpedanceCommand command = cycle_.step(view_.state);
  // a contact stops the way in the cycle in which it is felt; what follows from it, the task decides
  if (cycle_.blocked() && !stopped_by_contact_) cycle_.hold();
  stopped_by_contact_ = cycle_.blocked();
  if (!view_.state.may_command) return std::nullopt;
  return command;
}

void ArmMotion::sent(const hal::Result<>& result) {
  if (result) return;
  if (view_.refused_commands++ == 0) view_.refusal.set(result.error().text());
}

const ArmView& ArmMotion::view() {
  view_.commanded_rad = cycle_.commanded();
  view_.running = cycle_.running();
  view_.at_rest = cycle_.at_rest();
  view_.done = cycle_.done();
  view_.progress = cycle_.progress();
  view_.starts = cycle_.starts();
  view_.slow = cycle_.slow();
  view_.blocked = cycle_.blockage();
  view_.wrench_W = load_.wrench_W();
  view_.load_n = load_.load_n();
  view_.height_m = lift_.height_m();
  view_.lift_at_rest = lift_.at_rest();
  view_.role = lift_.role();
  return view_;
}

}  // namespace colift::control
