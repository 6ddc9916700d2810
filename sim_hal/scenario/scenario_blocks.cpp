#include "sim_hal/scenario/scenario_blocks.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <tuple>
#include <utility>

namespace colift::sim_hal {
namespace {

ScenarioObject object_of(const ObjectBlock& block) {
  ScenarioObject object;
  object.kind = block.kind;
  object.size = block.size;
  object.mass = block.mass.value_or(object.mass);
  object.cog_offset = block.cog_offset;
  object.xyz = block.pose.xyz;
  object.yaw_deg = block.pose.yaw_deg;
  object.friction = block.friction;
  const auto volume = [](const PartBlock& part) {
    return part.shape == "cylinder" ? std::numbers::pi * part.size[0] * part.size[0] * part.size[1]
                                    : part.size[0] * part.size[1] * part.size[2];
  };
  double whole = 0.0, together = 0.0;
  for (const PartBlock& part : block.parts) whole += volume(part);
  for (const PartBlock& part : block.parts) {
    const double mass = part.mass ? *part.mass : object.mass * volume(part) / whole;
    together += mass;
    object.parts.push_back({part.shape, part.size, part.xyz, part.rpy_deg, mass});
  }
  if (!block.parts.empty()) object.mass = together;
  return object;
}

ScenarioPerson person_of(const PersonBlock& block) {
  ScenarioPerson p;
  p.enters_s = block.enters_s.value_or(p.enters_s);
  if (const auto relative = parse_relative(block.enters)) std::tie(p.in_state, p.enters_s) = *relative;
  for (std::size_t k = 0; k + 1 < block.path.size(); k += 2)
    p.path.emplace_back(block.path[k], block.path[k + 1]);
  p.speed = block.speed;
  p.action = block.action;
  p.reach_to = block.reach_to;
  p.point = block.point.value_or(Vec3::Zero());
  // what is under the object a hand's breadth above the floor is a foot's place
  p.with_foot = block.with == "foot" || (block.with.empty() && block.reach_to == "under-object");
  p.hand_speed = block.hand_speed;
  p.leaves_s = block.leaves_s;
  return p;
}

}  // namespace

std::optional<std::pair<std::string, double>> parse_relative(std::string_view text) {
  const std::size_t plus = text.find('+');
  const std::string state(text.substr(0, plus));
  if (std::ranges::find(task_state_names(), state) == task_state_names().end()) return std::nullopt;
  if (plus == std::string_view::npos) return std::pair{state, 0.0};
  double seconds = 0.0;
  const std::string_view digits = text.substr(plus + 1);
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), seconds);
  const bool whole = error == std::errc() && end == digits.data() + digits.size() && !digits.empty();
  if (!whole || !(seconds >= kTime_s.low && seconds <= kTime_s.high)) return std::nullopt;
  return std::pair{state, seconds};
}

Scenario scenario_of(const ScenarioBlock& file) {
  Scenario s;
  s.object = object_of(file.object);
  for (const ClutterBlock& c : file.clutter) {
    s.clutter.push_back({c.shape, c.size, c.xyz, c.yaw_deg});
    for (const MoveBlock& m : c.moves) s.clutter.back().moves.push_back({m.at_s, m.to, m.speed});
  }
  s.camera = {file.camera.xyz, file.camera.look_at, file.camera.noise};
  for (const CameraBlock& c : file.more_cameras) s.more_cameras.push_back({c.xyz, c.look_at, c.noise});
  s.partner = {file.partner.kind, file.partner.grasp, file.partner.arrives_s, file.partner.obliging, {}};
  for (const EventBlock& e : file.partner.events) {
    PartnerScriptEvent event{e.at_s.value_or(0.0), e.action, e.to};
    if (const auto relative = parse_relative(e.at)) std::tie(event.in_state, event.at_s) = *relative;
    event.force_n = e.force.value_or(event.force_n);
    event.for_s = e.for_s.value_or(e.action == "sway" ? kSway_s : event.for_s);
    event.by_m = e.by.value_or(event.by_m);
    event.direction = e.direction;
    s.partner.events.push_back(std::move(event));
  }
  s.task = {file.task.kind, file.task.height, file.task.hold_s};
  for (const PersonBlock& person : file.people) s.people.push_back(person_of(person));
  for (const FaultBlock& f : file.faults) {
    DeviceFaultEvent event{f.at_s.value_or(0.0), f.device, f.action, f.for_s};
    if (const auto relative = parse_relative(f.at)) std::tie(event.in_state, event.at_s) = *relative;
    event.value = f.value;
    event.puck = f.puck;
    event.direction = f.direction;
    event.link = f.link;
    s.faults.push_back(std::move(event));
  }
  return s;
}

}  // namespace colift::sim_hal
