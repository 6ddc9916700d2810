#include "tools/bring_up/hal_arm_task.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>

#include "control/arm/setpoint_generator.hpp"
#include "hal/types/units.hpp"

namespace colift::tools {
namespace {

using hal::ErrorCode;
using How = ArmTaskEnd::How;
using Phase = ArmProgress::Phase;

constexpr int kMostBadCycles = 500;  // in a row: a link that brings nothing usable
constexpr int kStatesToStart = 20;   // after the arm was opened, for a first good one
constexpr int kSettled = 4;          // commands at rest before a motion
constexpr double kHeldUp_s = 1.0;    // commands may be held up that long: packets lost, quality
constexpr double kSettle_s = 0.5;    // after a motion, for the arm to arrive
constexpr double kMostRest_s = 3.0;  // for coming to rest
// the load is measured in a pose after the arm has come to rest, over several periods of what it swings with
constexpr double kLoadSettle_s = 1.0, kLoadMean_s = 0.4;

control::TaskConfig task_config(const ArmTask& task) {
  control::TaskConfig c = task.config;
  c.stiffness_nm_rad = ArmTask{}.stiffness_nm_rad;  // as the driver starts; then on a ramp to the wished one
  return c;
}

control::SetpointLimits setpoint_limits(const ArmTask& task, const hal::GuardConfig& guard) {
  control::SetpointLimits l = task.setpoints.below(guard);
  l.velocity_fraction = std::min(l.velocity_fraction, 0.9 * guard.velocity_fraction);
  l.acceleration_rad_s2 = std::min(std::max(1.0, task.acceleration_rad_s2), 0.9 * guard.acceleration_rad_s2);
  l.limit_margin_rad = 0.0;  // the guard keeps one; a start inside of it has to be possible
  return l;
}

class Runner {
 public:
  Runner(hal::Arm& arm, const hal::RobotModel& model, const hal::GuardConfig& guard, const ArmTask& task,
         const hal::Clock& clock, const ArmTaskHooks& hooks)
      : arm_(arm),
        model_(model),
        guard_(guard),
        task_(task),
        clock_(clock),
        hooks_(hooks),
        setpoints_(model, task_config(task), setpoint_limits(task, guard)) {}

  ArmTaskEnd run() {
    go_on(Phase::Opening);
    if (auto opened = arm_.configure(); !opened) return finish(How::Refused, opened.error().text());
    if (task_.kind == ArmTask::Kind::Watch) return watch();
    if (!first_state()) return finish(How::Refused, "no usable state came: " + why("of the arm"));
    if (task_.kind == ArmTask::Kind::Move)
      if (std::string bad =
              beyond_limits(model_, guard_, task_.joint, state_.q_rad[task_.joint], task_.by_rad);
          !bad.empty())
        return finish(How::BadRequest, bad);
    if (task_.kind == ArmTask::Kind::Load) {
      auto poses = hal::load_poses(model_, hal::deg_to_rad(guard_.limit_margin_deg), state_.q_rad);
      if (!poses) return finish(How::BadRequest, poses.error().text());
      poses_ = std::move(*poses);
      end_.load_samples.reserve(poses_.size());
    }
    if (hooks_.interrupted) return finish(How::Interrupted, "asked to end");
    go_on(Phase::Asking);
    if (auto active = arm_.activate(); !active) {
      if (hooks_.interrupted)
        return leave(How::Interrupted, "asked to end while command mode was waited for");
      return leave(How::Refused, active.error().text());
    }
    command();
    if (task_.kind == ArmTask::Kind::Load && how_ == How::Done) judge_load();
    return leave(how_, reason_);
  }

 private:
  [[nodiscard]] double in_phase() const { return hal::seconds(clock_.now() - since_); }
  void go_on(Phase phase) {
    phase_ = phase;
    since_ = clock_.now();
    report();
  }
  void report() {
    ArmProgress p;
    p.phase = phase_;
    p.in_phase_s = in_phase();
    p.done = setpoints_.progress();
    for (int i = 0; i < hal::kArmJoints; ++i) {
      // before the first command of this program: where the controller commands it
      const auto& commanded = setpoints_.running() ? setpoints_.commanded() : state_.q_commanded_rad;
      p.commanded_rad[static_cast<std::size_t>(i)] = commanded[i];
      p.measured_rad[static_cast<std::size_t>(i)] = state_.q_rad[i];
    }
    hooks_.progress.write(p);
  }
  [[nodiscard]] std::string why(const std::string& otherwise) const {
    const std::string text = hooks_.why ? hooks_.why() : "";
    return text.empty() ? otherwise : text;
  }

  ArmTaskEnd finish(How how, std::string reason) {
    end_.how = how;
    end_.reason = std::move(reason);
    go_on(Phase::Over);
    return end_;
  }
  ArmTaskEnd leave(How how, std::string reason) {
    go_on(Phase::Leaving);
    arm_.deactivate();
    return finish(how, std::move(reason));
  }

  ArmTaskEnd watch() {
    go_on(Phase::Watching);
    while (!hooks_.interrupted && in_phase() < task_.for_s) {
      if (auto state = arm_.wait_cycle()) {
        state_ = *state;
        ++end_.cycles;
      } else {
        ++end_.bad_cycles;
      }
      report();
    }
    // whoever watches without an end has no other way than to interrupt
    const bool cut = hooks_.interrupted && std::isfinite(task_.for_s);
    return finish(cut ? How::Interrupted : How::Done, cut ? "asked to end" : "");
  }

  bool first_state() {
    for (int i = 0; i < kStatesToStart; ++i) {
      if (auto state = arm_.wait_cycle()) {
        state_ = *state;
        return true;
      }
    }
    return false;
  }

  /// Commands until the end; how_ and because_ say which.
  void command() {
    go_on(Phase::Commanding);
    int bad = 0;
    while (!over_) {
      auto state = arm_.wait_cycle();
      if (!state) {
        ++end_.bad_cycles;
        const bool gone =
            state.error().code == ErrorCode::LinkLost || state.error().code == ErrorCode::NotReady;
        if (gone || ++bad > kMostBadCycles) return lost(state.error().text());
        continue;
      }
      bad = 0;
      ++end_.cycles;
      state_ = *state;
      answer();
      report();
    }
  }

  void lost(const std::string& otherwise) {
    how_ = How::Lost;
    reason_ = why(otherwise);
    over_ = true;
  }

  void answer() {
    const double t = hal::seconds(state_.measured_at);
    const std::uint32_t starts = setpoints_.starts();
    const hal::ImpedanceCommand wished = with_damping(setpoints_.step(state_));
    if (!state_.may_command) {
      if (!held_since_s_) {
        held_since_s_ = t;
        held_why_ = why("the arm's controller accepts no commands any more");
      }
      if (hooks_.interrupted) {
        how_ = How::Interrupted;
        reason_ = "asked to end";
        over_ = true;
      } else if (t - *held_since_s_ > kHeldUp_s) {
        lost(held_why_);
        reason_ = held_why_;
      }
      return;
    }
    held_since_s_.reset();
    if (auto sent = arm_.command(wished); !sent) {
      if (sent.error().code != ErrorCode::LimitExceeded) return;  // shows in the next state
      how_ = How::Stopped;
      reason_ = sent.error().text();
      over_ = true;
      return;
    }
    if (!end_.commanded) begin(t);
    if (setpoints_.starts() != starts && starts > 0) {
      settled_ = 0;
      if (moving_ || task_.kind == ArmTask::Kind::Hold) ++end_.restarts;
      if (moving_ && !ending_)
        bring_to_rest(How::Stopped,
                      "the motion was cut off: " + (held_why_.empty() ? "a gap in the states" : held_why_),
                      t);
    }
    note(wished, t);
    steer(t);
  }

  hal::ImpedanceCommand with_damping(hal::ImpedanceCommand c) const {
    c.damping_ratio.setConstant(task_.damping_ratio);
    return c;
  }

  /// The first command is out: the arm holds the measured pose.
  void begin(double t) {
    end_.commanded = true;
    end_.start_rad = state_.q_rad;
    began_s_ = t;
    setpoints_.set_stiffness(task_.stiffness_nm_rad);
  }

  void set_out(double t) {
    moving_ = true;
    home_ = setpoints_.commanded();
    if (task_.kind == ArmTask::Kind::Load) return go_to(poses_.front(), t);
    hal::JointVector to = home_;
    to[task_.joint] += task_.by_rad;
    go_to(to, t);
  }

  void go_to(const hal::JointVector& to, double t) {
    const hal::JointVector from = setpoints_.commanded();
    planner::MotionLimits limits;
    limits.velocity_rad_s.setConstant(task_.speed_rad_s);
    limits.acceleration_rad_s2.setConstant(task_.acceleration_rad_s2);
    limits.jerk_rad_s3.setConstant(task_.jerk_rad_s3);
    const std::array<hal::JointVector, 2> path{from, to};
    auto way = planner::make_trajectory(path, limits, 0.0);
    if (!way) return bring_to_rest(How::Stopped, way.error().text(), t);
    if (auto follows = setpoints_.follow(std::make_shared<const planner::Trajectory>(std::move(*way)));
        !follows)
      bring_to_rest(How::Stopped, follows.error().text(), t);
  }

  void note(const hal::ImpedanceCommand& sent, double t) {
    end_.commanded_s = t - began_s_;
    end_.end_rad = state_.q_rad;
    end_.goal_rad = sent.q_rad;
    end_.drift_rad = end_.drift_rad.cwiseMax((state_.q_rad - sent.q_rad).cwiseAbs());
    end_.external_nm = end_.external_nm.cwiseMax(state_.tau_external_nm.cwiseAbs());
  }

  void bring_to_rest(How how, std::string reason, double t) {
    ending_ = true;
    ending_since_s_ = t;
    how_ = how;
    reason_ = std::move(reason);
    setpoints_.hold();
    go_on(Phase::Stopping);
  }

  void steer(double t) {
    if (ending_) {
      over_ = setpoints_.at_rest() || t - ending_since_s_ > kMostRest_s;
      return;
    }
    if (hooks_.interrupted) return bring_to_rest(How::Interrupted, "asked to end", t);
    if (task_.kind == ArmTask::Kind::Hold) {
      over_ = t - began_s_ >= task_.for_s;
      return;
    }
    // the set points learn the arm's period first: with a long one every state would be a gap
    if (!moving_) {
      if (++settled_ >= kSettled) set_out(t);
      return;
    }
    if (setpoints_.blocked()) return bring_to_rest(How::Stopped, describe(setpoints_.blockage()), t);
    if (!setpoints_.done()) arrived_s_.reset();
    if (setpoints_.done() && !arrived_s_) arrived_s_ = t;
    const double at_rest_s = arrived_s_ ? t - *arrived_s_ : 0.0;
    if (task_.kind == ArmTask::Kind::Load && end_.load_samples.size() < poses_.size())
      return measure_load(at_rest_s, t);
    over_ = arrived_s_ && at_rest_s >= kSettle_s;
  }

  /// One pose of the load: the mean of what is measured at rest, then on to the next one or back.
  void measure_load(double at_rest_s, double t) {
    if (at_rest_s < kLoadSettle_s) {
      load_mean_ = {};
      mean_cycles_ = 0;
      return;
    }
    load_mean_.q_rad += state_.q_rad;
    load_mean_.tau_external_nm += state_.tau_external_nm;
    ++mean_cycles_;
    if (at_rest_s < kLoadSettle_s + kLoadMean_s) return;
    load_mean_.q_rad /= mean_cycles_;
    load_mean_.tau_external_nm /= mean_cycles_;
    end_.load_samples.push_back(load_mean_);
    arrived_s_.reset();
    const std::size_t next = end_.load_samples.size();
    go_to(next < poses_.size() ? poses_[next] : home_, t);
  }

  void judge_load() {
    end_.expected_load = hal::hand_load(model_);
    const hal::ArmDynamics dynamics(model_, hal::ArmDynamics::Load::Hand);
    auto load = hal::estimate_load_error(dynamics, end_.load_samples);
    if (!load) {
      how_ = How::Stopped;
      reason_ = load.error().text();
      return;
    }
    end_.load = *load;
    if (!load->wrong() && !load->unexplained()) return;
    how_ = How::WrongLoad;
    reason_ = load->unexplained() ? "the arm feels torques that no load explains"
                                  : "the KRC's load data do not fit what hangs on the flange";
  }

  hal::Arm& arm_;
  const hal::RobotModel& model_;
  const hal::GuardConfig& guard_;
  const ArmTask& task_;
  const hal::Clock& clock_;
  const ArmTaskHooks& hooks_;
  control::SetpointGenerator setpoints_;
  hal::ArmState state_;
  ArmTaskEnd end_;
  Phase phase_ = Phase::Opening;
  hal::Timestamp since_{0};

  How how_ = How::Done;
  std::string reason_, held_why_;
  bool over_ = false, ending_ = false, moving_ = false;
  int settled_ = 0;  ///< Commands since the last start from the measured pose.
  double began_s_ = 0.0, ending_since_s_ = 0.0;
  std::optional<double> held_since_s_, arrived_s_;

  std::vector<hal::JointVector> poses_;
  hal::JointVector home_ = hal::JointVector::Zero();
  hal::LoadSample load_mean_;
  int mean_cycles_ = 0;
};

}  // namespace

std::string_view to_string(ArmProgress::Phase phase) {
  switch (phase) {
    case Phase::Opening:
      return "waits for the KRC";
    case Phase::Watching:
      return "watches";
    case Phase::Asking:
      return "asks for command mode";
    case Phase::Commanding:
      return "commands";
    case Phase::Stopping:
      return "comes to rest";
    case Phase::Leaving:
      return "leaves command mode";
    case Phase::Over:
      return "over";
  }
  return "";
}

ArmTaskEnd run_arm_task(hal::Arm& arm, const hal::RobotModel& model, const hal::GuardConfig& guard,
                        const ArmTask& task, const hal::Clock& clock, const ArmTaskHooks& hooks) {
  return Runner(arm, model, guard, task, clock, hooks).run();
}

std::string beyond_limits(const hal::RobotModel& model, const hal::GuardConfig& guard, int joint,
                          double q_rad, double by_rad) {
  const double margin = hal::deg_to_rad(guard.limit_margin_deg);
  const double low = model.lower_rad()[joint] + margin, high = model.upper_rad()[joint] - margin;
  const double to = q_rad + by_rad;
  if ((to >= low && to <= high) || (by_rad > 0 && q_rad < low && to <= high) ||
      (by_rad < 0 && q_rad > high && to >= low))
    return "";
  return fmt::format(
      "A{} stands at {:.1f} deg; by {:+.1f} deg it would come to {:.1f}, allowed is {:.1f} to {:.1f} (at "
      "most {:+.1f} "
      "this way)",
      joint + 1, hal::rad_to_deg(q_rad), hal::rad_to_deg(by_rad), hal::rad_to_deg(to), hal::rad_to_deg(low),
      hal::rad_to_deg(high),
      hal::rad_to_deg(by_rad > 0 ? std::max(0.0, high - q_rad) : std::min(0.0, low - q_rad)));
}

std::string task_summary(const ArmTask& task, const ArmTaskEnd& e) {
  std::string t;
  if (e.commanded && task.kind != ArmTask::Kind::Switch) {
    Eigen::Index worst = 0, measured = 0;
    const double drift = e.drift_rad.maxCoeff(&worst), external = e.external_nm.maxCoeff(&measured);
    if (task.kind == ArmTask::Kind::Move) {
      t += fmt::format(
          "A{} moved by {:+.2f} deg (asked for {:+.2f}) in {:.1f} s, {:.3f} deg from where it was "
          "commanded\n",
          task.joint + 1, hal::rad_to_deg(e.end_rad[task.joint] - e.start_rad[task.joint]),
          hal::rad_to_deg(task.by_rad), e.commanded_s,
          hal::rad_to_deg(std::abs(e.end_rad[task.joint] - e.goal_rad[task.joint])));
    } else if (task.kind == ArmTask::Kind::Load) {
      t += fmt::format("measured the load in {} of {} poses in {:.1f} s\n", e.load_samples.size(),
                       hal::kLoadPoses, e.commanded_s);
    } else {
      Eigen::Index moved = 0;
      const double most = (e.end_rad - e.start_rad).cwiseAbs().maxCoeff(&moved);
      t += fmt::format(
          "held the measured pose for {:.1f} s {}; it ended {:.3f} deg from its start (A{})\n", e.commanded_s,
          task.control == "joint_impedance" ? fmt::format("with {:.0f} N m/rad", task.stiffness_nm_rad)
                                            : "in " + task.control,
          hal::rad_to_deg(most), moved + 1);
    }
    t += fmt::format(
        "max following error {:.3f} deg (A{}), max external torque {:.1f} N m (A{}); "
        "{} cycles, {} without a state, {} restarts from the measured pose\n",
        hal::rad_to_deg(drift), worst + 1, external, measured + 1, e.cycles, e.bad_cycles, e.restarts);
  }
  if (task.kind == ArmTask::Kind::Switch) t += describe(SwitchEnd{{}, false, e.switches});
  if (e.load) t += describe(*e.load, e.expected_load);
  if (e.how == How::Interrupted) t += fmt::format("interrupted: {}\n", e.reason);
  return t;
}

}  // namespace colift::tools
