#include "tools/bring_up/hal_arm_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hal/drivers/kuka_fri/wire/krl_channels.hpp"
#include "hal/os/udp_link.hpp"
#include "hal/types/units.hpp"
#include "tools/bring_up/hal_arm_obstacles.hpp"

namespace colift::tools {
namespace {

double ms(float s) {
  return 1e3 * static_cast<double>(s);
}

std::string answers_text(const AnswerSummary& a) {
  if (a.count == 0) return "none yet";
  return fmt::format("half within {} us, 99 % within {} us, worst {} us of {}", a.p50_us, a.p99_us,
                     a.worst_us, a.count);
}

std::string realtime_text(const hal::RealtimeReport& r) {
  return fmt::format("{}, memory {}, {} kernel",
                     r.fifo ? fmt::format("SCHED_FIFO {}", r.priority) : "ordinary scheduling",
                     r.locked ? "locked" : "not locked", r.realtime_kernel ? "PREEMPT_RT" : "ordinary");
}

std::string drives_text(const hal::FriMeasurement& m) {
  const bool all = (m.power & hal::kFriAllDrives) == hal::kFriAllDrives;
  return fmt::format("power 0x{:02X} ({}), errors {}, warnings {}", m.power,
                     all            ? "all on"
                     : m.power == 0 ? "all off"
                                    : "off: " + joints_in(static_cast<std::uint16_t>(~m.power & 0x7F)),
                     joints_in(m.error), joints_in(m.warning));
}

std::string outcome_of_program(std::int32_t code) {
  static constexpr std::array<std::string_view, 10> kWords{"at work",
                                                           "done",
                                                           "quality did not come",
                                                           "no such strategy",
                                                           "friStart did not give command mode",
                                                           "command mode was lost",
                                                           "wrong version",
                                                           "no such request",
                                                           "the PC's heartbeat was missed",
                                                           "overtaken"};
  if (code < 0 || static_cast<std::size_t>(code) >= kWords.size()) return fmt::format("result {}", code);
  return std::string(kWords[static_cast<std::size_t>(code)]);
}

std::string abilities_text(const hal::ArmAbilities& can) {
  std::string t;
  const auto add = [&](bool able, const char* what) {
    if (able) t += (t.empty() ? "" : ", ") + std::string(what);
  };
  add(can.joint_impedance, "joint impedance");
  add(can.superposed_torque, "superposed torque");
  add(can.cartesian_impedance, "Cartesian impedance");
  add(can.position, "position");
  return fmt::format(
      "{}; up to {:.0f} N m/rad, {:.0f} to {:.0f} N m superposed; cycles of {:.0f} to {:.0f} ms", t,
      can.max_stiffness_nm_rad, can.max_superposed_nm.minCoeff(), can.max_superposed_nm.maxCoeff(),
      1e3 * can.min_period_s, 1e3 * can.max_period_s);
}

}  // namespace

void ProgramMonitor::note(const hal::FriMeasurement& m, double t_s) {
  const std::int32_t beat = m.krl.integer[hal::colift_krl::kFromBeat];
  if (!any_) first_s_ = t_s;
  if (any_ && beat != beat_) changed_s_ = t_s;
  any_ = true;
  beat_ = beat;
  last_s_ = t_s;
}

AnswerSummary summary_of(const hal::AnswerTimes& times) {
  AnswerSummary a;
  a.count = times.count();
  a.p50_us = times.percentile_us(0.5);
  a.p99_us = times.percentile_us(0.99);
  a.p999_us = times.percentile_us(0.999);
  a.worst_us = times.worst_us();
  constexpr std::size_t kPerOctave = 4;
  for (std::size_t first = 0; first < hal::AnswerTimes::kBuckets; first += kPerOctave) {
    AnswerSummary::Bar bar{hal::AnswerTimes::upper_us(first + kPerOctave - 1), 0};
    for (std::size_t i = first; i < first + kPerOctave; ++i) bar.count += times.in_bucket(i);
    if (bar.count > 0 || !a.bars.empty()) a.bars.push_back(bar);
  }
  while (!a.bars.empty() && a.bars.back().count == 0) a.bars.pop_back();
  return a;
}

ArmView view_of(const hal::FriArm& arm, const ProgramMonitor& program, const hal::RealtimeReport& realtime,
                double limit_margin_deg, double at_s) {
  ArmView v;
  v.config = arm.config();
  v.status = arm.status();
  v.m = arm.measurement();
  v.wrench = arm.external_wrench();
  v.answers = summary_of(arm.answer_times());
  v.program = program;
  v.realtime = realtime;
  v.abilities = arm.abilities();
  v.limit_margin_deg = limit_margin_deg;
  v.at_s = at_s;
  return v;
}

std::string_view krl_name(int joint) {
  static constexpr std::array<std::string_view, hal::kArmJoints> kNames{"A1", "A2", "E1", "A3",
                                                                        "A4", "A5", "A6"};
  return kNames[static_cast<std::size_t>(std::clamp(joint, 0, hal::kArmJoints - 1))];
}

std::string_view name_of(hal::FriState state) {
  switch (state) {
    case hal::FriState::Off:
      return "off";
    case hal::FriState::Monitor:
      return "monitor";
    case hal::FriState::Command:
      return "command";
    case hal::FriState::Invalid:
      break;
  }
  return "unknown";
}

std::string_view name_of(hal::FriQuality quality) {
  switch (quality) {
    case hal::FriQuality::Unacceptable:
      return "unacceptable";
    case hal::FriQuality::Bad:
      return "bad";
    case hal::FriQuality::Ok:
      return "ok";
    case hal::FriQuality::Perfect:
      return "perfect";
    case hal::FriQuality::Invalid:
      break;
  }
  return "unknown";
}

std::string_view name_of(hal::FriControl control) {
  switch (control) {
    case hal::FriControl::Position:
      return "position control (strategy 10)";
    case hal::FriControl::CartesianImpedance:
      return "Cartesian impedance (strategy 20)";
    case hal::FriControl::JointImpedance:
      return "joint impedance (strategy 30)";
    case hal::FriControl::Other:
      break;
  }
  return "another controller";
}

std::string joints_in(std::uint16_t bits) {
  std::string text;
  for (int i = 0; i < hal::kArmJoints; ++i)
    if ((bits >> i & 1) != 0) text += fmt::format("{}A{}", text.empty() ? "" : ", ", i + 1);
  return text.empty() ? "none" : text;
}

std::string program_text(const ArmView& view) {
  if (view.config.script != "colift") return fmt::format("\"{}\" is expected", view.config.script);
  namespace krl = hal::colift_krl;
  const auto& i = view.m.krl.integer;
  if (i[krl::kFromVersion] != krl::kVersion)
    return fmt::format("colift.src does not answer ($FRI_TO_INT[1] is {})", i[krl::kFromVersion]);
  static constexpr std::array<std::string_view, 6> kStates{"begins",   "waits", "starts",
                                                           "commands", "stops", "closes"};
  const std::int32_t state = i[krl::kFromState];
  std::string text =
      fmt::format("colift.src {}", state >= 0 && state < 6 ? kStates[static_cast<std::size_t>(state)]
                                                           : std::string_view("is in an unknown state"));
  if (i[krl::kFromNumber] != 0)
    text += fmt::format(", last request: {}", outcome_of_program(i[krl::kFromResult]));
  return text + (view.program.heart_beats() ? ", hears this program" : ", heartbeat not seen yet");
}

hal::JointVector measured_rad(const hal::FriMeasurement& m) {
  hal::JointVector q;
  for (int i = 0; i < hal::kArmJoints; ++i)
    q[i] = static_cast<double>(m.q_measured_rad[static_cast<std::size_t>(i)]);
  return q;
}

hal::JointVector commanded_rad(const hal::FriMeasurement& m) {
  hal::JointVector q;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const auto j = static_cast<std::size_t>(i);
    q[i] = static_cast<double>(m.q_commanded_rad[j] + m.q_commanded_fri_rad[j]);
  }
  return q;
}

double to_limit_rad(const hal::RobotModel& model, int joint, double q_rad) {
  return std::min(q_rad - model.lower_rad()[joint], model.upper_rad()[joint] - q_rad);
}

std::string arm_screen(const ArmView& v, const hal::RobotModel& model) {
  const auto& s = v.status;
  const auto& m = v.m;
  std::string t;
  if (s.received == 0)
    return fmt::format("KRC           nothing came on {}:{}\n", v.config.address, v.config.port) +
           obstacles_text(obstacles(v, model));
  t += fmt::format("KRC           {} to {}:{}, every {:.1f} ms\n", to_string(s.krc), v.config.address,
                   v.config.port, 1e3 * s.period_s);
  t += fmt::format("FRI           {} mode, quality {}, {}; this program: {}\n", name_of(m.state),
                   name_of(m.quality), name_of(m.control), to_string(s.session));
  t += fmt::format(
      "KRC's figures answer rate {:.3f}, latency {:.2f} ms, jitter {:.2f} ms, {} answers missed\n",
      m.answer_rate, ms(m.latency_s), ms(m.jitter_s), m.misses);
  t += fmt::format("answer times  {}\n", answers_text(v.answers));
  t += fmt::format("datagrams     {}\n", traffic(s));
  t += fmt::format("this machine  {}\n", realtime_text(v.realtime));
  t += fmt::format("it can        {}\n", abilities_text(v.abilities));
  t += fmt::format("drives        {}\n", drives_text(m));
  t += fmt::format("KRL program   {}\n\n", program_text(v));

  const hal::JointVector q = measured_rad(m), cmd = commanded_rad(m);
  t += "joint  KRL   measured  commanded  to limit  torque  external  drive\n"
       "                  deg        deg       deg     N m       N m  deg C\n";
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const auto j = static_cast<std::size_t>(i);
    const auto on = [&](std::uint16_t bits) { return (bits >> i & 1) != 0; };
    t += fmt::format("A{}     {}    {:>8.2f}   {:>8.2f}  {:>8.1f}  {:>6.1f}  {:>8.1f}  {:>5.0f} {}{}{}\n",
                     i + 1, krl_name(i), hal::rad_to_deg(q[i]), hal::rad_to_deg(cmd[i]),
                     hal::rad_to_deg(to_limit_rad(model, i, q[i])), m.tau_measured_nm[j],
                     m.tau_external_nm[j], m.temperature_c[j], on(m.power) ? "on" : "off",
                     on(m.error) ? " ERROR" : "", on(m.warning) ? " warning" : "");
  }
  const hal::Vec3 palm = hal::hand_pose(model, q).translation();
  t += fmt::format(
      "\nTCP wrench    force ({:.1f}, {:.1f}, {:.1f}) N, torque ({:.2f}, {:.2f}, {:.2f}) N m on the arm, "
      "in $STIFFNESS.TASKFRAME\n",
      v.wrench[0], v.wrench[1], v.wrench[2], v.wrench[3], v.wrench[4], v.wrench[5]);
  t += fmt::format("palm          ({:.3f}, {:.3f}, {:.3f}) m in the base, by the model\n\n", palm.x(),
                   palm.y(), palm.z());
  if (s.may_command)
    t += "command mode  active\n";
  else
    t += obstacles_text(obstacles(v, model));
  return t;
}

std::string arm_line(const ArmView& v) {
  const auto& s = v.status;
  if (s.session == hal::FriSession::Silent)
    return fmt::format("{:8.1f} s  silent: {}", v.at_s, hal::short_words(s.reason));
  return fmt::format(
      "{:8.1f} s  {}, quality {}, answer rate {:.3f}, latency {:.2f} ms, jitter {:.2f} ms, {} missed, {} "
      "lost, power "
      "0x{:02X}; answers p99 {} us, worst {} us",
      v.at_s, name_of(s.state), name_of(s.quality), s.answer_rate, ms(s.latency_s), ms(s.jitter_s),
      s.krc_misses, s.lost, s.power, v.answers.p99_us, v.answers.worst_us);
}

std::string histogram_text(const AnswerSummary& a) {
  if (a.count == 0) return "";
  constexpr std::size_t kWidth = 40;
  std::uint64_t most = 1;
  for (const auto& bar : a.bars) most = std::max(most, bar.count);
  std::string t = "from datagram to answer\n";
  for (const auto& bar : a.bars) {
    const auto length = static_cast<std::size_t>((bar.count * kWidth + most - 1) / most);
    t += fmt::format("  up to {:>7} us  {:>9}  {}\n", bar.up_to_us, bar.count, std::string(length, '#'));
  }
  return t;
}

std::string limits_table(const hal::RobotModel& model, const hal::GuardConfig& guard) {
  std::string t =
      "joint  KRL      limits        guarded    speed  guarded    in T1   torque\n"
      "                   deg            deg    deg/s    deg/s    deg/s      N m\n";
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double low = hal::rad_to_deg(model.lower_rad()[i]), high = hal::rad_to_deg(model.upper_rad()[i]);
    const double speed = model.velocity_rad_s()[i];
    t += fmt::format(
        "A{}     {}    {:>5.0f} .. {:<4.0f}  {:>5.1f} .. {:<6.1f} {:>5.0f}    {:>5.0f}    {:>5.1f}    "
        "{:>5.0f}\n",
        i + 1, krl_name(i), low, high, low + guard.limit_margin_deg, high - guard.limit_margin_deg,
        hal::rad_to_deg(speed),
        hal::rad_to_deg(std::min(guard.velocity_fraction * speed, guard.max_velocity_rad_s)),
        hal::rad_to_deg(std::min(kT1Velocity_rad_s, speed)), model.effort_nm()[i]);
  }
  t += fmt::format(
      "acceleration: guarded {:.1f} rad/s^2, in T1 {:.1f} rad/s^2; stiffness up to {:.0f} N m/rad, "
      "superposed torque up to {:.0f} N m\n",
      guard.acceleration_rad_s2, kT1Acceleration_rad_s2, guard.max_stiffness_nm_rad, guard.max_superposed_nm);
  return t;
}

}  // namespace colift::tools
