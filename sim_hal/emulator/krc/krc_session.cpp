// The part of the emulator that the KRL program calls, and what brings the arm out of command mode.

#include <fmt/format.h>

#include <algorithm>

#include "sim_hal/emulator/krc/krc_emulator.hpp"
#include "sim_hal/emulator/krc/plant/krc_measurement.hpp"

namespace colift::sim_hal {
namespace {

using Kind = KrcFault::Kind;
constexpr double kAftermath_s = 0.25;  // so long an injected fault is blamed for what it does to the answers
constexpr double kStartCycles = 250;   // a slow link needs its time to show that it is good
constexpr double kRestartTakes_s = 0.3;  // off the wire while a program is restarted
constexpr double kBrakesOpen_s = 0.2;    // from friStart until the drives have the arm

}  // namespace

Vector6 KrcEmulator::tool_wrench() const {
  const KrcPlantState arm = plant_.state();
  return wrench_of(arm.tau_external_nm, dynamics_.jacobian(arm.q_rad, config_.X_FT.translation()));
}

void KrcEmulator::ptp_here() {
  if (tripped_) return event("KRL: no motion while the drives are off; an operator has to acknowledge");
  if (state_ == FriState::Command || braking_) return;
  // brakes hold the arm where it is, not where it was commanded
  if (!power_) motion_.start_at(plant_.state().q_rad);
  power_ = true;
  idle_ = false;
  moved_s_ = t_s_;
  motion_.fold();
}

// A pause of the program closes the brakes; command mode is no pause, wherever its set point is.
void KrcEmulator::watch_idle() {
  if (brakes_open_at_s_ && t_s_ >= *brakes_open_at_s_) {
    brakes_open_at_s_.reset();
    idle_ = false;
    power_ = true;
    event("the brakes are open");
  }
  if (state_ == FriState::Command || braking_) moved_s_ = t_s_;
  if (!power_ || config_.idle_brakes_s <= 0.0 || t_s_ - moved_s_ < config_.idle_brakes_s) return;
  idle_ = true;
  power_ = false;
  motion_.start_at(plant_.state().q_rad);
  event(fmt::format("the brakes closed: nothing moved for {:g} s", config_.idle_brakes_s));
}

void KrcEmulator::set_strategy(FriControl control, const KrlStiffness& stiffness) {
  if (state_ != FriState::Command) motion_.set_strategy(control, stiffness);
}

int KrcEmulator::cycle_ms() const {
  return static_cast<int>(cycle_ / std::chrono::milliseconds(1));
}

void KrcEmulator::fri_open(int ms) {
  if (state_ != FriState::Off) return;
  const hal::Duration wanted = std::chrono::milliseconds(std::clamp(ms, 1, 100));
  if (wanted != cycle_) {
    if (const auto done = plant_.set_cycle(wanted); done) {
      cycle_ = wanted;
      next_cycle_ = began_ + std::chrono::nanoseconds(std::llround(1e9 * t_s_)) + cycle_;
      motion_.set_cycle(cycle_);
    } else {
      event(fmt::format("the cycle stays at {} ms: {}", cycle_ms(), done.error().detail));
    }
  }
  quality_ = KrcQuality(config_.quality, cycle_);
  quality_now_ = FriQuality::Unacceptable;
  good_cycles_ = 0;
  send_ = reflected_ = 0;
  awaiting_ = answered_ = fresh_ = ever_answered_ = false;
  last_send_.reset();
  last_command_.reset();
  client_.reset();
  client_there_ = false;
  frozen_.reset();
  report_.closed.reset();
  set_state(FriState::Monitor, fmt::format("friOpen({})", cycle_ms()));
}

void KrcEmulator::fri_start(double safety_limits) {
  if (state_ != FriState::Monitor || start_until_s_) return;
  safety_limits_ = safety_limits;
  start_until_s_ = t_s_ + std::max(config_.start_timeout_s, kStartCycles * hal::seconds(cycle_));
}

void KrcEmulator::try_start() {
  if (!start_until_s_) return;
  const auto refuse = [&](const std::string& why) {
    start_until_s_.reset();
    event(fmt::format("friStart refused: {}", why));
  };
  if (state_ != FriState::Monitor) return start_until_s_.reset();
  const bool opens = idle_ && config_.start_opens_brakes && !active(Kind::DrivesOff);
  if ((!powered() && !opens) || tripped_)
    return refuse(idle_ && !tripped_ ? "the brakes are closed since nothing moved, and no motion opened them"
                                     : "the drives are off");
  if (active(Kind::DriveError)) return refuse("a drive reports an error");
  const int wanted =
      std::min(config_.start_cycles, static_cast<int>(config_.start_hold_s / hal::seconds(cycle_)) + 1);
  if (good_cycles_ < wanted || braking_) {
    if (t_s_ < *start_until_s_) return;
    return refuse(
        fmt::format("quality is {} (answers {:.0f} %, latency {:.2f} ms), good since {} cycles, "
                    "expected {}",
                    name(quality_now_), 100.0 * quality_.answer_rate(), 1e3 * quality_.latency_s(),
                    good_cycles_, wanted));
  }
  if (!fresh_) return;  // judged by the answer of this cycle
  if (const auto breach = check_entry(*last_command_, motion_.judged_at(), config_.limits)) {
    broke(breach->rule, breach->reason);
    return refuse(breach->reason);
  }
  start_until_s_.reset();
  motion_.enter(last_command_->flags, safety_limits_);
  if (!power_) brakes_open_at_s_ = t_s_ + kBrakesOpen_s;
  set_state(FriState::Command,
            fmt::format("friStart({:g}), flags 0x{:04X}", safety_limits_, last_command_->flags));
}

void KrcEmulator::fri_stop(const std::string& reason) {
  start_until_s_.reset();
  if (state_ == FriState::Command) leave(reason, false, false);
}

void KrcEmulator::fri_close(const std::string& reason) {
  fri_stop(reason);
  set_state(FriState::Off, reason);
  awaiting_ = false;
  in_.clear();
  out_.clear();
  report_.closed = reason;
}

void KrcEmulator::leave(const std::string& reason, bool drives_off, bool at_once) {
  set_state(FriState::Monitor, reason);
  motion_.leave();
  brakes_open_at_s_.reset();
  braking_ = true;
  off_after_braking_ = drives_off;
  if (at_once) trip();
}

void KrcEmulator::leave_for(const KrcBreach& breach) {
  broke(breach.rule, breach.reason);
  leave(breach.reason, true, false);
}

void KrcEmulator::trip() {
  braking_ = off_after_braking_ = idle_ = false;
  tripped_ = true;
  power_ = false;
  plant_.set_brakes(true);
  motion_.leave();
  motion_.start_at(plant_.state().q_rad);
  start_until_s_.reset();
  event("brakes closed, drives off");
  if (config_.restart_s) restart_at_s_ = t_s_ + *config_.restart_s;
}

void KrcEmulator::note_faults() {
  for (std::size_t i = 0; i < config_.faults.size(); ++i) {
    const KrcFault& fault = config_.faults[i];
    if (!fault_began_[i] && t_s_ >= fault.at_s) {
      fault_began_[i] = true;
      report_.injected.push_back({t_s_, fault.text});
      event(fmt::format("fault begins: {}", fault.text));
    }
    if (fault_began_[i] && !fault_ended_[i] && !fault.counted && t_s_ >= fault.at_s + fault.for_s) {
      fault_ended_[i] = true;
      event(fmt::format("fault ends: {}", fault.text));
    }
  }
}

void KrcEmulator::act_on_faults() {
  if (active(Kind::Unplug)) {
    if (!unplugged_) {
      unplugged_ = true;
      start_until_s_.reset();
      set_state(FriState::Off, "the controller is switched off");
      power_ = idle_ = false;
      brakes_open_at_s_.reset();
      braking_ = off_after_braking_ = false;
      plant_.set_brakes(true);
      motion_.start_at(plant_.state().q_rad);
      awaiting_ = false;
      in_.clear();
      out_.clear();
    }
    return;
  }
  if (unplugged_) {
    unplugged_ = false;
    tripped_ = halted_ = false;
    event("the controller is on again, the program starts from the top");
    from_pc_ = {};
    script_->begin(*this);
    next_poll_s_ = t_s_ + script_->period_s();
  }
  const KrcFault* stop = active(Kind::EmergencyStop);
  const KrcFault* error = active(Kind::DriveError);
  // The KRC halts its program too, until a person acknowledges and starts it anew.
  halted_ = halted_ || stop != nullptr || error != nullptr;
  if ((stop || error) && (power_ || idle_)) {
    const std::string reason =
        stop ? "emergency stop" : fmt::format("error of drive {}", joint_name(error->joint));
    if (state_ == FriState::Command)
      leave(reason, true, true);
    else {
      event(reason);
      trip();
    }
  }
  if (state_ == FriState::Command && active(Kind::Monitor)) leave("monitor mode was forced", false, false);
}

void KrcEmulator::restart_when_due() {
  if (config_.restart_s && !restart_at_s_ && (script_->ended() || halted_))
    restart_at_s_ = t_s_ + *config_.restart_s;
  if (!restart_at_s_ || t_s_ < *restart_at_s_) return;
  if (active(Kind::EmergencyStop) || active(Kind::DriveError) || unplugged_) return;
  if (state_ != FriState::Off) {
    fri_close("an operator restarts the program");
    restart_at_s_ = t_s_ + kRestartTakes_s;
    return;
  }
  restart_at_s_.reset();
  tripped_ = halted_ = false;
  from_pc_ = {};
  script_->begin(*this);
  next_poll_s_ = t_s_ + script_->period_s();
}

bool KrcEmulator::injected(KrcRule rule) const {
  const auto recent = [&](const KrcFault& f, double for_s) {
    // a counted fault takes some cycles from its beginning
    const double lasts_s = f.counted ? f.value * hal::seconds(cycle_) : f.for_s;
    return t_s_ >= f.at_s && t_s_ <= f.at_s + lasts_s + for_s;
  };
  const bool of_answers = rule == KrcRule::MissedAnswers || rule == KrcRule::QualityLost;
  return std::any_of(config_.faults.begin(), config_.faults.end(), [&](const KrcFault& f) {
    if (f.kind == Kind::Corrupt && f.way != KrcFault::Direction::ToClient && recent(f, kAftermath_s))
      return true;
    // to joint angles that are no numbers a client owes its silence
    const bool unanswerable = f.on_wire() || f.kind == Kind::Quality || f.kind == Kind::NotANumber;
    return of_answers && unanswerable && recent(f, kAftermath_s);
  });
}

const KrcFault* KrcEmulator::active(KrcFault::Kind kind) const {
  for (const KrcFault& f : config_.faults)
    if (f.kind == kind && f.active(t_s_)) return &f;
  return nullptr;
}

void KrcEmulator::mend() {
  for (KrcFault& fault : config_.faults) fault.end(t_s_);
  in_.mend();
  out_.mend();
  restart_at_s_ = t_s_;
}

void KrcEmulator::inject(const KrcFault& fault) {
  config_.faults.push_back(fault);
  fault_began_.push_back(false);
  fault_ended_.push_back(false);
  in_.add(fault);
  out_.add(fault);
}

}  // namespace colift::sim_hal
