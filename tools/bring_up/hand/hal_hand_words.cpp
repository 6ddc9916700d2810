#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "hal/types/units.hpp"
#include "tools/bring_up/hand/hal_hand_task.hpp"

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
  if (!r.remark.empty()) t += fmt::format("start     {}\n", r.remark.str());
  if (!r.why.empty()) t += fmt::format("last move {}\n", r.why.str());
  if (!r.warning.empty()) t += fmt::format("warning   {}\n", r.warning.str());
  if (!v.health.last_error.empty() && v.health.last_error != r.why.str() &&
      v.health.last_error != r.warning.str() && v.health.last_error != r.remark.str())
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

namespace {

// Each cell as a letter: '.' none, 1 to 9 in steps of a tenth of what a cell can show, '#' beyond. The tip of
// a finger is up.
std::string cells_text(const std::array<hal::TactileArray, hal::kTactileArrays>& arrays) {
  constexpr float kTouch_n_cm2 = 0.1F, kStep_n_cm2 = 1.6F;
  constexpr std::array<std::size_t, 4> kPalmFirst{0, 5, 12, 19}, kPalmCount{5, 7, 7, 5};
  const auto letter = [&](std::size_t array, std::size_t cell) {
    const float p = arrays[array].pressure_n_cm2[cell];
    if (std::isnan(p)) return ' ';
    if (p < kTouch_n_cm2) return '.';
    const int step = 1 + static_cast<int>(p / kStep_n_cm2);
    return step > 9 ? '#' : static_cast<char>('0' + step);
  };
  const auto silent = [](const hal::TactileArray& a) { return std::isnan(a.pressure_n_cm2[0]); };
  if (std::all_of(arrays.begin(), arrays.end(), silent)) return {};
  std::string t = "\n      F1    F2    F3    palm\n";
  for (std::size_t row = 0; row < 8; ++row) {
    std::string line = "      ";
    for (std::size_t finger = 0; finger < hal::kFingers; ++finger) {
      for (std::size_t column = 0; column < 3; ++column) line += letter(finger, 3 * (7 - row) + column);
      line += "   ";
    }
    if (row < kPalmFirst.size()) {
      line.append((7 - kPalmCount[row]) / 2, ' ');
      for (std::size_t i = 0; i < kPalmCount[row]; ++i) line += letter(hal::kPalmArray, kPalmFirst[row] + i);
    }
    t += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return t;
}

}  // namespace

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
  if (v.state) t += cells_text(v.state->tactile);
  if (std::isnan(v.report.palm_force_n) && v.state && std::isnan(v.state->tip_force_n[0]))
    t += "no tactile pad reports anything: a hand without the tactile option, or tactile: off\n";
  return t;
}

std::string bundle_document(const std::string& file, const std::string& fault) {
  Json j = {{"schema", "colift.hal.hand/1"}, {"verb", "doctor"}, {"file", file}, {"fault", nullptr}};
  if (!fault.empty()) j["fault"] = fault;
  return j.dump();
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

namespace {

using hal::barrett::Property;

std::string puck_name(std::size_t i) {
  return i == kSpread ? std::string("spread") : fmt::format("F{}", i + 1);
}

std::string status_word(const hal::PuckReading& p) {
  if (!p.answers) return "silent";
  const auto stat = p.of(Property::Stat);
  if (!stat) return "-";
  return *stat == 0 ? "asleep" : *stat == 1 ? "error" : *stat == 2 ? "ready" : fmt::format("{}", *stat);
}

std::string zero_word(const hal::PuckReading& p) {
  return !p.awake() ? "-" : p.zero_known() ? "known" : "unknown";
}

Json number(const std::optional<std::int32_t>& value) {
  return value ? Json(*value) : Json(nullptr);
}

}  // namespace

std::string hand_reading_fault(const hal::HandReading& reading) {
  std::string t;
  for (std::size_t i = 0; i < reading.pucks.size(); ++i) {
    const hal::PuckReading& p = reading.pucks[i];
    const char* comma = t.empty() ? "" : "; ";
    if (!p.answers)
      t += fmt::format("{}{} is silent, others answer: its puck or its cable inside the hand", comma,
                       puck_name(i));
    else if (p.of(Property::Stat) == 1)
      t += fmt::format("{}{} reports an error (code {})", comma, puck_name(i),
                       p.of(Property::Error).value_or(-1));
  }
  return t;
}

std::string hand_reading_text(const std::string& bus, const hal::HandReading& reading) {
  std::string t = fmt::format("hand      {}: {} of 4 pucks answer, within {:.1f} ms; read only\n\n", bus,
                              reading.answering(), 1e3 * hal::seconds(reading.round_trip));
  t += "                      F1       F2       F3   spread\n";
  const auto row = [&](const char* name, const auto& text_of) {
    t += fmt::format("{:16}", name);
    for (const hal::PuckReading& p : reading.pucks) t += fmt::format("{:>9}", text_of(p));
    t += "\n";
  };
  const auto numbers = [&](const char* name, Property property, const char* unit = "") {
    row(fmt::format("{:10}{}", name, unit).c_str(), [&](const hal::PuckReading& p) {
      const auto v = p.of(property);
      return v ? fmt::format("{}", *v) : std::string("-");
    });
  };
  row("status", status_word);
  numbers("firmware", Property::Vers);
  numbers("serial no.", Property::Sn);
  row("role", [](const hal::PuckReading& p) {
    const auto role = p.of(Property::Role);
    return role ? fmt::format("{:#06x}", *role & 0xffff) : std::string("-");
  });
  row("groups", [](const hal::PuckReading& p) {
    const auto a = p.of(Property::GrpA), b = p.of(Property::GrpB), c = p.of(Property::GrpC);
    return a && b && c ? fmt::format("{},{},{}", *a, *b, *c) : std::string("-");
  });
  numbers("mode", Property::Mode);
  numbers("position", Property::P, "counts");
  row("zero", zero_word);
  numbers("torque T", Property::T, "units");
  numbers("limit MT", Property::Mt, "units");
  numbers("TSTOP", Property::Tstop, "ms");
  numbers("strain", Property::Sg, "counts");
  numbers("puck", Property::Temp, "deg C");
  numbers("motor", Property::Therm, "deg C");
  numbers("limit", Property::Otemp, "deg C");
  numbers("supply", Property::Vbus, "V");
  numbers("awake for", Property::Upsecs, "s");
  bool asleep = false, lost = false;
  for (std::size_t i = 0; i < reading.pucks.size(); ++i) {
    const hal::PuckReading& p = reading.pucks[i];
    asleep = asleep || p.of(Property::Stat) == 0;
    lost = lost || (p.awake() && !p.zero_known());
    const auto mode = p.of(Property::Mode);
    if (i != kSpread && mode && *mode != 0)
      t += fmt::format("{} is on (MODE {}){}\n", puck_name(i), *mode,
                       p.of(Property::Tstop) == 0 ? ", and nothing but a command ends that (TSTOP 0)" : "");
  }
  if (asleep)
    t += "a puck is asleep, as after switching on, and does not know its zero: colift hal hand init\n";
  else if (lost)
    t += "a zero is not known: colift hal hand init\n";
  return t;
}

std::string hand_reading_document(const std::string& bus, const hal::HandReading& reading) {
  const std::string fault = hand_reading_fault(reading);
  Json j = {{"schema", "colift.hal.hand/1"}, {"verb", "state"}};
  j["result"] = {{"outcome", to_string(fault.empty() ? TaskOutcome::Done : TaskOutcome::Failed)},
                 {"because", fault},
                 {"moved", false}};
  j["bus"] = {{"name", bus}, {"round_trip_ms", 1e3 * hal::seconds(reading.round_trip)}};
  j["pucks"] = Json::array();
  for (std::size_t i = 0; i < reading.pucks.size(); ++i) {
    const hal::PuckReading& p = reading.pucks[i];
    Json puck = {{"name", puck_name(i)},
                 {"silent", !p.answers},
                 {"status", status_word(p)},
                 {"zero_lost", p.awake() ? Json(!p.zero_known()) : Json(nullptr)},
                 {"groups",
                  {number(p.of(Property::GrpA)), number(p.of(Property::GrpB)), number(p.of(Property::GrpC))}},
                 {"joint", number(p.joint)}};
    constexpr std::array<std::pair<const char*, Property>, 16> kKeys{{{"error", Property::Error},
                                                                      {"firmware", Property::Vers},
                                                                      {"role", Property::Role},
                                                                      {"serial", Property::Sn},
                                                                      {"mode", Property::Mode},
                                                                      {"position", Property::P},
                                                                      {"torque_units", Property::T},
                                                                      {"torque_limit_units", Property::Mt},
                                                                      {"tstop_ms", Property::Tstop},
                                                                      {"hold", Property::Hold},
                                                                      {"strain_counts", Property::Sg},
                                                                      {"puck_c", Property::Temp},
                                                                      {"motor_c", Property::Therm},
                                                                      {"limit_c", Property::Otemp},
                                                                      {"supply_v", Property::Vbus},
                                                                      {"awake_for_s", Property::Upsecs}}};
    for (const auto& [key, property] : kKeys) puck[key] = number(p.of(property));
    j["pucks"].push_back(std::move(puck));
  }
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
  if (!e.motors.empty()) {
    j["result"]["motors"] = e.motors;
    j["result"]["modes"] = Json::array();
    for (const auto& mode : e.modes) j["result"]["modes"].push_back(number(mode));
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
    j["state"]["tactile"] = Json::array();
    for (const hal::TactileArray& a : s.tactile) j["state"]["tactile"].push_back(a.pressure_n_cm2);
  }
  j["pucks"] = Json::array();
  for (std::size_t i = 0; i < r.silent.size(); ++i)
    j["pucks"].push_back({{"name", i == kSpread ? std::string("spread") : fmt::format("F{}", i + 1)},
                          {"silent", r.silent[i]},
                          {"zero_lost", r.zero_lost[i]},
                          {"broken_away", i < kSpread && r.broken_away[i]},
                          {"temperature_c", r.temperature_c[i]}});
  j["start"] = r.remark.str();
  j["palm_force"] = r.palm_force_n;
  j["loaded"] = r.loaded;
  j["slipped"] = r.slipped;
  j["warm"] = r.warm;
  j["hot"] = r.hot;
  j["over_torque"] = r.over_torque;
  return j.dump();
}

}  // namespace colift::tools
