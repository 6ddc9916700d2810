#include "sim_hal/scenario/scenario.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string_view>
#include <system_error>
#include <utility>

#include "hal/config/config_file.hpp"
#include "hal/config/field_value.hpp"
#include "hal/config/yaml_tree.hpp"
#include "hal/types/camera_name.hpp"
#include "hal/types/units.hpp"
#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/scenario/scenario_blocks.hpp"
#include "sim_hal/scenario/scenario_lists.hpp"

namespace colift::sim_hal {
namespace {

using hal::Result;
using hal::YamlNode;
using hal::YamlPlace;
using hal::YamlTree;

constexpr std::size_t kMaxParts = 50, kMaxClutter = 100, kMaxEvents = 100, kMaxPeople = 10, kMaxPath = 50;

/// Place of "object.parts[2].size" in a document, or of the last thing on the way to it that there is.
YamlPlace place_of(const YamlTree& tree, std::string_view path) {
  std::uint32_t index = tree.root;
  YamlPlace place = tree.at(index).place;
  while (!path.empty()) {
    const YamlNode& node = tree.at(index);
    const std::size_t end = std::min(path.find_first_of(".["), path.size());
    if (path[0] == '[') {
      const auto item = static_cast<std::size_t>(std::strtoul(path.data() + 1, nullptr, 10));
      if (node.kind != YamlNode::Kind::List || item >= node.children.size()) return place;
      index = node.children[item];
      path.remove_prefix(std::min(path.find(']') + 1, path.size()));
    } else {
      if (node.kind != YamlNode::Kind::Map) return place;
      std::size_t i = 0;
      while (i + 1 < node.children.size() && tree.at(node.children[i]).text != path.substr(0, end)) i += 2;
      if (i + 1 >= node.children.size()) return place;
      index = node.children[i + 1];
      place = tree.at(node.children[i]).place;
      path.remove_prefix(end);
    }
    // an empty value has no place of its own
    if (tree.at(index).kind != YamlNode::Kind::Null) place = tree.at(index).place;
    if (path.starts_with('.')) path.remove_prefix(1);
  }
  return place;
}

/// What the blocks have to be together.
class Checker {
 public:
  Checker(const ScenarioBlock& file, const YamlTree& tree, const std::string& name)
      : file_(file), tree_(tree), name_(name) {}

  Result<> run() const {
    if (auto done = check_object(); !done) return done;
    if (auto done = check_clutter(); !done) return done;
    if (auto done = check_cameras(); !done) return done;
    if (auto done = check_partner(); !done) return done;
    if (auto done = check_people(); !done) return done;
    if (file_.faults.size() > kMaxEvents) return too_many("faults", file_.faults.size(), kMaxEvents);
    for (std::size_t i = 0; i < file_.faults.size(); ++i) {
      const FaultBlock& f = file_.faults[i];
      const std::string path = fmt::format("faults[{}]", i);
      if (auto done = check_time(path, f.at_s.has_value(), f.at); !done) return done;
      if (f.device.starts_with("camera") && f.device != hal::camera_name(0) &&
          f.device > hal::camera_name(file_.more_cameras.size()))
        return refuse(path + ".device", fmt::format("{}.device is {}, but there are {} cameras", path,
                                                    f.device, 1 + file_.more_cameras.size()));
      const auto has = [&](const hal::Choices& c) {
        return std::ranges::find(c.names, f.action) != c.names.end();
      };
      const bool of_arm = has(FaultBlock::of_controller()), of_hand = has(FaultBlock::of_pucks());
      const bool of_kinect = has(FaultBlock::of_kinect());
      const bool can = (!of_arm && !of_hand && !of_kinect) || (of_arm && f.device == "arm") ||
                       (of_hand && f.device == "hand") || (of_kinect && f.device.starts_with("camera"));
      if (!can)
        return refuse(path + ".do",
                      fmt::format("{}.do is {}, but that only {} can do; {} expects one of freeze, drop, "
                                  "unplug, corrupt, late, silent",
                                  path, f.action,
                                  of_arm && of_hand ? "arm and hand"
                                  : of_arm          ? "an arm"
                                  : of_hand         ? "a hand"
                                                    : "a camera",
                                  f.device));
      if (auto done = check_push(f, i); !done) return done;
      if (!f.puck.empty() && f.device != "hand")
        return refuse(path + ".puck", fmt::format("{}.puck is {}, but only a hand has pucks", path, f.puck));
      if (f.action == "blind" && !f.device.starts_with("camera"))
        return refuse(path + ".do",
                      fmt::format("{}.do is blind, but that only a camera can be; {} expects one of freeze, "
                                  "drop, unplug, corrupt, late, silent",
                                  path, f.device));
    }
    return {};
  }

  tl::unexpected<hal::Error> refuse(std::string_view path, std::string reason) const {
    return hal::failure(hal::ErrorCode::BadConfig, hal::place_text(name_, place_of(tree_, path)),
                        std::move(reason));
  }

 private:
  tl::unexpected<hal::Error> too_many(std::string_view path, std::size_t found, std::size_t most) const {
    return refuse(path, fmt::format("{} has {} entries, expected at most {}", path, found, most));
  }

  Result<> check_sizes(const std::string& path, const std::string& kind,
                       const std::vector<double>& size) const {
    const bool round = kind == "cylinder";
    const std::size_t expected = round ? 2 : 3;
    if (size.size() == expected) return {};
    const std::string_view meaning = round             ? "radius and length"
                                     : kind == "table" ? "length and width of the top, height"
                                     : kind == "chair" ? "width and depth of the seat, total height"
                                                       : "x, y and z";
    return refuse(path, fmt::format("{} has {} numbers, but a {} expects {}: {}", path, size.size(), kind,
                                    expected, meaning));
  }

  Result<> check_object() const {
    const ObjectBlock& object = file_.object;
    if (object.kind != "bodies") {
      if (!object.parts.empty())
        return refuse("object.parts",
                      fmt::format("object.parts belongs to kind bodies, but object.kind is {}", object.kind));
      return check_sizes("object.size", object.kind, object.size);
    }
    if (!object.size.empty())
      return refuse("object.size",
                    "object.size has no meaning for kind bodies, expected none: the parts have sizes");
    if (object.parts.empty())
      return refuse("object.parts", "object.parts is empty, but kind bodies expects at least one part");
    if (object.parts.size() > kMaxParts) return too_many("object.parts", object.parts.size(), kMaxParts);
    std::size_t with_mass = 0;
    double together = 0.0;
    for (std::size_t i = 0; i < object.parts.size(); ++i) {
      const PartBlock& part = object.parts[i];
      if (auto done = check_sizes(fmt::format("object.parts[{}].size", i), part.shape, part.size); !done)
        return done;
      with_mass += part.mass ? 1 : 0;
      together += part.mass.value_or(0.0);
    }
    if (with_mass != 0 && with_mass != object.parts.size())
      return refuse("object.parts",
                    fmt::format("{} of {} parts have a mass, expected all or none (object.mass is "
                                "then shared out by volume)",
                                with_mass, object.parts.size()));
    if (with_mass > 0 && object.mass && std::abs(*object.mass - together) > 0.01 * together)
      return refuse("object.mass", fmt::format("object.mass is {}, but the parts weigh {:.6g} together",
                                               *object.mass, together));
    return {};
  }

  /// An outside force: on the arm, and of some size and direction.
  Result<> check_push(const FaultBlock& f, std::size_t i) const {
    if (f.action != "push") return {};
    const auto wrong = [&](const char* key, const char* expected) {
      return refuse(fmt::format("faults[{}].{}", i, key),
                    fmt::format("faults[{}] is a push, expected {}", i, expected));
    };
    if (f.device != "arm") return wrong("device", "device: arm (link: 0 is the hand)");
    if (!f.value || *f.value <= 0.0) return wrong("value", "a value above 0: its force (N)");
    if (f.direction.norm() < 1e-6) return wrong("direction", "a direction that is not zero");
    return {};
  }

  Result<> check_cameras() const {
    const auto check = [&](const std::string& path, const CameraBlock& camera) -> Result<> {
      if ((camera.xyz - camera.look_at).norm() >= 0.05) return {};
      return refuse(path + ".look_at",
                    path + ".look_at is where the camera is, expected a point at least 5 cm away");
    };
    if (auto done = check("camera", file_.camera); !done) return done;
    if (file_.more_cameras.size() > kMaxMoreCameras)
      return too_many("more_cameras", file_.more_cameras.size(), kMaxMoreCameras);
    for (std::size_t n = 0; n < file_.more_cameras.size(); ++n)
      if (auto done = check(fmt::format("more_cameras[{}]", n), file_.more_cameras[n]); !done) return done;
    return {};
  }

  Result<> check_clutter() const {
    if (file_.clutter.size() > kMaxClutter) return too_many("clutter", file_.clutter.size(), kMaxClutter);
    for (std::size_t i = 0; i < file_.clutter.size(); ++i) {
      const ClutterBlock& each = file_.clutter[i];
      if (auto done = check_sizes(fmt::format("clutter[{}].size", i), each.shape, each.size); !done)
        return done;
      if (each.moves.size() > kMaxEvents)
        return too_many(fmt::format("clutter[{}].moves", i), each.moves.size(), kMaxEvents);
      for (std::size_t k = 1; k < each.moves.size(); ++k) {
        if (each.moves[k].at_s >= each.moves[k - 1].at_s) continue;
        const std::string path = fmt::format("clutter[{}].moves[{}].at_s", i, k);
        return refuse(path, fmt::format("{} is {}, expected at least {}: moves stand in the order of time",
                                        path, each.moves[k].at_s, each.moves[k - 1].at_s));
      }
    }
    return {};
  }

  Result<> check_people() const {
    if (file_.people.size() > kMaxPeople) return too_many("people", file_.people.size(), kMaxPeople);
    for (std::size_t i = 0; i < file_.people.size(); ++i) {
      const PersonBlock& each = file_.people[i];
      const std::string path = fmt::format("people[{}]", i);
      if (each.path.empty() || each.path.size() > 2 * kMaxPath)
        return refuse(path + ".path", fmt::format("{}.path has {} points, expected 1 to {}", path,
                                                  each.path.size() / 2, kMaxPath));
      const bool reaches = each.action == "reach";
      if (reaches && each.reach_to.empty())
        return refuse(path, path +
                                ".reach_to is missing, expected where he reaches: robot-hand, object, "
                                "between-fingers, under-object, or a list of 3 numbers");
      for (const auto& [given, key] :
           {std::pair{!each.reach_to.empty(), ".reach_to"}, std::pair{!each.with.empty(), ".with"},
            std::pair{each.point.has_value(), ".point"}})
        if (given && !reaches)
          return refuse(path + key,
                        fmt::format("{}{} belongs to do: reach, but found do: {}", path, key, each.action));
      if ((each.reach_to == "point") != each.point.has_value())
        return refuse(path, fmt::format("{0}.reach_to: point and {0}.point belong together, but only one of "
                                        "them is given",
                                        path));
      if (each.enters_s && !each.enters.empty())
        return refuse(path + ".enters", path + " has enters_s and enters, expected one of them");
      if (auto done = check_relative(path + ".enters", each.enters); !done) return done;
      const double enters_s = each.enters_s.value_or(0.0);
      if (each.leaves_s && each.enters.empty() && *each.leaves_s < enters_s)
        return refuse(path + ".leaves_s", fmt::format("{}.leaves_s is {}, expected at least enters_s, {}",
                                                      path, *each.leaves_s, enters_s));
    }
    return {};
  }

  /// A time since a state of the task.
  Result<> check_relative(const std::string& path, const std::string& text) const {
    if (text.empty() || parse_relative(text)) return {};
    return refuse(path, fmt::format("{} is \"{}\", expected a state of the task and seconds, as in lift+0.7; "
                                    "states are {}",
                                    path, hal::quotable(text, 40), fmt::join(task_state_names(), ", ")));
  }

  /// An absolute time or a relative one.
  Result<> check_time(const std::string& path, bool absolute, const std::string& relative) const {
    if (!absolute && relative.empty())
      return refuse(path, path + ".at_s is missing, expected a number from 0 to 36000, or at: lift+0.7");
    if (absolute && !relative.empty())
      return refuse(path + ".at", path + " has at_s and at, expected one of them");
    return check_relative(path + ".at", relative);
  }

  Result<> check_partner() const {
    const std::vector<EventBlock>& events = file_.partner.events;
    if (events.size() > kMaxEvents) return too_many("partner.events", events.size(), kMaxEvents);
    for (std::size_t i = 0; i < events.size(); ++i) {
      const std::string path = fmt::format("partner.events[{}]", i);
      const EventBlock& e = events[i];
      if (auto done = check_time(path, e.at_s.has_value(), e.at); !done) return done;
      const bool places = e.action == "move" || e.action == "second-hand";
      if (places && !e.to)
        return refuse(path, path + ".to is missing, expected a list of 3 numbers: where he grasps");
      if (!places && e.to)
        return refuse(path + ".to", path + ".to belongs to do: move, but found do: " + e.action);
      const bool pulls = e.action == "stumble", sways = e.action == "sway", either = pulls || sways;
      for (const auto& [misplaced, key, owner] :
           {std::tuple{e.force && !pulls, ".force", "stumble"}, std::tuple{e.by && !sways, ".by", "sway"},
            std::tuple{e.for_s && !either, ".for_s", "stumble or sway"},
            std::tuple{e.direction && !either, ".direction", "stumble or sway"}}) {
        if (!misplaced) continue;
        return refuse(path + key, path + key + " belongs to do: " + owner + ", but found do: " + e.action);
      }
      if (file_.partner.kind == "none")
        return refuse(path, path + " is given, but partner.kind is none: nobody is there to do it");
    }
    return {};
  }

  const ScenarioBlock& file_;
  const YamlTree& tree_;
  const std::string& name_;
};

/// Entries that have to be there, and the group that lacks one.
Result<> check_required(const hal::FieldTable& table, const Checker& checker, bool partner_needed) {
  for (const hal::Field& field : table.fields()) {
    const bool required =
        field.presence == hal::Presence::Required || (partner_needed && field.path == "partner.grasp");
    if (!required || field.origin != hal::kDefaultOrigin) continue;
    const std::size_t dot = field.path.rfind('.');
    const std::string group = dot == std::string::npos ? "" : field.path.substr(0, dot);
    return checker.refuse(group,
                          fmt::format("{} is missing, expected {}", field.path, hal::expectation(field)));
  }
  return {};
}

}  // namespace

Result<Scenario> parse_scenario(const std::string& yaml, const std::string& name) {
  auto tree = hal::parse_yaml(yaml, name);
  if (!tree) return tl::unexpected(tree.error());
  if (auto done = flatten_lists(*tree, name); !done) return tl::unexpected(done.error());
  ScenarioBlock file;
  hal::FieldTable table = hal::table_of(file);
  if (auto done = hal::apply_yaml_tree(table, *tree, name); !done) return tl::unexpected(done.error());
  const Checker checker(file, *tree, name);
  if (auto done = check_required(table, checker, file.partner.kind != "none"); !done)
    return tl::unexpected(done.error());
  if (auto done = checker.run(); !done) return tl::unexpected(done.error());

  Scenario scenario = scenario_of(file);
  scenario.name = std::filesystem::path(name).stem().string();
  // what makes no object names the entry; here it gets its place
  if (auto parts = object_parts(scenario.object); !parts)
    return checker.refuse(parts.error().where, parts.error().detail);
  return scenario;
}

Result<Scenario> load_scenario(const std::filesystem::path& file) {
  const auto text = hal::read_yaml_file(file);
  if (!text) return tl::unexpected(text.error());
  return parse_scenario(*text, hal::quotable(file.string(), 300));
}

Scenario built_in_scenario() {
  const std::string yaml =
#include "built_in_scenario.inc"
      ;
  return parse_scenario(yaml, "table.yaml").value();
}

const std::vector<std::string>& task_state_names() {
  static const std::vector<std::string> names{
      "observe",     "await-partner", "decide", "plan", "approach", "contact", "close",  "verify",
      "await-ready", "test-lift",     "lift",   "hold", "pause",    "yield",   "lower",  "release",
      "retreat",     "back-off",      "halt",   "done", "refused",  "aborted", "stopped"};
  return names;
}

std::string relative_time(const Scenario& scenario) {
  for (std::size_t i = 0; i < scenario.partner.events.size(); ++i)
    if (!scenario.partner.events[i].in_state.empty()) return fmt::format("partner.events[{}].at", i);
  for (std::size_t i = 0; i < scenario.people.size(); ++i)
    if (!scenario.people[i].in_state.empty()) return fmt::format("people[{}].enters", i);
  for (std::size_t i = 0; i < scenario.faults.size(); ++i)
    if (!scenario.faults[i].in_state.empty()) return fmt::format("faults[{}].at", i);
  return {};
}

Pose object_pose(const ScenarioObject& object) {
  Pose X_WT = Pose::Identity();
  X_WT.linear() = Eigen::AngleAxisd(hal::deg_to_rad(object.yaw_deg), Vec3::UnitZ()).toRotationMatrix();
  X_WT.translation() = object.xyz;
  return X_WT;
}

}  // namespace colift::sim_hal
