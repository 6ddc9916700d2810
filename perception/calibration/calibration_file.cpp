#include "perception/calibration/calibration_file.hpp"

#include <fmt/format.h>

#include <cmath>

#include "hal/config/config_file.hpp"
#include "perception/calibration/yaml_places.hpp"

namespace colift::perception {
namespace {

constexpr std::size_t kCovariance = kPoseParameters * kPoseParameters;

hal::Result<> check(const CalibrationFile& f, const std::string& yaml, const std::string& name,
                    const CalibrationConfig& limits) {
  const auto refuse = [&](const char* key, std::string detail) {
    return hal::failure(hal::ErrorCode::BadConfig, place_of(yaml, name, key), std::move(detail));
  };
  const auto& q = f.camera_quaternion;
  if (q.size() != 4)
    return refuse("camera_quaternion",
                  fmt::format("found {} numbers; expected the 4 of x, y, z, w", q.size()));
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(norm - 1.0) < 0.01))
    return refuse("camera_quaternion", fmt::format("its length is {:.4f}; expected 1", norm));
  if (!f.covariance.empty() && f.covariance.size() != kCovariance)
    return refuse("covariance", fmt::format("found {} numbers; expected {} x {} or none", f.covariance.size(),
                                            kPoseParameters, kPoseParameters));
  if (f.error_m > limits.max_error_m)
    return refuse("error_m", fmt::format("points are placed {:.1f} mm off; at most {:.1f} is good enough",
                                         1e3 * f.error_m, 1e3 * limits.max_error_m));
  if (f.rms_px > limits.max_rms_px)
    return refuse("rms_px",
                  fmt::format("found {:.2f} px; at most {:.2f} is good enough", f.rms_px, limits.max_rms_px));
  if (f.inliers < limits.min_inliers)
    return refuse("inliers",
                  fmt::format("found {} poses that agree; {} are needed", f.inliers, limits.min_inliers));
  return {};
}

}  // namespace

Pose CalibrationFile::X_BC() const {
  const auto& q = camera_quaternion;
  Pose X = Pose::Identity();
  X.linear() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).normalized().toRotationMatrix();
  X.translation() = camera_xyz_m;
  return X;
}

CalibrationFile file_of(const Calibration& c, const std::string& date, const std::string& method) {
  CalibrationFile f;
  f.date = date;
  f.method = method;
  const Pose X = c.model.X_BC();
  f.camera_xyz_m = X.translation();
  const Eigen::Quaterniond q(X.linear());
  f.camera_quaternion = {q.x(), q.y(), q.z(), q.w()};
  f.emitter_m = c.model.p_H;
  f.fx = c.model.camera.fx, f.fy = c.model.camera.fy, f.cx = c.model.camera.cx, f.cy = c.model.camera.cy;
  f.depth_scale = c.model.depth_scale;
  f.depth_offset_m = c.model.depth_offset_m;
  f.error_m = c.error_m;
  f.worst_error_m = c.worst_error_m;
  f.rms_px = c.rms_px;
  f.held_out_px = c.held_out_px;
  f.inliers = c.inliers;
  f.diversity = c.diversity.score;
  for (int row = 0; row < kPoseParameters; ++row)
    for (int column = 0; column < kPoseParameters; ++column)
      f.covariance.push_back(c.covariance(row, column));
  for (const SampleVerdict& v : c.samples) {
    // a point behind the camera has no place in the image; a file holds finite numbers
    constexpr double kFar_px = 1e6;
    const bool seen = v.residual_px.allFinite();
    f.poses.push_back({seen ? v.residual_px.x() : kFar_px, seen ? v.residual_px.y() : kFar_px, v.inlier,
                       std::isfinite(v.held_out_px) ? v.held_out_px : kFar_px});
  }
  return f;
}

std::string text_of(const CalibrationFile& file) {
  CalibrationFile copy = file;
  hal::FieldTable table = hal::table_of(copy);
  // where each value comes from is nobody's question here
  std::string yaml = hal::effective_yaml(table, false);
  const std::string origin = "  # " + std::string(hal::kDefaultOrigin);
  for (std::size_t at = yaml.find(origin); at != std::string::npos; at = yaml.find(origin, at))
    yaml.erase(at, origin.size());
  return yaml;
}

hal::Result<CalibrationFile> parse_calibration(const std::string& yaml, const std::string& name,
                                               const CalibrationConfig& limits) {
  CalibrationFile file;
  hal::FieldTable table = hal::table_of(file);
  if (auto done = hal::apply_yaml_text(table, yaml, name); !done) return tl::unexpected(done.error());
  if (auto done = hal::check_fields(table, name); !done) return tl::unexpected(done.error());
  if (auto done = check(file, yaml, name, limits); !done) return tl::unexpected(done.error());
  return file;
}

hal::Result<CalibrationFile> load_calibration(const std::filesystem::path& file,
                                              const CalibrationConfig& limits) {
  const auto text = hal::read_yaml_file(file);
  if (!text) return tl::unexpected(text.error());
  return parse_calibration(*text, file.string(), limits);
}

}  // namespace colift::perception
