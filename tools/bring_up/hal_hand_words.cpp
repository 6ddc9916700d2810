#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/types/units.hpp"
#include "tools/bring_up/hal_hand_task.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kSpread = 3;

const char* word(hal::CanHealth::State state) {
  using enum hal::CanHealth::State;
  switch (state) {
    case Closed:
      return "closed";
    case Down:
      return "down";
    case Active:
      return "error-active";
    case Warning:
      return "error-warning";
    case Passive:
      return "error-passive";
    case BusOff:
      return "bus-off";
  }
  return "unknown";
}

const char* word(hal::DeviceHealth::State state) {
  using enum hal::DeviceHealth::State;
  switch (state) {
    case Absent:
      return "absent";
    case Opening:
      return "open";
    case Streaming:
      return "active";
    case Stalled:
      return "stalled";
    case Lost:
      return "lost";
    case Failed:
      return "failed";
  }
  return "unknown";
}

std::string cell(double value, int digits) {
  return std::isnan(value) ? fmt::format("{:>9}", "-") : fmt::format("{:>9.{}f}", value, digits);
}

std::string doing(const HandView& v) {
  std::string t = v.state && v.state->moving ? "moves" : "stands";
  if (v.state && v.state->held) t += ", holds something";
  if (v.report.loaded) t += ", counts as loaded";
  if (v.report.slipped) t += ", SLIPPED";
  if (v.report.warm) t += ", warm";
  if (v.report.hot) t += ", HOT";
  if (v.report.over_torque) t += ", over torque";
  return t;
}

}  // namespace

std::string hand_screen(const HandView& v) {
  const auto& r = v.report;
  std::string t = fmt::format("hand      {}: {}; {} answers used, {} dropped\n", v.bus, word(v.health.state),
                              v.health.accepted, v.health.rejected);
  t += fmt::format("bus       {}, {} error frames, {} bus-offs, {} not sent\n\n", word(r.bus), r.error_frames,
                   r.bus_offs, r.not_sent);
  t += "                      F1       F2       F3   spread\n";
  if (v.state) {
    const auto& s = *v.state;
    const auto row = [&](const char* name, const std::array<double, hal::kFingers>& values, double scale,
                         int digits, double last) {
      t += fmt::format("{:16}", name);
      for (const double value : values) t += cell(scale * value, digits);
      t += std::isnan(last) ? "\n" : fmt::format("{}\n", cell(scale * last, digits));
    };
    const double none = std::nan("");
    row("inner     deg", s.finger_rad, hal::kDegPerRad, 1, s.spread_rad);
    row("outer     deg", s.outer_rad, hal::kDegPerRad, 1, none);
    row("strain    N m", s.torque_nm, 1.0, 2, none);
    row("pad       N", s.tip_force_n, 1.0, 1, none);
  }
  t += fmt::format("{:16}", "heat      deg C");
  for (const double c : r.temperature_c) t += cell(c, 0);
  t += "\n";
  for (std::size_t i = 0; i < r.silent.size(); ++i) {
    const std::string name = i == kSpread ? std::string("the spread") : fmt::format("F{}", i + 1);
    if (r.silent[i]) t += fmt::format("          the puck of {} is silent\n", name);
    if (r.zero_lost[i]) t += fmt::format("          the puck of {} has lost its zero\n", name);
    if (i < kSpread && r.broken_away[i])
      t += fmt::format("          {} is broken away: its clutch released\n", name);
  }
  t += fmt::format("\npalm      {} N\nit        {}\n",
                   std::isnan(r.palm_force_n) ? "-" : fmt::format("{:.1f}", r.palm_force_n), doing(v));
  if (!r.why.empty()) t += fmt::format("last move {}\n", r.why.str());
  if (!r.warning.empty()) t += fmt::format("warning   {}\n", r.warning.str());
  if (!v.health.last_error.empty() && v.health.last_error != r.why.str() &&
      v.health.last_error != r.warning.str())
    t += fmt::format("says      {}\n", v.health.last_error);
  return t;
}

std::string hand_line(const HandView& v) {
  if (!v.state) return fmt::format("{:8.1f} s  {}: {}", v.at_s, word(v.health.state), v.health.last_error);
  const auto& s = *v.state;
  return fmt::format(
      "{:8.1f} s  fingers {:.1f} {:.1f} {:.1f}, spread {:.1f} deg; strain {:.2f} {:.2f} {:.2f} N m; pads "
      "{:.1f} {:.1f} {:.1f} N; {}; bus {}",
      v.at_s, hal::rad_to_deg(s.finger_rad[0]), hal::rad_to_deg(s.finger_rad[1]),
      hal::rad_to_deg(s.finger_rad[2]), hal::rad_to_deg(s.spread_rad), s.torque_nm[0], s.torque_nm[1],
      s.torque_nm[2], s.tip_force_n[0], s.tip_force_n[1], s.tip_force_n[2], doing(v), word(v.report.bus));
}

std::string tactile_text(const HandView& v) {
  constexpr double kBar_n = 0.5;
  constexpr double kMost = 60.0;
  std::string t;
  const auto bar = [&](const std::string& name, double force) {
    const double length = std::isnan(force) ? 0.0 : std::clamp(force / kBar_n, 0.0, kMost);
    t += fmt::format("{:5} {} N  {}\n", name, cell(force, 1),
                     std::string(static_cast<std::size_t>(length), '#'));
  };
  for (std::size_t f = 0; f < hal::kFingers; ++f)
    bar(fmt::format("F{}", f + 1), v.state ? v.state->tip_force_n[f] : std::nan(""));
  bar("palm", v.report.palm_force_n);
  if (std::isnan(v.report.palm_force_n) && v.state && std::isnan(v.state->tip_force_n[0]))
    t += "no tactile pad reports anything: a hand without the tactile option, or tactile: off\n";
  return t;
}

std::string hand_emergency_document(const std::array<hal::FingerOpening, 3>& fingers) {
  Json j = {{"schema", "colift.hal.hand/1"}, {"verb", "emergency-open"}, {"fingers", Json::array()}};
  for (std::size_t i = 0; i < fingers.size(); ++i)
    j["fingers"].push_back({{"name", fmt::format("F{}", i + 1)},
                            {"answers", fingers[i].answers},
                            {"opened_deg", fingers[i].opened_deg()},
                            {"rests", fingers[i].rests}});
  return j.dump();
}

std::string hand_document(const std::string& verb, const HandView& v, const HandTask& task,
                          const HandTaskEnd& e) {
  const auto& r = v.report;
  Json j = {{"schema", "colift.hal.hand/1"}, {"verb", verb}};
  j["result"] = {{"outcome", to_string(e.how)}, {"because", e.reason}, {"moved", e.moved},
                 {"took_s", e.took_s},          {"states", e.states},  {"bad_states", e.bad_states}};
  if (task.kind == HandTask::Kind::Close || task.kind == HandTask::Kind::Grip) {
    j["result"]["torque_asked"] = task.torque_nm;
    j["result"]["held"] = e.after.held && !e.weak;
    j["result"]["weak"] = e.weak;
    j["result"]["least_force"] = e.min_force_n;
  }
  j["bus"] = {{"name", v.bus},
              {"state", word(r.bus)},
              {"error_frames", r.error_frames},
              {"bus_offs", r.bus_offs},
              {"not_sent", r.not_sent},
              {"accepted", v.health.accepted},
              {"rejected", v.health.rejected}};
  j["health"] = {{"state", word(v.health.state)}, {"says", v.health.last_error}};
  j["state"] = nullptr;
  if (v.state) {
    const auto& s = *v.state;
    j["state"] = {{"fingers", s.finger_rad}, {"outer", s.outer_rad},       {"spread", s.spread_rad},
                  {"torque", s.torque_nm},   {"tip_force", s.tip_force_n}, {"moving", s.moving},
                  {"held", s.held}};
  }
  j["pucks"] = Json::array();
  for (std::size_t i = 0; i < r.silent.size(); ++i)
    j["pucks"].push_back({{"name", i == kSpread ? std::string("spread") : fmt::format("F{}", i + 1)},
                          {"silent", r.silent[i]},
                          {"zero_lost", r.zero_lost[i]},
                          {"broken_away", i < kSpread && r.broken_away[i]},
                          {"temperature_c", r.temperature_c[i]}});
  j["palm_force"] = r.palm_force_n;
  j["loaded"] = r.loaded;
  j["slipped"] = r.slipped;
  j["warm"] = r.warm;
  j["hot"] = r.hot;
  j["over_torque"] = r.over_torque;
  return j.dump();
}

}  // namespace colift::tools
