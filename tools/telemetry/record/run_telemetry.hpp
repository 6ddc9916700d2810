#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/task/job_status.hpp"
#include "hal/robot.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::telemetry {

/// What only a simulation knows at one moment. Forces on the object, up positive.
struct TruthNow {
  double t_s = 0.0;
  double robot_force_z_n = 0.0, partner_force_z_n = 0.0, floor_force_z_n = 0.0;
  std::optional<double> share;
  double tilt_rad = 0.0, height_m = 0.0, slip_m = 0.0;
};

/// Turns a run into messages: listens to the devices' answers and to the job's hooks, and hands what it hears
/// to sinks. Changes nothing: every call goes through to the device, every hook to its owner. Where the arm
/// has a thread of its own, the arm's cycle only drops its state into a ring.
class RunTelemetry {
 public:
  struct Setting {
    const hal::RobotModel* model = nullptr;  ///< Borrowed.
    hal::Pose X_WC = hal::Pose::Identity();
    std::vector<hal::Pose> X_WC_more = {};
    control::Drive drive = control::Drive::InStep;
    bool asks_devices = true;  ///< For their health; not those of a replay, whose every answer is counted.
    const planner::HandModel* hand = nullptr;  ///< Borrowed; null: the chosen gripper pose is not shown.
    std::string robot_urdf = {};               ///< For /robot_description; empty: it is left out.
  };
  /// `wall` times the arm's answers; borrowed, as the sinks are.
  RunTelemetry(const Setting& setting, std::vector<TelemetrySink*> sinks, const hal::Clock& wall);
  ~RunTelemetry();
  RunTelemetry(const RunTelemetry&) = delete;
  RunTelemetry& operator=(const RunTelemetry&) = delete;

  /// Puts itself between the job and its devices. Before the job runs.
  void tap(hal::Robot& robot);
  /// The job's hooks with its own before them. The last call before the job runs: from here on, whatever the
  /// robot is asked outside of hooks is taken for the job's question.
  [[nodiscard]] control::JobHooks hooks(control::JobHooks yours);
  /// Called with each thing that went wrong: a device's fault, a run that stopped.
  void on_fault(std::function<void(const std::string&)> listener);
  void truth(hal::Timestamp at, const TruthNow& truth);
  /// A line of the log, now.
  void log(int level, const std::string& name, const std::string& text);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::telemetry
