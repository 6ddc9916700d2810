#include "hal/drivers/kuka_fri/fri_status.hpp"

#include <fmt/format.h>

#include <algorithm>

#include <string_view>

#include "hal/os/udp_link.hpp"

namespace colift::hal {
namespace {

constexpr std::uint32_t kManyMisses = 10;  // by the KRC's count
// A stall that is longer costs command mode whatever the KRC counts; a shorter one only where it missed
// answers.
constexpr double kCertainStall_s = 0.01, kCertainStallCycles = 5.0;
constexpr std::uint32_t kStallMisses = 2;

std::string_view name(FriQuality q) {
  switch (q) {
    case FriQuality::Unacceptable:
      return "unacceptable";
    case FriQuality::Bad:
      return "bad";
    case FriQuality::Ok:
      return "ok";
    case FriQuality::Perfect:
      return "perfect";
    case FriQuality::Invalid:
      break;
  }
  return "unknown";
}

std::string_view name(FriControl c) {
  switch (c) {
    case FriControl::Other:
      return "another controller";
    case FriControl::Position:
      return "position control (strategy 10)";
    case FriControl::CartesianImpedance:
      return "Cartesian impedance (strategy 20)";
    case FriControl::JointImpedance:
      return "joint impedance (strategy 30)";
  }
  return "an unknown controller";
}

/// As FriConfig::control has it.
std::string_view setting(FriControl c) {
  return c == FriControl::Position             ? "position"
         : c == FriControl::CartesianImpedance ? "cartesian_impedance"
                                               : "joint_impedance";
}

std::string link(const FriStatus& s) {
  return fmt::format("answer rate {:.2f}, latency {:.1f} ms, jitter {:.1f} ms", s.answer_rate,
                     1e3 * static_cast<double>(s.latency_s), 1e3 * static_cast<double>(s.jitter_s));
}

std::string joints_of(std::uint16_t bits) {
  std::string text;
  for (int i = 0; i < 7; ++i)
    if ((bits >> i & 1) != 0) text += fmt::format("{}A{}", text.empty() ? "" : ", ", i + 1);
  return text.empty() ? "no joint" : text;
}

std::string dropped(const FriStatus& s) {
  std::string text;
  for (std::size_t i = 1; i < kFriDrops; ++i)
    if (s.drops[i] > 0)
      text +=
          fmt::format("{}{} {}", text.empty() ? "" : ", ", s.drops[i], to_string(static_cast<FriDrop>(i)));
  return text;
}

std::string no_datagram(const FriStatus& s, const FriConfig& c) {
  std::string text = fmt::format(
      "nothing usable comes from the KRC on {}:{}; is the KRL program running, and does friSetup "
      "(or FRIHOST, FRISOCK in dlrrc.ini) name this machine and port?",
      c.address, c.port);
  if (const std::string d = dropped(s); !d.empty()) text += fmt::format(" Dropped so far: {}.", d);
  if (s.last_refusal != FriRefusal::None)
    text += fmt::format(" The last one: {}.", to_string(s.last_refusal));
  if (s.drops[static_cast<std::size_t>(FriDrop::Header)] > 0)
    text += " A server that leaves its header empty is heard with check_header and check_sequence off.";
  return text;
}

std::string refusal_of_colift(std::int32_t code) {
  switch (code) {
    case 2:
      return "the quality did not come within 5 s";
    case 3:
      return "it does not know the strategy, or commands with another one";
    case 4:
      return "friStart did not give command mode: see the KRC's message window";
    case 5:
      return "command mode was lost: see the KRC's message window";
    case 6:
      return "it speaks another version of the hand-shake";
    case 7:
      return "it does not know the request";
    case 8:
      return "it did not hear this program's heartbeat for 1 s";
    default:
      return fmt::format("its code is {}", code);
  }
}

std::string no_command_mode(const FriStatus& s, const FriConfig& c) {
  std::string text = "the KRC stays in monitor mode";
  if (c.script == "none") text += "; nobody asks for command mode but a person at the panel (script: none)";
  if (s.script == ScriptSign::Done) text += " although the KRL program says it has called friStart";
  if (s.control != s.asked)
    text += fmt::format("; it runs {}, asked for was {}", name(s.control), setting(s.asked));
  if (s.power == 0 && c.script != "colift")
    text +=
        "; the drives are off: the brakes closed while nothing moved, and this program makes no motion "
        "before friStart (start it anew at the panel), or an emergency stop";
  if (s.pose_mismatch_rad > 0.02)
    text += fmt::format(
        "; A{} is measured {:.3f} rad away from where the KRC commands it: check the load data of the tool",
        s.mismatch_joint + 1, s.pose_mismatch_rad);
  return text + fmt::format(". Quality {}, {}, power 0x{:02X}; see the KRC's message window", name(s.quality),
                            link(s), s.power);
}

std::string reason_words(const FriStatus& s, const FriConfig& c) {
  switch (s.reason) {
    case FriReason::None:
      return s.may_command ? "" : "command mode is not active; nobody has asked for it";
    case FriReason::NotOpen:
      return "the arm is not open; configure() comes first";
    case FriReason::NoDatagram:
      return no_datagram(s, c);
    case FriReason::SecondSender:
    case FriReason::KrcNotNamed:
      return describe_sender(s);
    case FriReason::LinkLost:
      if (s.unsound > 0)
        return fmt::format(
            "no usable datagram for {:.0f} ms: {} came and {} dropped, the last one: {}; the KRC sends "
            "what cannot be, it is not the cable",
            1e3 * std::max(s.silent_s, c.silent_s), s.unsound, s.unsound == 1 ? "was" : "were",
            to_string(s.last_refusal));
      return fmt::format(
          "no datagram for {:.0f} ms: the link to the KRC is lost ({} came before); cable, KRC "
          "switched off, or friClose",
          1e3 * std::max(s.silent_s, c.silent_s), s.received);
    case FriReason::LinkBroken:
      return "the socket does not work any more; it has to be opened again";
    case FriReason::Gap:
      return fmt::format(
          "more than 5 datagrams in a row were lost{} ({} lost so far, {} cycles without one); "
          "the target was brought to rest and starts from the measured pose",
          s.unsound > 0 ? fmt::format(": {} of them came and were dropped, the last one: {}", s.unsound,
                                      to_string(s.last_refusal))
                        : "",
          s.lost, s.timeouts);
    case FriReason::NotAsked:
      return fmt::format("the KRC is in {} mode and nobody has asked to command",
                         s.state == FriState::Command ? "command" : "monitor");
    case FriReason::Stopped:
      return "it was stopped, and acts again when it is asked to anew";
    case FriReason::QualityLow:
      return fmt::format(
          "the quality of the connection is {} and has to be {} ({}); the answers come too late or "
          "not at all: a quiet machine, a cable of its own, a longer FRI period",
          name(s.quality), c.min_quality, link(s));
    case FriReason::QualityLost:
      return fmt::format("the quality of the connection fell to {} ({}): no commands until it is back",
                         name(s.quality), link(s));
    case FriReason::ExternalTorque:
      return fmt::format(
          "external torque on A{}: {:.1f} N m (limit to start {:.1f}): the arm touches something, or "
          "the tool's load data are wrong",
          s.joint + 1, s.number, c.start_external_nm);
    case FriReason::ScriptSilent:
      return fmt::format(
          "the KRL program does not answer within {:.1f} s; expected is \"{}\" (script), is it "
          "another one?",
          c.script_s, c.script);
    case FriReason::ScriptHalted:
      return fmt::format(
          "the KRL program is stopped: it was halted at the panel, or waits for an acknowledgement there{}",
          s.power == 0 ? "; the drives are off (power 0x00): an emergency stop halts it too" : "");
    case FriReason::ScriptRefused:
      return fmt::format("the KRL program refuses: {}", c.script == "colift"
                                                            ? refusal_of_colift(s.script_code)
                                                            : fmt::format("code {}", s.script_code));
    case FriReason::ScriptRestarted:
      return "the KRL program was begun anew in between; ask again";
    case FriReason::ScriptEnded:
      return "the KRL program has ended; start it at the panel";
    case FriReason::NoCommandMode:
      return no_command_mode(s, c);
    case FriReason::DrivesOff:
      return fmt::format(
          "the drives are off (power 0x{:02X}, all is 0x7F): emergency stop, enabling switch or "
          "brakes; a person has to switch them on",
          s.power);
    case FriReason::DriveError:
      return fmt::format("drive error of {} (bits 0x{:02X}); a person has to acknowledge it at the panel",
                         joints_of(s.error), s.error);
    case FriReason::DriveHot:
      return fmt::format("the drive of A{} has {:.0f} deg C (limit {:.0f}): command mode is left",
                         s.joint + 1, s.number, c.hot_c);
    case FriReason::WrongControl:
      return fmt::format("the KRC runs {}, asked for was {}", name(s.control), setting(s.asked));
    case FriReason::LeftCommand:
      return fmt::format(
          "the KRC left command mode (quality {}, {}); its message window says why. Asked again, "
          "commands begin at the measured pose",
          name(s.quality), link(s));
    case FriReason::KrcRestarted:
      return s.number == 0.0
                 ? std::string("the KRC counts its datagrams anew: it was restarted, or FRI was opened again")
                 : fmt::format(
                       "the KRC counts its datagrams anew ({:+.0f}), without a gap in what came: it was "
                       "restarted, or FRI was opened again; it is not the cable",
                       s.number);
    case FriReason::JointJump:
      return fmt::format("A{} was measured {:.3f} rad away from the datagram before: no arm does that",
                         s.joint + 1, s.number);
    case FriReason::JointStuck:
      return fmt::format("A{} has not changed by one bit while it was commanded by {:.3f} rad", s.joint + 1,
                         s.number);
  }
  return "for an unknown reason";
}

}  // namespace

std::string describe_sender(const FriStatus& s) {
  const auto address = [](const Endpoint& e) { return to_string(e).substr(0, to_string(e).find(':')); };
  if (s.doubt == FriReason::SecondSender)
    return fmt::format(
        "two senders on this port: {}, which was first, and {} ({} datagrams, dropped); command mode is "
        "asked of "
        "none of them: end the one that is not the KRC, or name the KRC (fri: krc: IPV4:PORT)",
        to_string(s.krc), to_string(s.rival), s.rival_datagrams);
  if (s.doubt == FriReason::KrcNotNamed)
    return fmt::format(
        "fri.krc is empty and the datagrams come from {}, another machine: command mode is asked only of a "
        "controller that is named; if that is the KRC, write krc: {} in the file behind --robot",
        to_string(s.krc), address(s.krc));
  return {};
}

std::string describe_torque_sign(const FriStatus& s, const FriConfig& c) {
  if (!s.torque_reversed) return "";
  return fmt::format(
      "the external torque has the wrong sign: it pulls the other way than the arm hangs, so that a start "
      "lets the "
      "arm sink (external_torque is {}, it should be {})",
      c.external_torque, c.external_torque == "on_arm" ? "on_environment" : "on_arm");
}

std::string describe_stall(const FriStatus& s) {
  const bool certain = s.stall_s > std::max(kCertainStall_s, kCertainStallCycles * s.period_s);
  if (!certain && (s.stall_s <= 0.0 || s.recent_misses < kStallMisses)) return {};
  return fmt::format(
      "this program did not run for {:.0f} ms (it was stopped, or the machine had no time for it) and the "
      "KRC got no answers meanwhile{}",
      1e3 * s.stall_s, s.krc_misses > 0 ? fmt::format(" ({} missed by its count)", s.krc_misses) : "");
}

std::string why_not(const FriStatus& s, const FriConfig& c) {
  const std::string reason = reason_words(s, c);
  switch (s.reason) {
    case FriReason::LinkLost:
    case FriReason::Gap:
    case FriReason::QualityLow:
    case FriReason::QualityLost:
    case FriReason::ScriptSilent:
    case FriReason::ScriptHalted:
    case FriReason::ScriptRefused:
    case FriReason::DrivesOff:
    case FriReason::LeftCommand:
      if (const std::string stall = describe_stall(s); !stall.empty())
        return stall + "; after that: " + reason;
      // a person at the panel costs no answers: lost ones come first
      if (s.recent_misses > kManyMisses && s.reason != FriReason::LinkLost)
        return fmt::format(
            "{} answers of this machine never came to the KRC (lost on the network, or late); {}",
            s.recent_misses, reason);
      return reason;
    default:
      return reason;
  }
}

std::string words(const FriLimit& l) {
  static constexpr const char* kCart[] = {"x", "y", "z", "rx", "ry", "rz"};
  const int axis = l.axis + 1;
  switch (l.what) {
    case FriLimit::What::None:
      return "";
    case FriLimit::What::NotFinite:
      return "a number of the command is not finite";
    case FriLimit::What::Position:
      return fmt::format("A{} to {:.4f} (limit {:.4f})", axis, l.found, l.limit);
    case FriLimit::What::Step:
      return fmt::format("A{} steps by {:.5f} rad (limit {:.5f} in the time that passed)", axis, l.found,
                         l.limit);
    case FriLimit::What::Start:
      return fmt::format("the first command is {:.4f} away from the measured pose (axis {}, limit {:.4f})",
                         l.found, axis, l.limit);
    case FriLimit::What::Stiffness:
      return fmt::format("stiffness {:.1f} of axis {} (0 to {:.0f})", l.found, axis, l.limit);
    case FriLimit::What::Damping:
      return fmt::format("damping {:.3f} of axis {} (0 to 1)", l.found, axis);
    case FriLimit::What::Torque:
      return fmt::format("superposed torque {:.1f} N m of A{} (limit {:.1f})", l.found, axis, l.limit);
    case FriLimit::What::Frame:
      return fmt::format("the commanded frame is no rotation (off by {:.4f})", l.found);
    case FriLimit::What::Speed:
      return fmt::format("the frame steps by {:.5f} {} (limit {:.5f})", l.found, l.axis < 3 ? "m" : "rad",
                         l.limit);
    case FriLimit::What::Wrench:
      return fmt::format("superposed wrench {:.1f} along {} (limit {:.1f})", l.found, kCart[l.axis % 6],
                         l.limit);
  }
  return "";
}

const char* short_words(const FriLimit& l) noexcept {
  switch (l.what) {
    case FriLimit::What::None:
      return "none";
    case FriLimit::What::NotFinite:
      return "not finite";
    case FriLimit::What::Position:
      return "position limit";
    case FriLimit::What::Step:
      return "step too large";
    case FriLimit::What::Start:
      return "not at measured";
    case FriLimit::What::Stiffness:
      return "stiffness range";
    case FriLimit::What::Damping:
      return "damping range";
    case FriLimit::What::Torque:
      return "torque range";
    case FriLimit::What::Frame:
      return "not a rotation";
    case FriLimit::What::Speed:
      return "frame too fast";
    case FriLimit::What::Wrench:
      return "wrench range";
  }
  return "unknown";
}

std::string why_slow(const FriStatus& s, const FriConfig& c) {
  std::string text;
  if (s.quality == FriQuality::Bad) text += fmt::format("quality bad ({}); ", link(s));
  if (s.warning != 0) text += fmt::format("drive warning of {}; ", joints_of(s.warning));
  if (static_cast<double>(s.hottest_c) >= c.warm_c)
    text += fmt::format("a drive has {:.0f} deg C (warm from {:.0f}); ", s.hottest_c, c.warm_c);
  if (s.arrivals_s > 0.0)
    text += fmt::format(
        "the KRC reports a sample time of {:.1f} ms, its datagrams come every {:.1f} ms: {:.1f} ms is used; ",
        1e3 * s.claimed_period_s, 1e3 * s.arrivals_s, 1e3 * s.period_s);
  if (!text.empty()) text.resize(text.size() - 2);
  return text;
}

std::string traffic(const FriStatus& s) {
  std::string text = fmt::format(
      "{} received, {} answered ({} repeated, {} late, {} not sent), {} lost, {} missed by "
      "the KRC",
      s.received, s.answered, s.repeated, s.late, s.unsent, s.lost, s.krc_misses);
  if (const std::string d = dropped(s); !d.empty()) text += "; dropped: " + d;
  return text;
}

}  // namespace colift::hal
