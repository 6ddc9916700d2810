#include "tools/check/check_calibration.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <limits>

#include "hal/types/units.hpp"
#include "perception/calibration/spot_finder.hpp"

namespace colift::tools {
namespace {

constexpr double kLowest_m = 0.1, kHighest_m = 4.0;
constexpr double kNear_m = 0.8, kFar_m = 3.5;  // of the workspace's middle: where a Kinect is good
constexpr double kFocalPart = 0.003;  // docs/calibration.md: more costs millimetres that no residual shows
constexpr double kCentre_px = 3.0;
constexpr double kOld_days = 90.0;

std::optional<std::string> wrong_pose(const hal::Pose& X_BC, const hal::Vec3& workspace_B) {
  const double z = X_BC.translation().z();
  if (z < kLowest_m || z > kHighest_m)
    return fmt::format("the camera would be {:.2f} m above the robot's floor; expected {} to {} m", z,
                       kLowest_m, kHighest_m);
  const hal::Vec3 p = X_BC.inverse() * workspace_B;
  const hal::CameraIntrinsics k;
  const bool inside = p.z() > 0.0 && std::abs(k.fx * p.x() / p.z()) < 0.5 * k.width &&
                      std::abs(k.fy * p.y() / p.z()) < 0.5 * k.height;
  if (!inside)
    return fmt::format(
        "the camera would look past the workspace: its middle ({:.2f}, {:.2f}, {:.2f}) is {:.0f} deg "
        "off the image's",
        workspace_B.x(), workspace_B.y(), workspace_B.z(),
        hal::rad_to_deg(std::acos(std::clamp(p.z() / std::max(p.norm(), 1e-9), -1.0, 1.0))));
  return std::nullopt;
}

}  // namespace

std::optional<std::int64_t> seconds_of_date(const std::string& date) {
  std::tm t{};
  int end = 0;
  const int found = std::sscanf(date.c_str(), "%4d-%2d-%2dT%2d:%2d:%2dZ%n", &t.tm_year, &t.tm_mon, &t.tm_mday,
                                &t.tm_hour, &t.tm_min, &t.tm_sec, &end);
  if (found != 6 || end != static_cast<int>(date.size())) return std::nullopt;
  if (t.tm_year < 1970 || t.tm_mon < 1 || t.tm_mon > 12 || t.tm_mday < 1 || t.tm_mday > 31)
    return std::nullopt;
  t.tm_year -= 1900;
  t.tm_mon -= 1;
  return static_cast<std::int64_t>(::timegm(&t));
}

CalibrationCheck check_calibration(const perception::CalibrationFile& file,
                                   const perception::CalibrationConfig& limits,
                                   const hal::KinectConfig& kinect, std::int64_t now_s) {
  CalibrationCheck out;
  const hal::Pose X_BC = file.X_BC();
  const hal::Vec3 at = X_BC.translation(), forward = X_BC.linear().col(2), down = X_BC.linear().col(1);
  out.height_m = at.z();
  out.down_deg = -hal::rad_to_deg(std::asin(std::clamp(forward.z(), -1.0, 1.0)));
  std::string age = "of an unknown day";
  if (const auto then = seconds_of_date(file.date)) {
    out.age_days = static_cast<double>(now_s - *then) / 86400.0;
    age = *out.age_days < 1.0 ? fmt::format("of today ({})", file.date)
                              : fmt::format("{:.0f} days old ({})", std::floor(*out.age_days), file.date);
    if (*out.age_days < -1.0) out.warnings.push_back(fmt::format("it is from the future ({})", file.date));
    if (*out.age_days > kOld_days)
      out.warnings.push_back(
          fmt::format("it is {:.0f} days old: has the camera been moved since?", *out.age_days));
  }
  out.summary = fmt::format(
      "{}; residual {:.2f} px by {} poses, points {:.1f} mm off in the mean; camera at ({:.2f}, {:.2f}, "
      "{:.2f}) m, "
      "looks {:.0f} deg down",
      age, file.rms_px, file.inliers, 1e3 * file.error_m, at.x(), at.y(), at.z(), out.down_deg);

  out.reason = wrong_pose(X_BC, limits.workspace_center_m);
  if (out.reason) return out;
  const double away = (at - limits.workspace_center_m).norm();
  if (away < kNear_m || away > kFar_m)
    out.warnings.push_back(
        fmt::format("the camera is {:.1f} m from the workspace's middle; a Kinect sees well from "
                    "{} to {} m",
                    away, kNear_m, kFar_m));
  if (down.z() > 0.0) out.warnings.emplace_back("the camera hangs upside down");
  const double focal = std::max(std::abs(kinect.fx / file.fx - 1.0), std::abs(kinect.fy / file.fy - 1.0));
  if (focal > kFocalPart)
    out.warnings.push_back(
        fmt::format("it was made with focal lengths {:.1f}, {:.1f} px, and the driver has {:.1f}, {:.1f}: "
                    "{:.0f} mm off, {:.1f} m "
                    "away; kinect: {{fx: {:.1f}, fy: {:.1f}}}",
                    file.fx, file.fy, kinect.fx, kinect.fy, 1e3 * focal * away, away, file.fx, file.fy));
  const double cx = file.cx - hal::kInfraredColumns, cy = file.cy - hal::kInfraredRows;
  if (std::hypot(kinect.cx - cx, kinect.cy - cy) > kCentre_px)
    out.warnings.push_back(fmt::format(
        "it was made with the principal point ({:.1f}, {:.1f}) px of the depth image, and the driver has "
        "({:.1f}, {:.1f})",
        cx, cy, kinect.cx, kinect.cy));
  return out;
}

GroundCheck check_ground(const hal::DepthFrame& frame, const hal::Pose& X_BC, const control::Config& config) {
  GroundCheck out;
  const perception::OrganisedCloud cloud = perception::deproject(frame, X_BC);
  const auto blocks = perception::fit_block_planes(cloud, config.noise, config.ground.blocks);
  auto found = perception::find_ground(cloud, blocks, hal::Vec3::UnitZ(), config.noise, config.ground);
  // tilted by more than a ground may be: say by how much
  if (!found.ground) {
    const auto tilted = perception::find_ground(cloud, blocks, std::nullopt, config.noise, config.ground);
    if (tilted.ground) found = tilted;
  }
  if (!found.ground) {
    out.reason = "no ground is seen: " + found.reason;
    return out;
  }
  // of the arm nothing is known here
  perception::PoseCheckConfig ground_only = config.pose_check;
  ground_only.min_points = std::numeric_limits<int>::max();
  const auto seen = perception::check_pose(frame, X_BC, found.ground->plane, hal::built_in_robot(),
                                           hal::JointVector::Zero(), hal::HandPosture{}, ground_only);
  out.tilt_deg = hal::rad_to_deg(seen.tilt_rad);
  out.height_m = seen.height_m;
  out.good = seen.good;
  out.reason =
      seen.good
          ? fmt::format("the ground is level within {:.1f} deg and {:.0f} mm {} the robot's floor",
                        *out.tilt_deg, 1e3 * std::abs(seen.height_m), seen.height_m < 0.0 ? "below" : "above")
          : seen.reason;
  return out;
}

}  // namespace colift::tools
