#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "hal/infrared_camera.hpp"
#include "perception/calibration/calibrate.hpp"
#include "perception/calibration/next_pose.hpp"
#include "perception/calibration/sample_folder.hpp"
#include "tools/cli/options.hpp"
#include "tools/rig/back_ends.hpp"

namespace colift::tools {

struct CalibrateOptions {
  std::optional<std::filesystem::path> samples;   ///< A folder of recorded samples, or:
  bool sim = false;                               ///< the simulated rig, or:
  std::optional<std::filesystem::path> robot;     ///< the robot.
  std::optional<std::filesystem::path> scenario;  ///< Of the simulated rig; unset: a cleared floor.
  int poses = 20;
  std::uint64_t seed = 1;
  std::string camera_at;  ///< "X,Y,Z": where the camera about stands, for the choice of poses.
  std::string date;       ///< Empty: now.
  std::optional<std::filesystem::path> out, png, save;
};

/// Camera-to-arm calibration. 0 calibrated (and written), 1 refused with the reason, 2 bad request or file, 3
/// a device failed, 130 interrupted.
[[nodiscard]] int cmd_calibrate(const CommonOptions& common, const CalibrateOptions& options);

/// Samples taken with arm and camera, one pose after the other.
struct LiveSetting {
  int poses = 20;
  std::uint64_t seed = 1;
  hal::Vec3 camera_at_B = hal::Vec3::Zero();
  std::string date;
  std::optional<std::filesystem::path> save;
  std::function<void(const std::string&)> say;  ///< A line for people.
};
/// The space around the arm has to be clear: nothing is known of it but the floor. Stops at any contact.
/// Errors: those of the devices; NotFound where the arm met something, no pose is in view, or hardly any
/// image shows the emitter.
[[nodiscard]] hal::Result<perception::SampleSet> take_samples(Rig& rig, hal::InfraredCamera& infrared,
                                                              const planner::HandModel& hand,
                                                              const control::Config& config,
                                                              const LiveSetting& setting);

/// What the picture and the documents show.
struct CalibrationView {
  const perception::SampleSet* set = nullptr;
  const perception::Calibration* solved = nullptr;  ///< Null where nothing could be solved.
  std::string refused_kind, reason;                 ///< Kind empty: accepted.
  std::optional<perception::ProposedPose> next;
  std::optional<double> true_error_m;  ///< In simulation.
  std::string method, date;
};
/// One JSON document, schema colift.calibrate/1.
[[nodiscard]] std::string calibration_document(const CalibrationView& view);
/// The same for people.
[[nodiscard]] std::string calibration_text(const CalibrationView& view);
/// Spots with their residuals, twenty times as long, and residuals pose by pose.
[[nodiscard]] hal::Result<> write_calibration_picture(const std::filesystem::path& file,
                                                      const CalibrationView& view);

}  // namespace colift::tools
