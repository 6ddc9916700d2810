#pragma once

#include <optional>

#include "control/task/grasp_selector.hpp"
#include "control/task/let_go_monitor.hpp"
#include "control/task/object_monitor.hpp"
#include "control/task/task_context.hpp"

namespace colift::control {

/// TestLift: raises the object slowly by some millimetres, to measure mass and centre of gravity, and says
/// what follows from it.
class TestLiftPhase {
 public:
  enum class Leg { Raising, Measuring };

  TestLiftPhase(TaskContext& context, ObjectMonitor& object, LetGoMonitor& partner, GraspSelector& grasps)
      : c_(context), object_(object), partner_(partner), grasps_(grasps) {}

  void begin();
  [[nodiscard]] std::optional<TaskEvent> test_lift();

  [[nodiscard]] Leg leg() const { return leg_; }

 private:
  [[nodiscard]] double height_m() const;
  void raise();
  [[nodiscard]] std::optional<TaskEvent> measure();
  [[nodiscard]] TaskEvent judge();

  TaskContext& c_;
  ObjectMonitor& object_;
  LetGoMonitor& partner_;
  GraspSelector& grasps_;
  Leg leg_ = Leg::Raising;
  hal::Timestamp at_top_since_{0};
};

}  // namespace colift::control
