#pragma once

#include <span>
#include <string>
#include <vector>

#include "hal/robot_model/dynamics.hpp"
#include "hal/types/result.hpp"

namespace colift::hal {

/// The arm at rest in one pose.
struct LoadSample {
  JointVector q_rad = JointVector::Zero();
  JointVector tau_external_nm = JointVector::Zero();  ///< On the arm, as its controller estimates it.
};

/// A rigid body fixed to the flange F.
struct FlangeLoad {
  double mass_kg = 0.0;
  Vec3 moment_kgm = Vec3::Zero();  ///< Mass times centre of mass, in F.
};

/// By how much the load differs from the load data that the controller has. Standard deviations count the
/// residual, and no less than kLoadNoise_nm.
struct LoadError {
  FlangeLoad more;  ///< Of the real load.
  FlangeLoad sigma;
  double residual_nm = 0.0;  ///< What no load explains: max over the joints of the mean ...
  int residual_joint = 0;    ///< ... and the joint, from 0.

  /// More than three standard deviations, and more than 0.1 kg or 0.02 kg m.
  [[nodiscard]] bool wrong() const;
  /// kUnexplained_nm or more is explained by no load: a contact, or a torque sensor's offset.
  [[nodiscard]] bool unexplained() const;
};

inline constexpr double kLoadNoise_nm = 0.1;  ///< Of an estimate at rest, assumed at least.
inline constexpr double kUnexplained_nm = 1.0;

/// Linear least squares: a controller's estimate of external torque is its residual against its own load
/// data, so what gravity does to the difference is all that shows in free space. Errors: NotReady, "not
/// observable" (too few poses, or too much alike: one direction of mass and moment is uncertain by more than
/// 0.3 kg or 0.03 kg m even with sensors at kLoadNoise_nm).
[[nodiscard]] Result<LoadError> estimate_load_error(const ArmDynamics& dynamics,
                                                    std::span<const LoadSample> samples);

/// Poses in which the load pulls from other sides: A4 to A7 by 15 deg this way or that, all else stays. Near
/// a limit the middle lies up to 15 deg away from it. `margin_rad` to the limits is kept. Errors: BadInput (a
/// joint stands too near its limit).
inline constexpr int kLoadPoses = 10;
[[nodiscard]] Result<std::vector<JointVector>> load_poses(const RobotModel& model, double margin_rad,
                                                          const JointVector& q_rad);

/// What the hand of the model weighs in its open posture, as the controller's load data should have it.
[[nodiscard]] FlangeLoad hand_load(const RobotModel& model);

/// Sentences: what was found, and what to do about it.
[[nodiscard]] std::string describe(const LoadError& error, const FlangeLoad& expected);

}  // namespace colift::hal
