#include "sim_hal/scenario/scenario_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string_view>

namespace colift::sim_hal {
namespace {

std::string list(const std::vector<double>& numbers) {
  return fmt::format("[{}]", fmt::join(numbers, ", "));
}
std::string list(const Vec3& v) {
  return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z());
}

/// "at_s: 1.5", or since a state "at: lift+1.5".
std::string time(std::string_view name, const std::string& in_state, double s) {
  return in_state.empty() ? fmt::format("{}_s: {}", name, s) : fmt::format("{}: {}+{}", name, in_state, s);
}

std::string object_text(const ScenarioObject& o) {
  std::string t = fmt::format("object:\n  kind: {}\n", o.kind);
  if (o.parts.empty()) t += fmt::format("  size: {}\n  mass: {}\n", list(o.size), o.mass);
  t += fmt::format("  cog_offset: {}\n  pose: {{xyz: {}, yaw_deg: {}}}\n  friction: {}\n", list(o.cog_offset),
                   list(o.xyz), o.yaw_deg, o.friction);
  if (!o.parts.empty()) t += "  parts:\n";
  for (const ScenarioPart& p : o.parts)
    t += fmt::format("    - {{shape: {}, size: {}, xyz: {}, rpy_deg: {}, mass: {}}}\n", p.shape, list(p.size),
                     list(p.xyz), list(p.rpy_deg), p.mass);
  return t;
}

std::string clutter_text(const ScenarioClutter& c) {
  std::string t = fmt::format("  - shape: {}\n    size: {}\n    xyz: {}\n    yaw_deg: {}\n", c.shape,
                              list(c.size), list(c.xyz), c.yaw_deg);
  if (!c.moves.empty()) t += "    moves:\n";
  for (const ClutterMove& m : c.moves)
    t += fmt::format("      - {{at_s: {}, to: {}, speed: {}}}\n", m.at_s, list(m.to), m.speed);
  return t;
}

std::string camera_text(const ScenarioCamera& c) {
  return fmt::format("{{xyz: {}, look_at: {}, noise: {}}}\n", list(c.xyz), list(c.look_at), c.noise);
}

std::string event_text(const PartnerScriptEvent& e) {
  std::string t = fmt::format("    - {{{}, do: {}", time("at", e.in_state, e.at_s), e.action);
  const bool stumbles = e.action == "stumble", sways = e.action == "sway";
  if (e.to) t += ", to: " + list(*e.to);
  if (stumbles) t += fmt::format(", force: {}", e.force_n);
  if (sways) t += fmt::format(", by: {}", e.by_m);
  if (stumbles || sways) t += fmt::format(", for_s: {}", e.for_s);
  if (e.direction) t += ", direction: " + list(*e.direction);
  return t + "}\n";
}

std::string partner_text(const ScenarioPartner& p) {
  if (p.kind == "none") return "partner: {kind: none}\n";
  std::string t = fmt::format("partner:\n  kind: {}\n  grasp: {}\n  arrives_s: {}\n  obliging: {}\n", p.kind,
                              list(p.grasp), p.arrives_s, p.obliging);
  if (!p.events.empty()) t += "  events:\n";
  for (const PartnerScriptEvent& e : p.events) t += event_text(e);
  return t;
}

std::string person_text(const ScenarioPerson& p) {
  std::string path;
  for (const Eigen::Vector2d& at : p.path)
    path += fmt::format("{}[{}, {}]", path.empty() ? "" : ", ", at.x(), at.y());
  std::string t = fmt::format("  - {}\n    path: [{}]\n    speed: {}\n    do: {}\n",
                              time("enters", p.in_state, p.enters_s), path, p.speed, p.action);
  if (p.action == "reach") {
    const std::string to = p.reach_to == "point" ? list(p.point) : p.reach_to;
    t += fmt::format("    reach_to: {}\n    with: {}\n    hand_speed: {}\n", to,
                     p.with_foot ? "foot" : "hand", p.hand_speed);
  }
  if (p.leaves_s) t += fmt::format("    leaves_s: {}\n", *p.leaves_s);
  return t;
}

std::string fault_text(const DeviceFaultEvent& f) {
  std::string t = fmt::format("  - {{{}, device: {}, do: {}, for_s: {}", time("at", f.in_state, f.at_s),
                              f.device, f.action, f.for_s);
  if (f.value) t += fmt::format(", value: {}", *f.value);
  if (!f.puck.empty()) t += ", puck: " + f.puck;
  if (f.action == "push") t += fmt::format(", direction: {}, link: {}", list(f.direction), f.link);
  return t + "}\n";
}

}  // namespace

std::string yaml_of(const Scenario& s) {
  std::string t = "schema: colift.scenario/1\n" + object_text(s.object);
  if (!s.clutter.empty()) t += "clutter:\n";
  for (const ScenarioClutter& c : s.clutter) t += clutter_text(c);
  t += "camera: " + camera_text(s.camera);
  if (!s.more_cameras.empty()) t += "more_cameras:\n";
  for (const ScenarioCamera& c : s.more_cameras) t += "  - " + camera_text(c);
  t += partner_text(s.partner);
  t += fmt::format("task: {{kind: {}, height: {}, hold_s: {}}}\n", s.task.kind, s.task.height, s.task.hold_s);
  if (!s.people.empty()) t += "people:\n";
  for (const ScenarioPerson& p : s.people) t += person_text(p);
  if (!s.faults.empty()) t += "faults:\n";
  for (const DeviceFaultEvent& f : s.faults) t += fault_text(f);
  return t;
}

}  // namespace colift::sim_hal
