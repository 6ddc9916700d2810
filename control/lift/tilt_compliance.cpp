#include "control/lift/tilt_compliance.hpp"

#include <algorithm>

#include "hal/types/units.hpp"

namespace colift::control {

void TiltCompliance::start(const HandLine& line) {
  line_ = line;
  across_W_ = hal::Vec3::UnitZ().cross(line.along_W);
  turned_rad_ = 0.0;
}

void TiltCompliance::update(double dt_s, const hal::Wrench& wrench_W, const hal::Pose& X_WH) {
  const hal::Vec3 from_pivot_W = X_WH.translation() - X_WH * line_.pivot_H;
  const hal::Vec3 moment_W = wrench_W.torque + from_pivot_W.cross(wrench_W.force);
  const double max_rad = hal::deg_to_rad(config_.max_deg);
  turned_rad_ =
      std::clamp(turned_rad_ + dt_s * config_.speed_rad_s_nm * moment_W.dot(across_W_), -max_rad, max_rad);
}

hal::Pose TiltCompliance::motion(const hal::Vec3& pivot_W) const {
  hal::Pose motion = hal::Pose::Identity();
  motion.linear() = Eigen::AngleAxisd(turned_rad_, across_W_).toRotationMatrix();
  motion.translation() = pivot_W - motion.linear() * pivot_W;
  return motion;
}

}  // namespace colift::control
