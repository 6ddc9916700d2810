#pragma once

#include <optional>
#include <string>

#include "control/task/grasp_selector.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Observe: averages frames of the scene until ground, target and grasp candidates are known.
class ScenePhase {
 public:
  ScenePhase(TaskContext& context, GraspSelector& grasps) : c_(context), grasps_(grasps) {}

  [[nodiscard]] std::optional<TaskEvent> observe();

  /// The scene that the session analysed last becomes the job's: collision world, candidates, record.
  void use_scene();

 private:
  /// Another picture may be better, for a while: forgets this one. False when time is over.
  [[nodiscard]] bool try_again(const std::string& error);

  /// Puts what the session found about the camera's calibration into the record.
  void note_correction();
  void note_views();

  TaskContext& c_;
  GraspSelector& grasps_;
  std::string last_error_;  ///< Why the last picture of the scene was not good enough.
};

}  // namespace colift::control
