#include "tools/telemetry/record/run_documents.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <map>

#include "hal/robot.hpp"
#include "tools/telemetry/channels/json_parts.hpp"

namespace colift::telemetry {
namespace {

constexpr const char* kRun = "colift.run";
constexpr const char* kComplete = "complete";
constexpr std::size_t kMaxMoreCameras = 15;  // more are no recording of ours

Json pose_json(const hal::Pose& X_WC, const std::string& frame) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) rows.push_back(X_WC.matrix()(r, c));
  return {{"frame", frame},
          {"X_WC", std::move(rows)},
          {"position", list_of(X_WC.translation())},
          {"quaternion", quaternion_json(X_WC.linear())}};
}

std::string calibration_json(const hal::Pose& X_WC, const std::vector<hal::Pose>& more) {
  Json j = pose_json(X_WC, hal::camera_name(0));
  j["schema"] = "colift.recorded-calibration/1";
  for (std::size_t n = 0; n < more.size(); ++n)
    j["more_cameras"].push_back(pose_json(more[n], hal::camera_name(n + 1)));
  return dumped(j);
}

std::optional<hal::Pose> read_pose(const Json& j) {
  if (!j.is_object() || !j.contains("X_WC") || !j["X_WC"].is_array() || j["X_WC"].size() != 12)
    return std::nullopt;
  hal::Pose X_WC = hal::Pose::Identity();
  for (std::size_t i = 0; i < 12; ++i) {
    if (!j["X_WC"][i].is_number()) return std::nullopt;
    X_WC.matrix()(static_cast<int>(i / 4), static_cast<int>(i % 4)) = j["X_WC"][i].get<double>();
  }
  return X_WC;
}

bool read_poses(const std::string& text, RunDescription& run) {
  const Json j = Json::parse(text, nullptr, false);
  const auto first = read_pose(j);
  if (!first) return false;
  run.X_WC = *first;
  if (!j.contains("more_cameras")) return true;
  for (const Json& each : j["more_cameras"]) {
    const auto pose = read_pose(each);
    if (!pose || run.X_WC_more.size() == kMaxMoreCameras) return false;
    run.X_WC_more.push_back(*pose);
  }
  return true;
}

}  // namespace

RunDocuments documents_of(const RunDescription& run) {
  RunDocuments out;
  const auto attach = [&](const char* name, const char* type, const std::string& data) {
    if (!data.empty()) out.attachments.push_back({0, 0, name, type, data});
  };
  attach("config.yaml", "application/yaml", run.config_yaml);
  attach("calibration.json", "application/json", calibration_json(run.X_WC, run.X_WC_more));
  attach("robot.urdf", "application/xml", run.robot_urdf);
  attach("hand.yaml", "application/yaml", run.hand_yaml);
  attach("scenario.yaml", "application/yaml", run.scenario_yaml);
  attach("robot.yaml", "application/yaml", run.robot_file);
  out.metadata.push_back({kRun,
                          {{"schema", "colift.recording/1"},
                           {"version", run.version},
                           {"command", run.command},
                           {"started", run.started},
                           {"method", control::to_string(run.method)},
                           {"config", run.config_complete ? kComplete : ""},
                           {"seed", std::to_string(run.seed)},
                           {"dry_run", run.dry_run ? "true" : "false"},
                           {"arm_cycle", run.drive == control::Drive::InStep ? "in-step" : "thread"}}});
  return out;
}

hal::Result<RunDescription> description_of(const McapReader& file, const std::string& name) {
  const auto metadata = file.metadata(kRun);
  if (!metadata)
    return hal::failure(hal::ErrorCode::BadInput, name,
                        "is no recording of a run: it has no metadata colift.run");
  const auto text = [&](const char* key) {
    const auto found = metadata->entries.find(key);
    return found == metadata->entries.end() ? std::string() : found->second;
  };
  if (text("schema") != "colift.recording/1")
    return hal::failure(
        hal::ErrorCode::BadInput, name,
        fmt::format("is of schema \"{}\"; expected colift.recording/1", text("schema").substr(0, 40)));
  RunDescription run;
  run.version = text("version");
  run.command = text("command");
  run.started = text("started");
  run.method = control::method_named(text("method")).value_or(control::Method::Fast);
  run.config_complete = text("config") == kComplete;
  run.seed = std::strtoull(text("seed").c_str(), nullptr, 10);
  run.dry_run = text("dry_run") == "true";
  run.drive = text("arm_cycle") == "thread" ? control::Drive::Thread : control::Drive::InStep;
  const auto config = file.attachment("config.yaml");
  if (!config) return tl::unexpected(config.error());
  run.config_yaml = config->data;
  const auto calibration = file.attachment("calibration.json");
  if (!calibration) return tl::unexpected(calibration.error());
  if (!read_poses(calibration->data, run))
    return hal::failure(hal::ErrorCode::BadInput, name, "its calibration.json holds no pose of the camera");
  for (const auto& [document, to] :
       {std::pair{"robot.urdf", &run.robot_urdf}, std::pair{"hand.yaml", &run.hand_yaml},
        std::pair{"scenario.yaml", &run.scenario_yaml}, std::pair{"robot.yaml", &run.robot_file}}) {
    auto found = file.attachment(document);
    if (found)
      *to = std::move(found->data);
    else if (found.error().code != hal::ErrorCode::NotFound)
      return tl::unexpected(found.error());
  }
  return run;
}

}  // namespace colift::telemetry
