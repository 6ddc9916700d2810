#include "hal/drivers/kuka_fri/session.hpp"

#include <algorithm>
#include <cmath>

namespace colift::hal {
namespace {

constexpr double kGapCycles = 5.0;   // the controller extrapolates a few; more is an error of the link
constexpr int kWell = 10;            // good datagrams in a row that end a hold
constexpr double kSettle_s = 0.012;  // one interpolation cycle of KRL, as the Stanford library waits
constexpr double kModeAfterScript_s = 3.0;
constexpr double kJump_rad = 0.01, kJumpParts = 2.0;  // as in GuardedArm
constexpr double kStuck_s = 0.1, kStuck_rad = 0.01;
constexpr double kStuck_nm = 10.0;  // a spring that pulls with less may be held by friction

}  // namespace

std::string_view to_string(FriSession session) noexcept {
  switch (session) {
    case FriSession::Silent:
      return "silent";
    case FriSession::Monitor:
      return "monitor";
    case FriSession::GettingReady:
      return "getting ready";
    case FriSession::Command:
      return "command";
    case FriSession::Fault:
      return "fault";
  }
  return "unknown";
}

const char* short_words(FriReason reason) noexcept {
  switch (reason) {
    case FriReason::None:
      return "all well";
    case FriReason::NotOpen:
      return "not configured";
    case FriReason::NoDatagram:
      return "no datagram";
    case FriReason::SecondSender:
      return "second sender";
    case FriReason::KrcNotNamed:
      return "krc not named";
    case FriReason::LinkLost:
      return "link lost";
    case FriReason::LinkBroken:
      return "socket broken";
    case FriReason::Gap:
      return "packets lost";
    case FriReason::NotAsked:
      return "monitor mode";
    case FriReason::Stopped:
      return "stopped";
    case FriReason::QualityLow:
    case FriReason::QualityLost:
      return "quality low";
    case FriReason::ExternalTorque:
      return "external torque";
    case FriReason::ScriptSilent:
      return "script silent";
    case FriReason::ScriptHalted:
      return "script halted";
    case FriReason::ScriptRefused:
      return "script refuses";
    case FriReason::ScriptRestarted:
      return "script anew";
    case FriReason::ScriptEnded:
      return "script ended";
    case FriReason::NoCommandMode:
      return "no command mode";
    case FriReason::DrivesOff:
      return "drives off";
    case FriReason::DriveError:
      return "drive error";
    case FriReason::DriveHot:
      return "drive hot";
    case FriReason::WrongControl:
      return "wrong control";
    case FriReason::LeftCommand:
      return "command ended";
    case FriReason::KrcRestarted:
      return "KRC restarted";
    case FriReason::JointJump:
      return "joint jumped";
    case FriReason::JointStuck:
      return "joint stuck";
  }
  return "unknown";
}

void SessionMachine::fault(FriReason reason, int joint, double number) {
  session_ = FriSession::Fault;
  reason_ = reason;
  joint_ = joint;
  number_ = number;
  engaged_ = held_ = false;
}

void SessionMachine::hold(FriReason reason) {
  held_ = true;
  well_ = 0;
  reason_ = reason;
}

void SessionMachine::look_at_joints(const FriMeasurement& m, double since_s) {
  garbage_ = false;
  for (std::size_t i = 0; have_joints_ && i < 7; ++i) {
    const double by = std::abs(static_cast<double>(m.q_measured_rad[i] - joints_[i]));
    const double most =
        kJump_rad + kJumpParts * settings_.velocity_rad_s[static_cast<Eigen::Index>(i)] * since_s;
    if (by <= most) continue;
    garbage_ = true;
    if (session_ == FriSession::Command && engaged_) fault(FriReason::JointJump, static_cast<int>(i), by);
  }
  for (int i = 0; i < kArmJoints; ++i) {
    const auto j = static_cast<std::size_t>(i);
    if (!have_joints_ || !may_command() || m.q_measured_rad[j] != joints_[j]) {
      still_s_[i] = 0.0;
      still_sent_[i] = sent_[i];
      continue;
    }
    still_s_[i] += since_s;
    const double moved = std::abs(sent_[i] - still_sent_[i]);
    const double least = std::max(kStuck_rad, stiffness_[i] > 0.0 ? kStuck_nm / stiffness_[i] : 1e9);
    if (session_ == FriSession::Command && still_s_[i] > kStuck_s && moved > least)
      fault(FriReason::JointStuck, i, moved);
  }
  joints_ = m.q_measured_rad;
  have_joints_ = true;
}

void SessionMachine::measured(const FriMeasurement& m, int cycles, double period_s, bool restarted) {
  const double since_s = cycles * period_s;
  const bool command = m.state == FriState::Command;
  const bool first = session_ == FriSession::Silent;
  if (restarted) {
    have_joints_ = false;
    if (session_ == FriSession::GettingReady) {
      stage_ = ReadyStage::Refused;
      reason_ = FriReason::KrcRestarted;
    } else if (session_ == FriSession::Command && engaged_) {
      fault(FriReason::KrcRestarted);
    }
  }
  look_at_joints(m, std::min(since_s, 0.1));
  const auto hottest = std::max_element(m.temperature_c.begin(), m.temperature_c.end());
  slow_ = m.quality == FriQuality::Bad || m.warning != 0 || static_cast<double>(*hottest) >= settings_.warm_c;

  if (first) {
    const FriReason lost = reason_;
    session_ = command ? FriSession::Command : FriSession::Monitor;
    const bool worth_keeping = lost == FriReason::LinkLost || lost == FriReason::KrcRestarted;
    reason_ = worth_keeping ? lost : FriReason::NotAsked;
    engaged_ = held_ = false;
  }
  switch (session_) {
    case FriSession::Silent:
      break;
    case FriSession::Monitor:
      if (command) session_ = FriSession::Command;
      break;
    case FriSession::GettingReady:
      get_ready(m, since_s);
      break;
    case FriSession::Command:
      if (cycles - 1 > kGapCycles && engaged_) hold(FriReason::Gap);
      watch(m);
      break;
    case FriSession::Fault:
      break;
  }
  if (!command && session_ != FriSession::GettingReady && !leaving_ && !quit_) asked_ = false;
  was_command_ = command;
}

void SessionMachine::get_ready(const FriMeasurement& m, double since_s) {
  if (stage_ == ReadyStage::Refused || stage_ == ReadyStage::Done) return;
  const auto refuse = [&](FriReason reason, int joint = 0, double number = 0.0) {
    stage_ = ReadyStage::Refused;
    reason_ = reason;
    joint_ = joint;
    number_ = number;
  };
  const bool command = m.state == FriState::Command;
  if (m.error != 0) return refuse(FriReason::DriveError);
  for (std::size_t i = 0; i < 7; ++i)
    if (static_cast<double>(m.temperature_c[i]) >= settings_.hot_c)
      return refuse(FriReason::DriveHot, static_cast<int>(i), static_cast<double>(m.temperature_c[i]));
  const bool on_detour = detour_ && stage_ <= ReadyStage::Script;
  if (was_command_ && !command && !on_detour) return refuse(FriReason::LeftCommand);

  if (stage_ == ReadyStage::Quality) {
    reason_ = FriReason::QualityLow;
    if (m.quality < settings_.min_quality) return;
    for (std::size_t i = 0; i < 7; ++i) {
      const double nm = std::abs(static_cast<double>(m.tau_external_nm[i]));
      if (nm > settings_.start_external_nm) return refuse(FriReason::ExternalTorque, static_cast<int>(i), nm);
    }
    stage_ = ReadyStage::Script;
    script_done_s_ = 0.0;
  }
  if (stage_ == ReadyStage::Script) {
    if (!command || detour_) {
      asked_ = true;
      reason_ = FriReason::NoCommandMode;
      // a program that says it has started, in a controller that stays in monitor mode: it was refused
      if (sign_ == ScriptSign::Done) script_done_s_ += since_s;
      if (script_done_s_ > kModeAfterScript_s) refuse(FriReason::NoCommandMode);
      return;
    }
    stage_ = ReadyStage::Drives;
  }
  if (m.control != settings_.control) return refuse(FriReason::WrongControl);
  if (stage_ == ReadyStage::Drives) {
    reason_ = FriReason::DrivesOff;
    if (!drives_on(m)) return;
    stage_ = ReadyStage::Settle;
    settle_s_ = 0.0;
  }
  if (!drives_on(m)) {
    stage_ = ReadyStage::Drives;
    return;
  }
  reason_ = FriReason::NoCommandMode;
  if (m.quality == FriQuality::Unacceptable) {
    reason_ = FriReason::QualityLow;
    settle_s_ = 0.0;
    return;
  }
  settle_s_ += since_s;
  if (settle_s_ < kSettle_s || !at_rest_) return;
  stage_ = ReadyStage::Done;
  session_ = FriSession::Command;
  reason_ = FriReason::None;
  engaged_ = true;
  held_ = false;
  still_s_.setZero();
}

void SessionMachine::watch(const FriMeasurement& m) {
  const bool command = m.state == FriState::Command;
  if (!engaged_) {
    if (!command) {
      session_ = FriSession::Monitor;
      quit_ = false;
    }
    return;
  }
  if (m.error != 0) return fault(FriReason::DriveError);
  if (!drives_on(m)) return fault(FriReason::DrivesOff);
  if (!command) {
    engaged_ = held_ = false;
    session_ = FriSession::Monitor;
    reason_ = FriReason::LeftCommand;
    return;
  }
  if (m.control != settings_.control) {
    fault(FriReason::WrongControl);
    quit_ = true;
    return;
  }
  for (std::size_t i = 0; i < 7; ++i) {
    if (static_cast<double>(m.temperature_c[i]) < settings_.hot_c) continue;
    fault(FriReason::DriveHot, static_cast<int>(i), static_cast<double>(m.temperature_c[i]));
    quit_ = true;
    return;
  }
  if (m.quality == FriQuality::Unacceptable) return hold(FriReason::QualityLost);
  if (held_ && ++well_ >= kWell && at_rest_) {
    held_ = false;
    reason_ = FriReason::None;
  }
}

void SessionMachine::refuse(FriReason reason) {
  if (session_ != FriSession::GettingReady) return;
  stage_ = ReadyStage::Refused;
  reason_ = reason;
}

void SessionMachine::script(ScriptSign sign, std::int32_t code, bool detour) {
  sign_ = sign;
  script_code_ = code;
  detour_ = detour;
  if (session_ != FriSession::GettingReady || stage_ != ReadyStage::Script) return;
  switch (sign) {
    case ScriptSign::Silent:
      return refuse(FriReason::ScriptSilent);
    case ScriptSign::Halted:
      return refuse(FriReason::ScriptHalted);
    case ScriptSign::Refused:
      return refuse(FriReason::ScriptRefused);
    case ScriptSign::Restarted:
      return refuse(FriReason::ScriptRestarted);
    case ScriptSign::Ended:
      return refuse(FriReason::ScriptEnded);
    case ScriptSign::Lost:
      return refuse(FriReason::LeftCommand);
    default:
      return;
  }
}

void SessionMachine::sent(const JointVector& q_rad, const JointVector& stiffness_nm_rad, bool at_rest) {
  sent_ = q_rad;
  at_rest_ = at_rest;
  stiffness_ = stiffness_nm_rad;
}

void SessionMachine::silence(double cycles, bool lost, bool broken, int counter_set_by) {
  if (cycles > kGapCycles && session_ == FriSession::Command && engaged_ && !held_) hold(FriReason::Gap);
  if (!lost && !broken) return;
  if (session_ == FriSession::GettingReady) stage_ = ReadyStage::Refused;
  if (session_ != FriSession::Silent) {
    reason_ = counter_set_by != 0 ? FriReason::KrcRestarted : FriReason::LinkLost;
    number_ = counter_set_by;
  }
  if (broken) reason_ = FriReason::LinkBroken;
  session_ = FriSession::Silent;
  engaged_ = held_ = was_command_ = have_joints_ = quit_ = false;
}

void SessionMachine::activate() {
  leaving_ = quit_ = engaged_ = held_ = detour_ = false;
  script_code_ = 0;
  sign_ = ScriptSign::Unknown;
  session_ = FriSession::GettingReady;
  stage_ = ReadyStage::Quality;
  reason_ = FriReason::QualityLow;
  was_command_ = false;
}

FriReason SessionMachine::give_up() {
  const FriReason why = reason_;
  if (session_ == FriSession::GettingReady) session_ = FriSession::Monitor;
  engaged_ = held_ = false;
  return why;
}

void SessionMachine::stop() {
  if (session_ == FriSession::GettingReady) {
    stage_ = ReadyStage::Refused;
    reason_ = FriReason::Stopped;
    return;
  }
  if (!engaged_) return;
  engaged_ = held_ = false;
  reason_ = FriReason::Stopped;
}

void SessionMachine::leave() {
  stop();
  if (session_ == FriSession::GettingReady) session_ = FriSession::Monitor;
  leaving_ = true;
}

Ask SessionMachine::ask() const {
  if (closing_) return Ask::Close;
  if (leaving_ || quit_) return at_rest_ ? Ask::Stop : Ask::Start;
  // in command mode the wish stands, whatever holds the commands up
  const bool getting_ready = session_ == FriSession::GettingReady && stage_ != ReadyStage::Refused;
  return asked_ && (getting_ready || was_command_) ? Ask::Start : Ask::Nothing;
}

}  // namespace colift::hal
