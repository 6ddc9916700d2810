#include "tools/bring_up/hal_arm_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "hal/os/udp_link.hpp"
#include "hal/types/units.hpp"
#include "tools/bring_up/hal_arm_obstacles.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kSchema = "colift.hal.arm/1";

template <class Vector>
Json list(const Vector& v) {
  Json j = Json::array();
  for (Eigen::Index i = 0; i < v.size(); ++i) j.push_back(v[i]);
  return j;
}

Json joints(const ArmView& v, const hal::RobotModel& model) {
  const hal::JointVector q = measured_rad(v.m), commanded = commanded_rad(v.m);
  Json all = Json::array();
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const auto j = static_cast<std::size_t>(i);
    const auto on = [&](std::uint16_t bits) { return (bits >> i & 1) != 0; };
    all.push_back({{"name", fmt::format("A{}", i + 1)},
                   {"krl", krl_name(i)},
                   {"measured", q[i]},
                   {"commanded", commanded[i]},
                   {"to_limit", to_limit_rad(model, i, q[i])},
                   {"torque", v.m.tau_measured_nm[j]},
                   {"external_torque", v.m.tau_external_nm[j]},
                   {"temperature_c", v.m.temperature_c[j]},
                   {"power", on(v.m.power)},
                   {"error", on(v.m.error)},
                   {"warning", on(v.m.warning)}});
  }
  return all;
}

Json answers(const AnswerSummary& a) {
  Json j = {{"count", a.count},     {"p50_us", a.p50_us},     {"p99_us", a.p99_us},
            {"p999_us", a.p999_us}, {"worst_us", a.worst_us}, {"histogram", Json::array()}};
  for (const auto& bar : a.bars) j["histogram"].push_back({{"up_to_us", bar.up_to_us}, {"count", bar.count}});
  return j;
}

Json connection(const ArmView& v) {
  const auto& s = v.status;
  std::uint64_t dropped = 0;
  for (std::size_t i = 1; i < s.drops.size(); ++i) dropped += s.drops[i];
  return {{"krc", s.received > 0 ? Json(to_string(s.krc)) : Json()},
          {"local", fmt::format("{}:{}", v.config.address, v.config.port)},
          {"session", to_string(s.session)},
          {"reason", hal::short_words(s.reason)},
          {"state", name_of(s.state)},
          {"quality", name_of(s.quality)},
          {"control", static_cast<int>(s.control)},
          {"period_ms", 1e3 * s.period_s},
          {"safety_limits", s.safety_limits},
          {"answer_rate", s.answer_rate},
          {"latency_ms", 1e3 * static_cast<double>(s.latency_s)},
          {"jitter_ms", 1e3 * static_cast<double>(s.jitter_s)},
          {"missed_by_krc", s.krc_misses},
          {"received", s.received},
          {"answered", s.answered},
          {"late", s.late},
          {"not_sent", s.unsent},
          {"lost", s.lost},
          {"dropped", dropped}};
}

Json abilities(const hal::ArmAbilities& can) {
  return {{"joint_impedance", can.joint_impedance},         {"superposed_torque", can.superposed_torque},
          {"cartesian_impedance", can.cartesian_impedance}, {"position", can.position},
          {"min_period_ms", 1e3 * can.min_period_s},        {"max_period_ms", 1e3 * can.max_period_s},
          {"max_stiffness", can.max_stiffness_nm_rad},      {"max_superposed", list(can.max_superposed_nm)}};
}

Json command_mode(const ArmView& v, const hal::RobotModel& model) {
  Json j = {{"ready", true}, {"active", v.status.may_command}, {"obstacles", Json::array()}};
  for (const Obstacle& o : obstacles(v, model)) {
    if (o.refuses) j["ready"] = false;
    j["obstacles"].push_back({{"kind", o.kind}, {"what", o.what}, {"next", o.next}, {"refuses", o.refuses}});
  }
  return j;
}

Json result(const ArmTask& task, const ArmTaskEnd& e) {
  Json j = {{"outcome", to_string(e.how)}, {"because", e.reason},        {"commanded", e.commanded},
            {"cycles", e.cycles},          {"bad_cycles", e.bad_cycles}, {"restarts", e.restarts}};
  if (task.kind != ArmTask::Kind::Watch && task.kind != ArmTask::Kind::Switch) j["control"] = task.control;
  for (const SwitchStep& s : e.switches)
    j["switches"].push_back({{"control", s.control},
                             {"reached", s.reached},
                             {"took_s", s.took_s},
                             {"held_s", s.held_s},
                             {"moved", s.moved_rad}});
  if (!e.commanded || task.kind == ArmTask::Kind::Switch) return j;
  j["commanded_s"] = e.commanded_s;
  j["stiffness"] = task.stiffness_nm_rad;
  j["start"] = list(e.start_rad);
  j["end"] = list(e.end_rad);
  j["goal"] = list(e.goal_rad);
  j["drift"] = list(e.drift_rad);
  j["external_torque"] = list(e.external_nm);
  if (e.load) {
    j["load"] = {{"more_kg", e.load->more.mass_kg},
                 {"more_kgm", list(e.load->more.moment_kgm)},
                 {"sigma_kg", e.load->sigma.mass_kg},
                 {"sigma_kgm", list(e.load->sigma.moment_kgm)},
                 {"expected_kg", e.expected_load.mass_kg},
                 {"expected_kgm", list(e.expected_load.moment_kgm)},
                 {"unexplained_nm", e.load->residual_nm},
                 {"unexplained_joint", fmt::format("A{}", e.load->residual_joint + 1)},
                 {"poses", e.load_samples.size()},
                 {"wrong", e.load->wrong()},
                 {"says", describe(*e.load, e.expected_load)}};
  }
  if (task.kind == ArmTask::Kind::Move) {
    j["joint"] = fmt::format("A{}", task.joint + 1);
    j["asked"] = task.by_rad;
    j["moved"] = e.end_rad[task.joint] - e.start_rad[task.joint];
  }
  return j;
}

}  // namespace

std::string arm_document(const std::string& verb, const ArmView& v, const hal::RobotModel& model,
                         const ArmTask& task, const ArmTaskEnd& end) {
  Json j = {
      {"schema", kSchema}, {"verb", verb}, {"result", result(task, end)}, {"connection", connection(v)}};
  j["answers"] = answers(v.answers);
  j["realtime"] = {{"fifo", v.realtime.fifo},
                   {"priority", v.realtime.priority},
                   {"locked", v.realtime.locked},
                   {"realtime_kernel", v.realtime.realtime_kernel}};
  j["abilities"] = abilities(v.abilities);
  if (v.status.received > 0) {
    j["drives"] = {{"power", v.m.power}, {"error", v.m.error}, {"warning", v.m.warning}};
    j["program"] = {
        {"script", v.config.script}, {"says", program_text(v)}, {"heart_beats", v.program.heart_beats()}};
    j["joints"] = joints(v, model);
    j["tcp_wrench"] = list(v.wrench);
    j["palm"] = list(hal::hand_pose(model, measured_rad(v.m)).translation());
  }
  j["command_mode"] = command_mode(v, model);
  return j.dump();
}

std::string limits_document(const hal::RobotModel& model, const hal::GuardConfig& guard) {
  Json j = {{"schema", kSchema}, {"verb", "limits"}, {"joints", Json::array()}};
  for (int i = 0; i < hal::kArmJoints; ++i) {
    const double low = model.lower_rad()[i], high = model.upper_rad()[i], speed = model.velocity_rad_s()[i];
    const double margin = hal::deg_to_rad(guard.limit_margin_deg);
    j["joints"].push_back(
        {{"name", fmt::format("A{}", i + 1)},
         {"krl", krl_name(i)},
         {"lower", low},
         {"upper", high},
         {"guarded", {low + margin, high - margin}},
         {"velocity", speed},
         {"guarded_velocity", std::min(guard.velocity_fraction * speed, guard.max_velocity_rad_s)},
         {"t1_velocity", std::min(kT1Velocity_rad_s, speed)},
         {"torque", model.effort_nm()[i]}});
  }
  j["guarded_acceleration"] = guard.acceleration_rad_s2;
  j["t1_acceleration"] = kT1Acceleration_rad_s2;
  return j.dump();
}

}  // namespace colift::tools
