#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// What commands to the arm must be (I1, I2), that nothing moves after a stop, nor long after the last push
/// of an arm that gives way (I5), and that a push stops the arm (I10).
class MotionRules {
 public:
  /// What the program says that the arm does.
  enum class Said { Works, Yields, Stopped };

  /// `exact_time`: commands come when the robot's clock says, so that their steps can be judged (I2, I10).
  MotionRules(const hal::RobotModel& model, bool exact_time);

  /// `commanded_j`: CommandedEnergy::sum_j(), this millisecond in it.
  void tick(const TickReport& report, Said said, double commanded_j, std::vector<std::string>& breaches);
  [[nodiscard]] std::optional<double> stop_latency_s() const { return latency_s_; }

 private:
  void command(const TickReport& report, std::vector<std::string>& breaches);
  void standstill(const TickReport& report, bool stopped, std::vector<std::string>& breaches);
  void drift(const TickReport& report, Said said, std::vector<std::string>& breaches);
  void push(const TickReport& report, double commanded_j, std::vector<std::string>& breaches);
  void breach(const char* rule, std::string what, std::vector<std::string>& breaches);

  hal::JointVector lower_, upper_, velocity_;
  bool exact_time_;
  std::vector<std::string> broken_;    // each rule is reported once
  std::optional<double> commanded_s_;  // when the last command came
  double since_s_ = 0.0;               // between the last two
  std::optional<double> cycle_s_;      // between two that came regularly
  hal::JointVector command_rad_ = hal::JointVector::Zero(), command_rad_s_ = hal::JointVector::Zero();
  std::optional<double> stopped_s_;
  std::optional<hal::JointVector> rests_at_;
  double touched_s_ = 0.0;          // since a stop: last pushed by somebody
  double moved_s_ = 0.0;            // last moved by work, a touch or what it holds
  std::optional<double> pushed_s_;  // a push that has to stop the arm, and its speed then
  double pushed_rad_s_ = 0.0, pushed_j_ = 0.0;
  std::optional<double> late_j_;  // when it should stand
  bool brakes_ = false;
  std::optional<double> latency_s_;
};

}  // namespace colift::sim_hal
