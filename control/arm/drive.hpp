#pragma once

namespace colift::control {

/// Who runs the arm's cycle.
enum class Drive {
  InStep,  ///< The task itself, once in each of its own cycles: simulation in lock step, bit for bit the
           ///< same.
  Thread,  ///< A thread of its own, which never waits for the task: the robot.
};

}  // namespace colift::control
