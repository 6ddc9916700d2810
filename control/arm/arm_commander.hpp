#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "control/arm/arm_controller.hpp"
#include "control/arm/drive.hpp"
#include "hal/arm.hpp"

namespace colift::control {

/// The arm as the task sees it: requests go in, a view of the last cycle comes out. With Drive::Thread both
/// go through wait-free slots, and a trajectory that is asked for starts a cycle later; done(), blocked() and
/// the rest always speak of the last request, never of the one before.
class ArmCommander {
 public:
  ArmCommander(hal::Arm& arm, const hal::RobotModel& model, const planner::ArmGeometry& geometry,
               const TaskConfig& task, const LoadConfig& load, Drive drive, const SetpointLimits& limits = {},
               const ForceMonitorConfig& force = {.on = false});
  ~ArmCommander();
  ArmCommander(const ArmCommander&) = delete;
  ArmCommander& operator=(const ArmCommander&) = delete;

  /// Activates the arm, which is configured, and makes its first cycle. A thread of its own gets real-time
  /// priority first. Errors: those of the activation and of the first cycles.
  [[nodiscard]] hal::Result<> start();
  /// Brings the arm to rest, answers some cycles more, deactivates the arm and ends the thread. In bounded
  /// time.
  void finish() noexcept;
  /// What the machine granted to the arm's thread, in sentences; empty with Drive::InStep.
  [[nodiscard]] const std::vector<std::string>& realtime() const { return realtime_; }

  /// Before start(): nothing is commanded, and each cycle's view comes from a recording.
  void play(std::function<void(ArmView&)> views) { recorded_ = std::move(views); }

  /// Begins a cycle of the task: waits for the arm's next cycle (InStep) or for a few milliseconds (Thread).
  void begin_cycle();
  /// Ends it: the arm's command goes out (InStep).
  void end_cycle();

  // Requests.
  void hold();
  /// Errors: NotReady, BadInput (SetpointGenerator::follow).
  [[nodiscard]] hal::Result<> follow(const planner::Trajectory& trajectory);
  /// Goes on along a trajectory that was halted or cut off, or back along it; blocked() tells when the arm
  /// has left it.
  void resume(double speed = 1.0);
  void back(double speed);
  void go_slow(bool on);
  /// At most this fraction of the planned speed from now on, 0 to 1, until something else is asked; at 0 the
  /// arm comes to rest on its path and stays there, with whatever it carries.
  void set_scale(double scale);
  void unload();
  /// Takes the set point to where the palm stands, of an arm that rests with a closed hand that nothing hangs
  /// in.
  void ease();
  void start_tare();
  void end_tare();
  /// Raises the palm by a height, in a time when it leads; raise_on() goes further, to a height over where
  /// the lift began.
  void start_lift(LiftController::Role role, double height_m, double time_s, const HandLine& line = {});
  void raise_on(LiftController::Role role, double height_m, double time_s, const HandLine& line = {});
  /// Continues a lift that the arm stopped because the task was late; the arm has to be at rest.
  void resume_lift();
  /// Ends a slow lift at the height that it has reached; at once, so for slow ones only.
  void stay();
  void lower();
  void see_partner(double rise_m);
  /// Stops a lift where it is; raise_on() or lower() continue it.
  void pause();
  /// Comes to rest and yields to whoever pushes; the load stays compensated.
  void yield();
  /// Which forces are expected from now on.
  void expect(HandLoad load);

  // The last cycle.
  [[nodiscard]] const ArmView& view() const { return view_; }
  [[nodiscard]] bool done() const { return current() && view_.done; }
  [[nodiscard]] bool at_rest() const { return current() && view_.at_rest; }
  [[nodiscard]] bool lift_at_rest() const { return current() && view_.lift_at_rest; }
  [[nodiscard]] bool end_of_reach() const { return current() && view_.end_of_reach; }
  [[nodiscard]] double progress() const { return current() ? view_.progress : 0.0; }
  /// The arm stopped by itself because the task was late, and has not been asked to move since.
  [[nodiscard]] bool stalled() const { return view_.stalled; }
  [[nodiscard]] bool blocked() const;
  /// Blocked by a force or by what holds the arm back, not by a late task or a path that was left.
  [[nodiscard]] bool touched() const;
  [[nodiscard]] std::string why_blocked() const;
  [[nodiscard]] const hal::JointVector& commanded() const { return view_.commanded_rad; }
  /// The trajectory that was followed last, null before the first one; whether the arm goes back along it.
  [[nodiscard]] const planner::Trajectory* trajectory() const {
    return trajectories_.empty() ? nullptr : trajectories_.back().get();
  }
  [[nodiscard]] bool goes_back() const { return goes_back_; }
  [[nodiscard]] std::uint32_t starts() const { return view_.starts; }

 private:
  struct Threaded;
  /// The view knows of everything that was asked of the motion.
  [[nodiscard]] bool current() const { return view_.answered >= motion_id_; }
  void ask(ArmRequest request);

  hal::Arm& arm_;
  ArmController controller_;
  SetpointLimits limits_;
  int max_misses_ = 0;  ///< For the first state after activation.
  ArmView view_;
  std::uint32_t last_id_ = 0, motion_id_ = 0;  ///< Of the last request; of the last one that moves the arm.
  std::vector<std::shared_ptr<const planner::Trajectory>>
      trajectories_;  ///< Kept: none is freed in the arm's cycle.
  std::vector<std::string> realtime_;
  bool goes_back_ = false;
  bool started_ = false;
  std::unique_ptr<Threaded> thread_;
  std::function<void(ArmView&)> recorded_;
};

}  // namespace colift::control
