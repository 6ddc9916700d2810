#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/joints.hpp"
#include "hal/types/result.hpp"

namespace colift::planner {

/// Lengths and limits of a spherical-rotational-spherical arm with the axes of the LWR 4+ (z, -y, z, +y, z,
/// -y, z).
struct ArmGeometry {
  double base_to_shoulder_m = 0.3105;
  double upper_arm_m = 0.40;
  double forearm_m = 0.39;
  double wrist_to_flange_m = 0.078;
  hal::JointVector lower_rad = hal::JointVector::Zero(), upper_rad = hal::JointVector::Zero();
};
/// Errors: BadConfig when the model's arm is no S-R-S arm of this kind.
[[nodiscard]] hal::Result<ArmGeometry> arm_geometry(const hal::RobotModel& model);

/// Pose of the flange F in W.
[[nodiscard]] hal::Pose flange_pose(const ArmGeometry& arm, const hal::JointVector& q_rad);

/// One joint position that brings the flange to a pose.
struct IkSolution {
  hal::JointVector q_rad = hal::JointVector::Zero();
  double elbow_rad = 0.0;  ///< Redundancy angle: of the elbow about the line from shoulder to wrist, 0 = up.
  int branch = 0;          ///< Bit 0: A2 negative, bit 1: A4 negative, bit 2: A6 negative.
};

/// Where the elbow stands in that joint position. With the wrist straight above or below the shoulder, where
/// there is no up, 0 is towards Wx; with a straight arm the angle that the joints turn about the arm's line.
[[nodiscard]] double elbow_angle(const ArmGeometry& arm, const hal::JointVector& q_rad);

/// All joint positions within the limits less `margin_rad` that put the flange there with this elbow angle:
/// up to 8. Returns how many. In singular positions (A2 or A6 zero), where two joints turn about one line,
/// both turn by half. Closed form; real-time safe.
int solve_ik(const ArmGeometry& arm, const hal::Pose& X_WF, double elbow_rad, double margin_rad,
             std::array<IkSolution, 8>& out);

/// The same over elbow angles (-pi, pi] in `steps`, best first by distance to the limits and manipulability
/// (score 0 to 1: nearness of the joint nearest to its limit times sqrt |sin A4 sin A6|). Where no step has a
/// solution, one elbow angle in the middle of each interval that the joint limits leave, in closed form
/// (Shimizu et al., T-RO 2008): empty only when the pose cannot be reached.
struct ScoredIk : IkSolution {
  double score = 0.0;
};
[[nodiscard]] std::vector<ScoredIk> all_ik(const ArmGeometry& arm, const hal::Pose& X_WF, double margin_rad,
                                           int steps = 36);

/// Follows a pose from a near joint position: the solution next to it, elbow angle kept or moved least.
/// nullopt when it leaves the limits or jumps by more than `max_step_rad` in any joint. Real-time safe.
[[nodiscard]] std::optional<hal::JointVector> follow_ik(const ArmGeometry& arm, const hal::Pose& X_WF,
                                                        const hal::JointVector& near_rad, double margin_rad,
                                                        double max_step_rad);

}  // namespace colift::planner
