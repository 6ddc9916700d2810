#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "hal/drivers/kuka_fri/fri_config.hpp"
#include "hal/drivers/kuka_fri/joint_set_point.hpp"
#include "hal/drivers/kuka_fri/session.hpp"
#include "hal/drivers/kuka_fri/wire/packet_gate.hpp"

namespace colift::hal {

/// How the connection stands, as it leaves the cycle: plain numbers, made into words elsewhere.
struct FriStatus {
  FriSession session = FriSession::Silent;
  FriReason reason = FriReason::NotOpen;
  ReadyStage stage = ReadyStage::Quality;
  ScriptSign script = ScriptSign::Unknown;
  std::int32_t script_code = 0;
  bool may_command = false, slow = false;
  int joint = 0;        ///< That `reason` is about, from 0.
  double number = 0.0;  ///< Its figure: rad, deg C or N m.

  // the controller's last datagram
  FriState state = FriState::Off;
  FriQuality quality = FriQuality::Unacceptable;
  FriControl control = FriControl::Other;
  std::uint16_t power = 0, error = 0, warning = 0;
  float answer_rate = 0, latency_s = 0, jitter_s = 0, hottest_c = 0, safety_limits = 0;
  std::uint32_t krc_misses = 0;     ///< Answers that the KRC says never came.
  std::uint32_t recent_misses = 0;  ///< Those of the last 1 to 2 s in which it was commanded, and since.
  double silent_s = 0.0;            ///< Without a datagram for so long the link counts as lost (s).
  double stall_s = 0.0;             ///< Longest time for which this program did not answer by its own fault,
                                    ///< until it has commanded for 3 s without another (s).
  double period_s = 0.0;            ///< Sample time that is used ...
  double claimed_period_s = 0.0;    ///< ... that the last datagram says ...
  double arrivals_s = 0.0;          ///< ... and that the arrivals show, where it is another one; else 0.
  double pose_mismatch_rad = 0.0;   ///< Greatest distance of the measured from the commanded pose,
  int mismatch_joint = 0;           ///< and its joint, from 0.
  /// The KRC's external torque pulls the other way than the arm hangs on its springs: `external_torque` names
  /// the wrong sign, and a start takes the load for no load and lets the arm sink.
  bool torque_reversed = false;
  Endpoint krc;
  FriReason doubt = FriReason::None;              ///< Why it is not certain that this is the KRC.
  Endpoint rival;                                 ///< Who else sends what a KRC would ...
  std::uint64_t rival_datagrams = 0;              ///< ... and how many of them came.
  FriControl asked = FriControl::JointImpedance;  ///< Control strategy that is asked for.

  // counters since configure()
  std::uint64_t states = 0;  ///< Handed to the user.
  std::uint64_t received = 0, answered = 0, repeated = 0, late = 0, unsent = 0;
  std::uint64_t lost = 0;      ///< Datagrams that never came, by their counter.
  std::uint64_t timeouts = 0;  ///< Cycles in which nothing usable came.
  std::uint64_t unsound = 0;   ///< Datagrams with content that cannot be, in the last silence or gap.
  std::uint64_t refused = 0;   ///< Commands that broke a limit.
  FriLimit last_refused;
  FriRefusal last_refusal = FriRefusal::None;  ///< Of a datagram's content.
  std::array<std::uint64_t, kFriDrops> drops{};
};

/// Something that changed, with its time: out of the cycle through a ring.
struct FriEvent {
  Timestamp at{0};
  FriSession session = FriSession::Silent;
  FriReason reason = FriReason::None;
};

/// Why commands are not taken and what to do about it, in sentences; empty when they are.
[[nodiscard]] std::string why_not(const FriStatus& status, const FriConfig& config);
/// For how long this program did not answer by its own fault, in a sentence; empty when it did.
[[nodiscard]] std::string describe_stall(const FriStatus& status);
/// That `external_torque` has the wrong sign, in a sentence; empty when nothing says so.
[[nodiscard]] std::string describe_torque_sign(const FriStatus& status, const FriConfig& config);
/// Why it is not certain who the KRC is, and what names it, in a sentence; empty when it is.
[[nodiscard]] std::string describe_sender(const FriStatus& status);
/// A command that was refused, in a sentence with its numbers.
[[nodiscard]] std::string words(const FriLimit& limit);
/// The same in at most 15 characters.
[[nodiscard]] const char* short_words(const FriLimit& limit) noexcept;
/// Everything that slows the arm down; empty when nothing does.
[[nodiscard]] std::string why_slow(const FriStatus& status, const FriConfig& config);
/// Counters of datagrams and answers, one line.
[[nodiscard]] std::string traffic(const FriStatus& status);

}  // namespace colift::hal
