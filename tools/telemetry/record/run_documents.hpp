#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "control/config/config.hpp"
#include "control/task/job_status.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/record/recorder.hpp"

namespace colift::telemetry {

/// What a run was, as it stands in a recording beside its messages: enough to run it once more.
struct RunDescription {
  std::string version;          ///< Of the program.
  std::string command;          ///< The whole command line.
  std::string started;          ///< Date and time, UTC; for people.
  std::string config_yaml;      ///< The effective configuration.
  bool config_complete = true;  ///< It holds what either method used (control::RecordedConfig).
  std::string robot_urdf;       ///< Empty: the built-in robot.
  std::string hand_yaml;        ///< Empty: the built-in hand.
  std::string scenario_yaml;    ///< Empty on a real rig.
  std::string robot_file;       ///< Which devices; empty: the simulated rig.
  hal::Pose X_WC = hal::Pose::Identity();
  std::vector<hal::Pose> X_WC_more = {};
  control::Method method = control::Method::Fast;
  std::uint64_t seed = 0;
  bool dry_run = false;
  control::Drive drive = control::Drive::InStep;
};

/// Attachments config.yaml, calibration.json, robot.urdf, hand.yaml, scenario.yaml, robot.yaml, and the
/// metadata "colift.run".
[[nodiscard]] RunDocuments documents_of(const RunDescription& run);
/// Errors: BadInput (not a recording of a run, or its documents are damaged).
[[nodiscard]] hal::Result<RunDescription> description_of(const McapReader& file, const std::string& name);

}  // namespace colift::telemetry
