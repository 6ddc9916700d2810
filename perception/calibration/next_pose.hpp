#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "perception/calibration/calibrate.hpp"

namespace colift::perception {

/// Where calibration poses may be, and when the camera sees the emitter in them.
struct PoseConfig {
  double margin_deg = 8.0;
  double view_angle_deg = 50.0;
  double roll_deg = 60.0;
  double lowest_m = 0.20;
  double border_px = 40.0;
  double nearest_m = 0.8;
  double farthest_m = 3.0;
  int candidates = 600;
  int next_candidates = 300;
  int max_draws_per_candidate = 4000;
  int postures_per_place = 40;

  template <class Visitor>
  void visit(Visitor& v) {
    v("margin_deg", margin_deg, hal::Range{0, 40}, "Min distance from the joint limits (deg).");
    v("view_angle_deg", view_angle_deg, hal::Range{5, 85},
      "Max angle between the palm's direction and the line to the camera, within which the emitter shines "
      "(deg).");
    v("roll_deg", roll_deg, hal::Range{0, 180},
      "Max turn of the palm about its direction, from upright as the camera sees it (deg).");
    v("lowest_m", lowest_m, hal::Range{0, 2}, "Min height of elbow, wrist and palm above the floor (m).");
    v("border_px", border_px, hal::Range{0, 200}, "Min distance of the spot from the image's border (px).");
    v("nearest_m", nearest_m, hal::Range{0.3, 5}, "Min distance from the camera (m).");
    v("farthest_m", farthest_m, hal::Range{0.5, 8}, "Max distance from the camera (m).");
    v("candidates", candidates, hal::Range{50, 20000},
      "Number of random postures among which poses are chosen.");
    v("max_draws_per_candidate", max_draws_per_candidate, hal::Range{1, 1e6},
      "Max number of draws per candidate, for a camera that sees little of the workspace.");
    v("postures_per_place", postures_per_place, hal::Range{1, 10000},
      "Number of directions of the palm that are tried for each place of the wrist.");
  }
};

/// A posture of the arm in which the camera should see the emitter.
struct ProposedPose {
  hal::JointVector q_rad = hal::JointVector::Zero();
  Pose X_BH = Pose::Identity();
  double error_m = 0.0;  ///< Predicted error over the workspace, with this pose and those before it.
};

/// A rough camera, where nothing better is known: it stands at `eye_B` and looks at `at_B`, level.
[[nodiscard]] EmitterModel rough_camera(const Vec3& eye_B, const Vec3& at_B,
                                        const hal::CameraIntrinsics& camera, const Vec3& emitter_H);

/// Random postures that are within limits, above the floor and in view, the palm in the workspace and turned
/// to the camera; as many as can be found, at most config.candidates. Same seed: same bits.
[[nodiscard]] std::vector<ProposedPose> candidate_poses(const hal::RobotModel& robot,
                                                        const EmitterModel& camera,
                                                        const CalibrationConfig& calibration,
                                                        const PoseConfig& config, std::uint64_t seed);

/// The next best ones, one after the other: each time the candidate that lowers the predicted error over the
/// workspace most, given `done` and those chosen before (greedy; ties go to the first). `usable` may refuse a
/// candidate, for a collision; it is asked only for one that would be chosen.
[[nodiscard]] std::vector<ProposedPose> choose_poses(
    std::span<const ProposedPose> candidates, std::span<const Pose> done, const EmitterModel& model,
    const CalibrationConfig& config, std::size_t count,
    const std::function<bool(const ProposedPose&)>& usable = {});

}  // namespace colift::perception
