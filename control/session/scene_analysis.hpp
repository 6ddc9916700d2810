#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "control/config/method.hpp"
#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/target/objections.hpp"
#include "planner/grasp/grasp_candidates.hpp"

namespace colift::control {

/// Time that each stage took, in the order of the data (ms).
struct StageTimes {
  double ground = 0.0, target = 0.0, surfaces = 0.0, candidates = 0.0, total = 0.0;
};

/// A frame and what is known about the camera that took it.
struct SceneAnalysisInput {
  hal::DepthFrame frame;
  hal::Pose X_WC = hal::Pose::Identity();
  bool base_frame_known = false;  ///< W is the robot base, its z axis up.
  std::optional<hal::Vec3> at_W;  ///< Picks the object there instead of the largest.
};

/// What one look at a frame found.
struct SceneAnalysis {
  Method method = Method::Fast;
  bool base_frame_known = false;
  hal::DepthFrame frame;
  perception::OrganisedCloud cloud;
  perception::Scene scene;
  std::vector<perception::RejectedObject> rejected;  ///< Fast method only.
  std::vector<planner::GraspCandidate> candidates;
  bool own_candidates = false;  ///< Of the caller: none are added around the closed-form optimum.
  std::shared_ptr<const planner::CandidateFinder>
      finder;  ///< Judges further candidates; null without a target.
  StageTimes ms;

  /// The one sentence that says what there is to say: the candidates, or why there is no target.
  std::string reason;
};

/// Frame in, scene and grasp candidates out. No ground or no target is a finding, not an error.
/// `config` holds what goes with the method (set_method_defaults()).
/// Errors: BadConfig when the thesis method was asked for in a build without it. `clock` times the stages.
/// `hand_tables` are HandCollision(hand, config.candidates.collision), made once for many looks; null makes
/// them anew.
[[nodiscard]] hal::Result<SceneAnalysis> analyse_scene(
    SceneAnalysisInput input, Method method, const Config& config, const planner::HandModel& hand,
    const hal::Clock& clock, const std::shared_ptr<const planner::HandCollision>& hand_tables = nullptr);

/// Puts a caller's candidates in place of those of the analysis, numbered from 0 and each judged for
/// collision and stability; those that are no grasps (not finite, lengths out of range, axes not unit or not
/// perpendicular) are Unreachable. Reach is judged by whoever knows the arm. Needs a target.
void use_candidates(SceneAnalysis& analysis, std::vector<planner::GraspCandidate> candidates);

}  // namespace colift::control
