#pragma once

#include <cstdint>
#include <string_view>

#include "hal/drivers/kuka_fri/hand_shake.hpp"
#include "hal/drivers/kuka_fri/wire/fri_packets.hpp"
#include "hal/types/joints.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// Where the driver stands, which is more than the controller's state.
enum class FriSession : std::uint8_t {
  Silent,        ///< No datagrams. Deadlines: FriConfig::first_s, then silent_s.
  Monitor,       ///< Datagrams; nobody asked for command mode, or it was left.
  GettingReady,  ///< Asked for. Deadline: ready_s.
  Command,       ///< Command mode. Commands are taken unless something holds them up.
  Fault,         ///< Something happened that a person has to look at; activate() tries anew.
};
[[nodiscard]] std::string_view to_string(FriSession session) noexcept;

/// Why no command is taken, or why command mode is not reached.
enum class FriReason : std::uint8_t {
  None,
  NotOpen,
  NoDatagram,
  SecondSender,
  KrcNotNamed,
  LinkLost,
  LinkBroken,
  Gap,
  NotAsked,
  Stopped,
  QualityLow,
  QualityLost,
  ExternalTorque,
  ScriptSilent,
  ScriptHalted,
  ScriptRefused,
  ScriptRestarted,
  ScriptEnded,
  NoCommandMode,
  DrivesOff,
  DriveError,
  DriveHot,
  WrongControl,
  LeftCommand,
  KrcRestarted,
  JointJump,
  JointStuck,
};
/// Two words at most: 15 characters, so that an error in the cycle allocates nothing.
[[nodiscard]] const char* short_words(FriReason reason) noexcept;

/// What getting ready waits for.
enum class ReadyStage : std::uint8_t { Quality, Script, Drives, Settle, Done, Refused };

/// The driver's state machine: measurements, silence and wishes in; session, reason, and what to ask of the
/// KRL program out. Pure: no clock, no I/O. Real-time safe.
class SessionMachine {
 public:
  struct Settings {
    FriControl control = FriControl::JointImpedance;
    FriQuality min_quality = FriQuality::Ok;
    double start_external_nm = 20.0;
    double warm_c = 70.0, hot_c = 85.0;
    JointVector velocity_rad_s = JointVector::Zero();
  };
  explicit SessionMachine(const Settings& settings) : settings_(settings) {}

  /// A datagram came, `cycles` after the last one.
  void measured(const FriMeasurement& m, int cycles, double period_s, bool restarted);
  /// The KRL program's answer to the last datagram; after measured(). `detour`: what it commands with now is
  /// not what it was asked for, and ends by itself.
  void script(ScriptSign sign, std::int32_t code, bool detour = false);
  /// Getting ready ends for this reason, before the program is asked for anything, or with its request taken
  /// back.
  void refuse(FriReason reason);
  /// Another control strategy from the next activate() on; in monitor mode only.
  void set_control(FriControl control) { settings_.control = control; }
  /// What was sent last, to notice an arm that does not follow; `at_rest`: it has stopped moving.
  void sent(const JointVector& q_rad, const JointVector& stiffness_nm_rad, bool at_rest);
  /// Nothing came for `cycles` periods, or for so long that the link counts as `lost`, or it is `broken`.
  void silence(double cycles, bool lost, bool broken, int counter_set_by = 0);

  /// A person or a controller confirms. In command mode, with all well, commands are taken from the next
  /// datagram on; else command mode is asked for.
  void activate();
  /// Gives up getting ready; returns why.
  FriReason give_up();
  /// Brings to rest and holds, until activate().
  void stop();
  /// As stop(); then asks the program to leave command mode once the set point rests.
  void leave();
  /// Asks the program to end.
  void close() {
    leave();
    closing_ = true;
  }
  /// No more wishes.
  void forget_requests() { leaving_ = closing_ = quit_ = asked_ = false; }
  /// Getting ready failed for this reason.
  void refused(FriReason reason) {
    if (session_ != FriSession::Silent) reason_ = reason;
  }

  [[nodiscard]] FriSession session() const { return session_; }
  [[nodiscard]] FriReason reason() const { return reason_; }
  [[nodiscard]] ReadyStage stage() const { return stage_; }
  [[nodiscard]] std::int32_t script_code() const { return script_code_; }
  [[nodiscard]] ScriptSign script_sign() const { return sign_; }
  /// Joint that jumped, is stuck, hot or under load; from 0.
  [[nodiscard]] int joint() const { return joint_; }
  [[nodiscard]] double number() const { return number_; }  ///< Of that joint: rad, deg C or N m.

  [[nodiscard]] bool may_command() const { return session_ == FriSession::Command && engaged_ && !held_; }
  /// The last datagram's joint positions cannot be.
  [[nodiscard]] bool garbage() const { return garbage_; }
  /// Slower, please: quality, temperature or a drive's warning.
  [[nodiscard]] bool slow() const { return slow_; }
  /// The controller takes its own set point back: state, power.
  [[nodiscard]] static bool mirrors(const FriMeasurement& m) {
    return m.state != FriState::Command || !drives_on(m);
  }
  [[nodiscard]] static bool drives_on(const FriMeasurement& m) {
    return (m.power & kFriAllDrives) == kFriAllDrives;
  }
  /// To be asked of the program.
  [[nodiscard]] Ask ask() const;

 private:
  void fault(FriReason reason, int joint = 0, double number = 0.0);
  void get_ready(const FriMeasurement& m, double since_s);
  void watch(const FriMeasurement& m);
  void look_at_joints(const FriMeasurement& m, double since_s);
  void hold(FriReason reason);

  Settings settings_;
  FriSession session_ = FriSession::Silent;
  FriReason reason_ = FriReason::NoDatagram;
  ReadyStage stage_ = ReadyStage::Quality;
  ScriptSign sign_ = ScriptSign::Unknown;
  std::int32_t script_code_ = 0;
  bool engaged_ = false;  ///< Somebody confirmed.
  bool held_ = false;     ///< For a while, until things are well again.
  bool at_rest_ = true;
  bool asked_ = false;   ///< Command mode is there because this driver asked for it.
  bool detour_ = false;  ///< The program commands with another strategy, on its way to the asked one.
  bool leaving_ = false, closing_ = false, quit_ = false, slow_ = false, garbage_ = false,
       was_command_ = false;
  int well_ = 0, joint_ = 0;
  double settle_s_ = 0.0, script_done_s_ = 0.0, number_ = 0.0;

  bool have_joints_ = false;
  FriJoints joints_{};
  JointVector sent_ = JointVector::Zero(), stiffness_ = JointVector::Zero();
  JointVector still_s_ = JointVector::Zero(), still_sent_ = JointVector::Zero();
};

}  // namespace colift::hal
