#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "hal/depth_camera.hpp"
#include "hal/drivers/kinect/kinect_config.hpp"
#include "perception/calibration/calibration_file.hpp"

namespace colift::tools {

/// What a calibration says of itself, held against what a camera beside a robot can be.
struct CalibrationCheck {
  std::string summary;                ///< One sentence: date, residual, error, place.
  std::optional<double> age_days;     ///< Unset: the file has no date that can be read.
  double height_m = 0.0;              ///< Of the camera above the robot's floor.
  double down_deg = 0.0;              ///< How far it looks down.
  std::vector<std::string> warnings;  ///< Usable, but look at it.
  std::optional<std::string> reason;  ///< Why it cannot be used.
};

/// Without any device: pose above the ground, workspace in view, intrinsics as the driver's, age. `now_s`:
/// seconds since 1970 (UTC).
[[nodiscard]] CalibrationCheck check_calibration(const perception::CalibrationFile& file,
                                                 const perception::CalibrationConfig& limits,
                                                 const hal::KinectConfig& kinect, std::int64_t now_s);

/// Where the ground is in a depth image taken with this calibration.
struct GroundCheck {
  bool good = false;
  std::string reason;                        ///< One sentence with numbers, either way.
  std::optional<double> tilt_deg, height_m;  ///< Of the ground, against level and against the robot's floor.
};
[[nodiscard]] GroundCheck check_ground(const hal::DepthFrame& frame, const hal::Pose& X_BC,
                                       const control::Config& config);

/// "2026-05-01T12:00:00Z" as seconds since 1970; unset where it is none.
[[nodiscard]] std::optional<std::int64_t> seconds_of_date(const std::string& date);

}  // namespace colift::tools
