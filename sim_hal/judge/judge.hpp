#pragma once

#include <memory>
#include <string_view>

#include "hal/robot_model/robot_model.hpp"
#include "sim_hal/judge/verdict.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// Watches a simulated world millisecond by millisecond and says what was done to people and which invariant
/// was broken. It knows the truth and the commands that reach the arm, and nothing of the program that sends
/// them. Any thread.
///
///   auto judge = std::make_shared<Judge>(model, /*exact_time=*/true);
///   world.observe([judge](const TickReport& r) { judge->tick(r); });
class Judge {
 public:
  /// `exact_time`: the world is moved in step with its client; in real time steps of commands are not judged.
  Judge(const hal::RobotModel& model, bool exact_time);
  ~Judge();

  void tick(const TickReport& report);
  /// The program says what it is doing; "stopped": it reacted, and waits for a person.
  void task_state(std::string_view name);
  /// `lifted`: the program says so at its end.
  [[nodiscard]] Verdict verdict(bool lifted) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::sim_hal
