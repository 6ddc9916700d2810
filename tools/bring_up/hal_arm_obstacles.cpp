#include "tools/bring_up/hal_arm_obstacles.hpp"

#include <fmt/format.h>

#include <cmath>

#include "hal/drivers/kuka_fri/wire/krl_channels.hpp"
#include "hal/os/udp_link.hpp"
#include "hal/types/units.hpp"

namespace colift::tools {
namespace {

using hal::FriQuality;

constexpr double kMismatch_rad = 0.02;  // as the driver's own words
constexpr double kStatic_nm = 0.5;      // 0.2 kg at half the reach: A2 or A4 shows it in most poses
constexpr double kStraight_deg = 15.0;
constexpr float kGoodRate = 0.99f, kMinRate = 0.95f;

FriQuality least(const hal::FriConfig& c) {
  return c.min_quality == "perfect" ? FriQuality::Perfect
         : c.min_quality == "bad"   ? FriQuality::Bad
                                    : FriQuality::Ok;
}

std::string link_text(const hal::FriStatus& s) {
  return fmt::format("answer rate {:.2f}, latency {:.1f} ms, jitter {:.1f} ms, period {:.0f} ms",
                     s.answer_rate, 1e3 * static_cast<double>(s.latency_s),
                     1e3 * static_cast<double>(s.jitter_s), 1e3 * s.period_s);
}

/// Without the port, which a restarted KRC may change.
std::string address_text(const hal::Endpoint& e) {
  const std::string text = hal::to_string(e);
  return text.substr(0, text.find(':'));
}

std::string dropped_advice(const hal::FriStatus& s) {
  const auto count = [&](hal::FriDrop why) { return s.drops[static_cast<std::size_t>(why)]; };
  std::string text;
  if (const auto n = count(hal::FriDrop::Sender); n > 0)
    text =
        fmt::format("{} came from another sender on this port (a second KRC, or an emulator): end it; ", n);
  if (const auto n = count(hal::FriDrop::Content); n > 0)
    text += fmt::format("the last of {} with impossible content: {}; ", n, to_string(s.last_refusal));
  return text +
         fmt::format("set krc: {} in the file behind --robot, if that is the KRC", address_text(s.krc));
}

class Finder {
 public:
  Finder(const ArmView& view, const hal::RobotModel& model) : v_(view), model_(model) {}

  std::vector<Obstacle> find() {
    stall();
    if (silent()) return std::move(found_);
    sender();
    quality();
    drives();
    program();
    control();
    pose();
    external();
    torque_sign();
    address();
    joints();
    remarks();
    return std::move(found_);
  }

 private:
  void refuse(const char* kind, std::string what, std::string next) {
    found_.push_back({kind, std::move(what), std::move(next), true});
  }
  void remark(const char* kind, std::string what, std::string next) {
    remarks_.push_back({kind, std::move(what), std::move(next), false});
  }

  void stall() {
    if (const std::string what = describe_stall(v_.status); !what.empty())
      refuse("stall", what,
             "this explains lost quality, a command mode that ended and drives that went off: run \"colift "
             "doctor\", mend its rows on priority, kernel and governor, close what else runs here, and start "
             "the KRL program anew");
  }

  bool silent() {
    if (v_.status.session != hal::FriSession::Silent) return false;
    refuse("silence", why_not(v_.status, v_.config), silence_advice(v_.config));
    return true;
  }

  void sender() {
    if (const std::string what = describe_sender(v_.status); !what.empty())
      refuse(
          "sender", what,
          v_.status.doubt == hal::FriReason::SecondSender
              ? fmt::format(
                    "\"tcpdump -ni any udp port {}\" shows who sends; end the other one, or name the KRC "
                    "with krc: in the file behind --robot",
                    v_.config.port)
              : fmt::format("compare with e= in C:\\Windows\\vxwin.ini on the KRC, then write krc: {} in the "
                            "file behind --robot",
                            address_text(v_.status.krc)));
  }

  void quality() {
    const auto& s = v_.status;
    const bool enough = s.quality != FriQuality::Invalid && s.quality >= least(v_.config);
    if (enough && s.answer_rate >= kGoodRate) return;
    const double period_s = s.period_s;
    const bool late = static_cast<double>(s.latency_s) > 0.5 * period_s || v_.answers.p99_us > 5e5 * period_s;
    std::string next;
    if (late)
      next = fmt::format(
          "the answers come late: run \"colift doctor\" and mend its rows on priority, kernel and governor, "
          "or open FRI with a longer period (friOpen({:.0f}) in the KRL program)",
          std::ceil(2e3 * period_s));
    else if (s.unsent > 0)
      next = "this program could not send every answer: see the network card and its cable (ip -s link)";
    else
      next =
          "what came was answered in time here, so datagrams or answers get lost in transit: a cable of "
          "its own "
          "from the KRC's network card to this machine, no switch, and no firewall for UDP";
    if (!enough)
      refuse("quality",
             fmt::format("the quality is {}, needed is {} ({})", name_of(s.quality), v_.config.min_quality,
                         link_text(s)),
             s.received < 150 ? "the KRC judges by 100 answers: wait a second and look again" : next);
    else if (s.answer_rate < kMinRate)
      remark("answer-rate", fmt::format("answers get lost ({})", link_text(s)), next);
  }

  void drives() {
    const auto& m = v_.m;
    if (m.error != 0)
      refuse("drive-error", fmt::format("drive error of {} (bits 0x{:02X})", joints_in(m.error), m.error),
             "read the KRC's message window, release the emergency stop, acknowledge at the panel, start the "
             "KRL program anew");
    for (std::size_t i = 0; i < m.temperature_c.size(); ++i) {
      const auto c = static_cast<double>(m.temperature_c[i]);
      if (c >= v_.config.hot_c)
        refuse("hot",
               fmt::format("the drive of A{} has {:.0f} deg C (limit {:.0f})", i + 1, c, v_.config.hot_c),
               "let it cool down; check its fan and its load");
      else if (c >= v_.config.warm_c)
        remark("warm", fmt::format("the drive of A{} has {:.0f} deg C", i + 1, c),
               fmt::format("work slower; at {:.0f} deg C command mode is left", v_.config.hot_c));
    }
    if (m.warning != 0)
      remark("drive-warning",
             fmt::format("drive warning of {} (bits 0x{:02X})", joints_in(m.warning), m.warning),
             "see the KRC's message window; the arm goes slow meanwhile");
    if ((m.power & hal::kFriAllDrives) == hal::kFriAllDrives || m.error != 0) return;
    // the brakes close in a pause of the program; after an emergency stop it does not run any more
    if (m.power == 0 && m.state == hal::FriState::Monitor && v_.config.script == "colift" &&
        v_.program.heart_beats())
      return remark(
          "idle-brakes",
          "the drives are off (power 0x00) while the KRL program runs: the brakes close when nothing "
          "moved for a while",
          "the program's small motion at a start opens them; if the drives then stay off: emergency stop, "
          "enabling switch");
    refuse("drives",
           m.power == 0 ? std::string("the drives are off (power 0x00)")
                        : fmt::format("only some drives are on (power 0x{:02X}, all is 0x7F)", m.power),
           "release the emergency stop, hold the enabling switch (T1, T2) or press \"drives on\" (AUT), and "
           "start the KRL program: its small PTP opens the brakes");
  }

  void program() {
    const auto& c = v_.config;
    if (c.script == "none") {
      remark("program", "no KRL program is asked (script: none)",
             fmt::format("a person has to call friStart at the panel within {:.0f} s", c.ready_s));
      return;
    }
    if (c.script != "colift") {
      remark("program", fmt::format("whether \"{}\" runs on the KRC shows only when it is asked", c.script),
             "expect a refusal with its reason if it is another one");
      return;
    }
    namespace krl = hal::colift_krl;
    const auto& to_pc = v_.m.krl.integer;
    const std::int32_t version = to_pc[krl::kFromVersion];
    if (version == 0) {
      refuse(
          "program", "the KRL program is silent: $FRI_TO_INT[1] is 0, colift.src writes 10001 there",
          "load config/krl/colift.src on the KRC, select it and start it; if another program runs there, say "
          "which with script: stanford, tum, cep, openkc, vendor or none in the file behind --robot");
    } else if (version != krl::kVersion) {
      refuse(
          "program",
          fmt::format(
              "the KRL program is another one or of another version: $FRI_TO_INT[1] is {}, expected {}",
              version, krl::kVersion),
          "load the config/krl/colift.src of this CoLift on the KRC, or name the program with script: in the "
          "file behind --robot");
    } else if (!v_.program.heart_beats() && v_.program.silent_s() > ProgramMonitor::kBeatWatch_s) {
      refuse("program",
             fmt::format("the KRL program is stopped: no heartbeat for {:.1f} s", v_.program.silent_s()),
             v_.m.power == 0
                 ? "with the drives off (power 0x00) this is what an emergency stop leaves: release it, "
                   "acknowledge at the panel, and start the program anew"
                 : "it was halted at the panel or waits for an acknowledgement: acknowledge and press start");
    } else if (to_pc[krl::kFromState] == krl::kCloses) {
      refuse("program", "the KRL program is closing FRI", "start it anew at the panel");
    }
  }

  void control() {
    const auto& m = v_.m;
    const hal::FriControl asked = v_.status.asked;
    if (m.control == asked) return;
    const std::string what =
        fmt::format("the KRC runs {}, asked for is {}", name_of(m.control), name_of(asked));
    const bool program_sets_it = hal::script_sets_strategy(v_.config.script);
    if (m.state == hal::FriState::Command || !program_sets_it)
      refuse(
          "control", what,
          "set $STIFFNESS.STRATEGY in the KRL program before friStart: 10 position, 20 Cartesian, 30 joint "
          "impedance; the flags of a command are fixed by it and may not change in command mode");
    else
      remark("control", what, "the KRL program sets it when it is asked to start");
  }

  void pose() {
    const auto& s = v_.status;
    if (s.pose_mismatch_rad <= kMismatch_rad) return;
    const std::string what = fmt::format("A{} is measured {:.1f} deg away from where the KRC commands it",
                                         s.mismatch_joint + 1, hal::rad_to_deg(s.pose_mismatch_rad));
    const std::string next =
        "check the tool number and its load data in the KRL program (hand and adapter; `colift hal arm load` "
        "measures them), that nobody holds the arm, and that it is not stretched out; then start the KRL "
        "program anew, its PTP takes the pose over";
    if (s.pose_mismatch_rad > 5 * kMismatch_rad)
      refuse("pose", fmt::format("{}: the KRC answers that with \"FRI interpolation error\"", what), next);
    else
      remark("pose", what, next);
  }

  void external() {
    for (std::size_t i = 0; i < v_.m.tau_external_nm.size(); ++i) {
      const double nm = std::abs(static_cast<double>(v_.m.tau_external_nm[i]));
      if (nm > v_.config.start_external_nm)
        refuse("external-torque",
               fmt::format("external torque on A{}: {:.1f} N m (limit to start {:.1f})", i + 1, nm,
                           v_.config.start_external_nm),
               "free the arm of whatever it touches; if it touches nothing, the tool's load data are wrong");
    }
    unexplained();
  }

  void torque_sign() {
    if (const std::string what = describe_torque_sign(v_.status, v_.config); !what.empty())
      remark(
          "torque-sign", what,
          "correct it in the file behind --robot; push the arm by hand during \"colift hal arm watch\": the "
          "torque has the sign of the push");
  }

  void address() {
    const auto& s = v_.status;
    if (!v_.config.krc.empty() || s.krc.address == 0 || s.doubt != hal::FriReason::None) return;
    const auto others = s.drops[static_cast<std::size_t>(hal::FriDrop::Sender)];
    remark("krc-address",
           fmt::format("fri.krc is empty: {}, which sent the first good datagram, is taken for the KRC; {} "
                       "datagrams of other senders were dropped",
                       hal::to_string(s.krc), others),
           fmt::format("if that is the KRC, write krc: {} in the file behind --robot", address_text(s.krc)));
  }

  // In impedance control nothing but the springs holds such a load: the arm sinks by it.
  void unexplained() {
    if (v_.status.asked == hal::FriControl::Position || v_.status.may_command) return;
    Eigen::Index joint = 0;
    hal::JointVector tau;
    for (int i = 0; i < hal::kArmJoints; ++i) tau[i] = v_.m.tau_external_nm[static_cast<std::size_t>(i)];
    const double nm = tau.cwiseAbs().maxCoeff(&joint);
    if (!(nm > kStatic_nm) || nm > v_.config.start_external_nm) return;
    remark(
        "unexplained-load",
        fmt::format("the KRC does not explain a static torque of {:+.1f} N m at A{}: with impedance control "
                    "the arm yields to it",
                    tau[joint], joint + 1),
        "free the arm of whatever it touches; if it touches nothing, the tool's load data are wrong: "
        "\"colift "
        "hal arm load --yes\" says by how much");
  }

  void joints() {
    const hal::JointVector q = measured_rad(v_.m);
    for (int i = 0; i < hal::kArmJoints; ++i) {
      const double left = hal::rad_to_deg(to_limit_rad(model_, i, q[i]));
      if (left < v_.limit_margin_deg)
        remark("joint-limit",
               fmt::format("A{} is {:.1f} deg from its limit, inside the guard's margin of {:.1f}", i + 1,
                           left, v_.limit_margin_deg),
               "it may only move away from it: jog it back at the panel");
    }
    if (std::abs(hal::rad_to_deg(q[1])) < kStraight_deg && std::abs(hal::rad_to_deg(q[3])) < kStraight_deg)
      remark(
          "straight",
          fmt::format("the arm stands nearly straight (A2 {:.0f}, A4 {:.0f} deg)", hal::rad_to_deg(q[1]),
                      hal::rad_to_deg(q[3])),
          "bend A2 and A4 by 45 deg or more at the panel: near the upright pose the KRC tends to refuse, and "
          "the estimate of the wrench means nothing");
  }

  void remarks() {
    const auto& s = v_.status;
    if (s.state == hal::FriState::Command && s.session != hal::FriSession::GettingReady && !s.may_command)
      remark("command-mode", "the KRC is in command mode already, by another session",
             "it mirrors meanwhile; \"colift hal arm hold\" takes it over");
    if (v_.m.safety_limits > 0.0f && v_.m.safety_limits < 0.999f)
      remark("safety-limits", fmt::format("the KRC grants {:.0f} % of its limits", 100 * v_.m.safety_limits),
             "the argument of friStart; motions are slowed to it");
    std::uint64_t dropped = 0;
    for (std::size_t i = 1; i < s.drops.size(); ++i)
      if (static_cast<hal::FriDrop>(i) != hal::FriDrop::Superseded) dropped += s.drops[i];
    if (dropped > 0)
      remark("dropped", fmt::format("{} datagrams were dropped: {}", dropped, traffic(s)), dropped_advice(s));
    if (s.lost > 0)
      remark("lost", fmt::format("{} of {} datagrams of the KRC never came", s.lost, s.lost + s.received),
             "a cable of its own, no switch; see the error counters of the card (ip -s link)");
    found_.insert(found_.end(), remarks_.begin(), remarks_.end());
  }

  const ArmView& v_;
  const hal::RobotModel& model_;
  std::vector<Obstacle> found_, remarks_;
};

}  // namespace

std::vector<Obstacle> obstacles(const ArmView& view, const hal::RobotModel& model) {
  return Finder(view, model).find();
}

std::string obstacles_text(const std::vector<Obstacle>& found) {
  std::string refused, known;
  for (const Obstacle& o : found)
    (o.refuses ? refused : known) += fmt::format("  - {}\n    next: {}\n", o.what, o.next);
  std::string text = refused.empty() ? "command mode  no obstacle found; next: colift hal arm hold\n"
                                     : "command mode  would be refused now:\n" + refused;
  if (!known.empty()) text += "worth knowing\n" + known;
  return text;
}

std::string silence_advice(const hal::FriConfig& c) {
  return fmt::format(
      "is the KRL program started (it calls friOpen)? does friSetup or FRIHOST, FRISOCK in dlrrc.ini name "
      "this machine's address and port {}? does \"ip -br addr\" show that address on the card of the KRC's "
      "cable, with the link up? does a firewall drop UDP? what comes shows in \"tcpdump -ni any udp port "
      "{}\"",
      c.port, c.port);
}

}  // namespace colift::tools
