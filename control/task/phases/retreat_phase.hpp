#pragma once

#include <optional>
#include <string>

#include "control/task/grasp_selector.hpp"
#include "control/task/lift_evidence.hpp"
#include "control/task/object_monitor.hpp"
#include "control/task/phases/scene_phase.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// Release and Retreat: opens the hand, goes straight away from the object, then home; there it says whether
/// the job is done, tries again or ends.
class RetreatPhase {
 public:
  enum class Leg { FromObject, Home };
  enum class Opening { Unloading, Announced, Opening };

  RetreatPhase(TaskContext& context, ObjectMonitor& object, GraspSelector& grasps, ScenePhase& scene,
               const LiftEvidence& evidence)
      : c_(context), object_(object), grasps_(grasps), scene_(scene), evidence_(evidence) {}

  /// The arm is at home now, at the start of the job.
  void set_home(const hal::JointVector& q_rad) { home_rad_ = q_rad; }

  void begin_release();
  [[nodiscard]] std::optional<TaskEvent> release();
  /// From the grasp, or, after a contact, from where that stopped the hand.
  void begin_retreat(bool after_contact);
  /// The hand is still at the object, and has not met it too often on this way back.
  [[nodiscard]] bool may_touch() const;
  [[nodiscard]] std::optional<TaskEvent> retreat();
  /// The arm's cycle was cut off and began anew: continues along the path.
  void resume_after_restart() { c_.arm.resume(); }

  [[nodiscard]] Leg leg() const { return leg_; }

 private:
  /// The object is supported: nothing hangs in the hand, and nothing pulls at it.
  [[nodiscard]] bool is_supported() const;
  /// Begins a part of the release, with times of its own.
  void proceed(Opening to);
  void start_unloading();
  [[nodiscard]] std::optional<TaskEvent> unload();
  /// Opens the hand once that was announced and nothing hangs in it.
  [[nodiscard]] std::optional<TaskEvent> open_when_announced();
  void open();
  [[nodiscard]] TaskEvent still_loaded() const;
  [[nodiscard]] bool start_home();
  [[nodiscard]] TaskEvent judge_at_home();
  /// The object was put down elsewhere: scene, candidates and test lifts become those of where it stands now.
  /// Empty, or why that cannot be.
  [[nodiscard]] std::string take_scene_as_moved();

  TaskContext& c_;
  ObjectMonitor& object_;
  GraspSelector& grasps_;
  ScenePhase& scene_;
  const LiftEvidence& evidence_;
  Opening opening_ = Opening::Unloading;
  hal::Timestamp unsupported_at_{0};
  int unloadings_ = 0;  ///< Of this release.
  int contacts_ = 0;    ///< Of this way back.
  hal::JointVector home_rad_ = hal::JointVector::Zero();
  Leg leg_ = Leg::FromObject;
};

}  // namespace colift::control
