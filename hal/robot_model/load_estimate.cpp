#include "hal/robot_model/load_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/types/symmetric.hpp"
#include "hal/types/units.hpp"

namespace colift::hal {
namespace {

constexpr double kArm_m = 0.1;  // length that makes a moment comparable with a mass
constexpr double kTurn_deg = 15.0;
constexpr int kFirstWrist = 3;
constexpr double kMostSigma_kg = 0.3;
constexpr double kWrong_kg = 0.1, kWrong_kgm = 0.02, kWrongSigmas = 3.0;

using Regressor = Eigen::Matrix<double, kArmJoints, 4>;

/// External torque of a unit of mass at F's origin, then of moments along F's axes (each kArm_m times 1 kg).
Regressor regressor(const ArmDynamics& dynamics, const JointVector& q_rad) {
  Regressor A;
  const Eigen::Matrix<double, 1, kArmJoints> lift = dynamics.jacobian(q_rad).row(2);
  A.col(0) = -kGravity_m_s2 * lift.transpose();
  for (int k = 0; k < 3; ++k)
    A.col(k + 1) =
        -kGravity_m_s2 * (dynamics.jacobian(q_rad, kArm_m * Vec3::Unit(k)).row(2) - lift).transpose();
  return A;
}

Vec3 centre_mm(const FlangeLoad& load) {
  return load.mass_kg > 0.0 ? Vec3(1e3 * load.moment_kgm / load.mass_kg) : Vec3(Vec3::Zero());
}

std::string load_text(const FlangeLoad& load) {
  const Vec3 c = centre_mm(load);
  return fmt::format("{:.2f} kg at x {:.0f}, y {:.0f}, z {:.0f} mm from the flange", load.mass_kg, c.x(),
                     c.y(), c.z());
}

}  // namespace

bool LoadError::wrong() const {
  if (std::abs(more.mass_kg) > std::max(kWrong_kg, kWrongSigmas * sigma.mass_kg)) return true;
  for (int k = 0; k < 3; ++k)
    if (std::abs(more.moment_kgm[k]) > std::max(kWrong_kgm, kWrongSigmas * sigma.moment_kgm[k])) return true;
  return false;
}

bool LoadError::unexplained() const {
  return residual_nm >= kUnexplained_nm;
}

Result<LoadError> estimate_load_error(const ArmDynamics& dynamics, std::span<const LoadSample> samples) {
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  for (const LoadSample& s : samples) {
    const Regressor A = regressor(dynamics, s.q_rad);
    normal += A.transpose() * A;
    right += A.transpose() * s.tau_external_nm;
  }
  const double weakest = small_symmetric_eigen(normal).values[0];
  if (!(weakest > 0.0) || kLoadNoise_nm / std::sqrt(weakest) > kMostSigma_kg)
    return failure(ErrorCode::NotReady, "load",
                   fmt::format("not observable from {} poses: they are too few or too much alike (turn the "
                               "wrist further, so that gravity pulls at the load from other sides)",
                               samples.size()));
  const Eigen::Vector4d p = solve_small_symmetric(normal, right);

  LoadError e;
  JointVector mean = JointVector::Zero();
  double squares = 0.0;
  for (const LoadSample& s : samples) {
    const JointVector rest = s.tau_external_nm - regressor(dynamics, s.q_rad) * p;
    mean += rest / static_cast<double>(samples.size());
    squares += rest.squaredNorm();
  }
  const double freedom = std::max(1.0, static_cast<double>(kArmJoints * samples.size()) - 4.0);
  const double noise_nm = std::max(kLoadNoise_nm, std::sqrt(squares / freedom));
  const Eigen::Vector4d sigma = noise_nm * normal.inverse().diagonal().cwiseMax(0.0).cwiseSqrt();
  e.more = {p[0], kArm_m * p.tail<3>()};
  e.sigma = {sigma[0], kArm_m * sigma.tail<3>()};
  Eigen::Index joint = 0;
  e.residual_nm = mean.cwiseAbs().maxCoeff(&joint);
  e.residual_joint = static_cast<int>(joint);
  return e;
}

Result<std::vector<JointVector>> load_poses(const RobotModel& model, double margin_rad,
                                            const JointVector& q_rad) {
  const double turn_rad = deg_to_rad(kTurn_deg), room_rad = margin_rad + turn_rad;
  JointVector middle = q_rad;
  for (int j = kFirstWrist; j < kArmJoints; ++j) {
    middle[j] = std::clamp(q_rad[j], model.lower_rad()[j] + room_rad, model.upper_rad()[j] - room_rad);
    if (std::abs(middle[j] - q_rad[j]) > turn_rad)
      return failure(
          ErrorCode::BadInput, fmt::format("A{}", j + 1),
          fmt::format("it stands at {:.1f} deg, too near its limit to turn by {:.0f} deg both ways: "
                      "move it away first",
                      rad_to_deg(q_rad[j]), kTurn_deg));
  }
  // the bits of a counter: every two of the four joints meet in all four combinations
  std::vector<JointVector> poses(kLoadPoses, middle);
  for (int i = 0; i < kLoadPoses; ++i)
    for (int j = kFirstWrist; j < kArmJoints; ++j)
      poses[static_cast<std::size_t>(i)][j] += ((i + 1) >> (j - kFirstWrist) & 1) != 0 ? turn_rad : -turn_rad;
  return poses;
}

FlangeLoad hand_load(const RobotModel& model) {
  FlangeLoad load;
  std::vector<Pose> X_WL;
  const JointVector q = JointVector::Zero();
  link_poses(model, q, {}, X_WL);
  const Pose X_FW = X_WL[static_cast<std::size_t>(model.flange)].inverse();
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    if (!model.in_hand(static_cast<int>(i))) continue;
    const RobotLink& link = model.links[i];
    load.mass_kg += link.mass_kg;
    load.moment_kgm += link.mass_kg * (X_FW * (X_WL[i] * link.com_m));
  }
  return load;
}

std::string describe(const LoadError& e, const FlangeLoad& expected) {
  const FlangeLoad found{expected.mass_kg + e.more.mass_kg, expected.moment_kgm + e.more.moment_kgm};
  std::string t = fmt::format(
      "the load is {:+.2f} kg (standard deviation {:.2f}) and {:+.3f}, {:+.3f}, {:+.3f} kg m (x, y, z of the "
      "flange; standard deviation {:.3f}, {:.3f}, {:.3f}) from the KRC's load data\n",
      e.more.mass_kg, e.sigma.mass_kg, e.more.moment_kgm.x(), e.more.moment_kgm.y(), e.more.moment_kgm.z(),
      e.sigma.moment_kgm.x(), e.sigma.moment_kgm.y(), e.sigma.moment_kgm.z());
  if (e.unexplained())
    t += fmt::format(
        "no load explains {:.1f} N m at A{}: the arm touches something, a cable pulls, or this torque sensor "
        "has an offset; free the arm, or adjust the sensor at the panel, and measure again before the "
        "figures are used\n",
        e.residual_nm, e.residual_joint + 1);
  if (!e.wrong())
    return t + (e.unexplained() ? "" : "the KRC's load data agree with what hangs on the flange\n");
  return t +
         fmt::format(
             "the KRC's load data are wrong: in an impedance mode the arm sinks or rises by them. If the KRC "
             "has the hand of the model ({}), enter {} as load data of the tool that the KRL program "
             "selects (tool_no in colift.src), start that program anew, and measure again\n",
             load_text(expected), load_text(found));
}

}  // namespace colift::hal
