#include <fmt/format.h>

#include <cstdio>
#include <ctime>
#include <nlohmann/json.hpp>

#include "control/task/machine/task_machine.hpp"
#include "tools/check/check_calibration.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/robot_file.hpp"

namespace colift::tools {

namespace {

/// The rules of the job: a drawing for people, a list for programs.
int show_rules(bool json) {
  if (!json) {
    std::fputs(control::graph().c_str(), stdout);
    return kDone;
  }
  nlohmann::ordered_json j = {{"schema", "colift.rules/1"}};
  for (int t = 0; t < control::kTasks; ++t) {
    const auto task = static_cast<control::Task>(t);
    j["states"].push_back({{"state", control::word(task)},
                           {"waits_for", control::waits_for(task)},
                           {"end", control::is_end(task)},
                           {"loaded", control::is_loaded(task)},
                           {"moving", control::is_moving(task)}});
  }
  for (const control::Rule& rule : control::rules())
    j["rules"].push_back({{"from", control::word(rule.from)},
                          {"on", control::word(rule.on)},
                          {"to", control::word(rule.to)},
                          {"because", rule.reason}});
  std::puts(j.dump().c_str());
  return kDone;
}

/// What was found about the calibration and the picture; both may be missing.
struct CameraFindings {
  std::string file;
  std::optional<CalibrationCheck> calibration;
  std::optional<GroundCheck> ground;
};

hal::Result<CameraFindings> look_at_camera(const Setup& setup, const CheckedCamera& checked) {
  CameraFindings out;
  const auto robot = read_robot_file(checked.robot);
  if (!robot) return tl::unexpected(robot.error());
  std::optional<perception::CalibrationFile> calibration = setup.calibration;
  out.file = setup.config.calibration_file;
  if (!calibration && !robot->calibration.empty()) {
    auto read = perception::load_calibration(robot->calibration, setup.config.calibration);
    if (!read) return tl::unexpected(read.error());
    calibration = std::move(*read);
    out.file = robot->calibration;
  }
  if (checked.frame && !calibration)
    return hal::failure(
        hal::ErrorCode::BadInput, "--frame",
        "goes with a calibration: --set calibration_file=FILE, or --robot FILE whose camera has one");
  if (!calibration) return out;
  out.calibration =
      check_calibration(*calibration, setup.config.calibration, robot->kinect, std::time(nullptr));
  if (out.calibration->reason)
    return hal::failure(hal::ErrorCode::BadConfig, out.file, *out.calibration->reason);
  if (!checked.frame) return out;
  const auto frame = checked.read_frame();
  if (!frame) return tl::unexpected(frame.error());
  out.ground = check_ground(*frame, calibration->X_BC(), setup.config);
  return out;
}

nlohmann::ordered_json json_of(const CameraFindings& found) {
  if (!found.calibration) return nullptr;
  const CalibrationCheck& c = *found.calibration;
  nlohmann::ordered_json j = {{"file", found.file}, {"because", c.summary}, {"age_days", nullptr}};
  if (c.age_days) j["age_days"] = *c.age_days;
  j["height_m"] = c.height_m;
  j["down_deg"] = c.down_deg;
  j["warnings"] = c.warnings;
  j["ground"] = nullptr;
  if (!found.ground) return j;
  j["ground"] = {{"ok", found.ground->good},
                 {"because", found.ground->reason},
                 {"tilt_deg", nullptr},
                 {"height_m", nullptr}};
  if (found.ground->tilt_deg) j["ground"]["tilt_deg"] = *found.ground->tilt_deg;
  if (found.ground->height_m) j["ground"]["height_m"] = *found.ground->height_m;
  return j;
}

void say(const CameraFindings& found) {
  if (found.calibration) {
    fmt::print(stderr, "calibration {}: {}\n", found.file, found.calibration->summary);
    for (const std::string& w : found.calibration->warnings) fmt::print(stderr, "  look at it: {}\n", w);
  }
  if (found.ground) fmt::print(stderr, "{}\n", found.ground->reason);
}

}  // namespace

int cmd_check(const CommonOptions& common, const CheckOptions& options, const CheckedCamera& checked,
              const std::function<hal::Result<control::ResolvedConfig>()>& config) {
  if (options.graph) return show_rules(common.json);
  const auto setup = load_setup(config());
  if (!setup) return report_error("check", setup.error());
  show_warnings("check", common, *setup);

  const std::string yaml = control::yaml_of(*setup, options.explain);
  // what the robot file's camera lacks changes nothing about the configuration
  if (!common.json && !common.quiet) std::fputs(yaml.c_str(), stdout);
  const auto camera = look_at_camera(*setup, checked);
  if (!camera) return report_error("check", camera.error());
  const bool ground_off = camera->ground && !camera->ground->good;
  if (common.json) {
    nlohmann::ordered_json j = {{"schema", "colift.check/1"},
                                {"ok", !ground_off},
                                {"for", options.command},
                                {"hand", setup->hand.name}};
    j["changed"] = nlohmann::ordered_json::object();
    for (const auto& [path, origin] : setup->origins) j["changed"][path] = origin;
    j["warnings"] = setup->warnings;
    j["calibration"] = json_of(*camera);
    j["config"] = yaml;
    std::puts(j.dump().c_str());
    return ground_off ? kNoGoal : kDone;
  }
  std::fflush(stdout);
  fmt::print(stderr, "colift {} can use this configuration; hand: {}\n", options.command, setup->hand.name);
  say(*camera);
  return ground_off ? kNoGoal : kDone;
}

}  // namespace colift::tools
