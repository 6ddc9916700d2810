#pragma once

// One phase on its own: a mock arm that goes where it is commanded, a hand and a camera that say what the
// test says, and the context that the phase works in. Cycles of 5 ms.

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "control/task/supervision/arm_supervisor.hpp"
#include "control/task/supervision/camera_supervisor.hpp"
#include "control/task/supervision/hand_supervisor.hpp"
#include "control/task/supervision/speed_scaling.hpp"
#include "control/task/task_context.hpp"
#include "sim_hal/mock/mock_arm.hpp"

namespace colift::control::test {

using namespace std::chrono_literals;
using hal::JointVector;

class ScriptedHand final : public hal::Hand {
 public:
  hal::Result<> configure() override { return {}; }
  hal::Result<> activate() override { return {}; }
  void deactivate() noexcept override {}
  [[nodiscard]] hal::DeviceHealth health() const override { return {}; }
  [[nodiscard]] hal::Result<hal::HandState> state() override {
    if (error) return tl::unexpected(*error);
    return now;
  }
  [[nodiscard]] hal::Result<> preshape(double) override {
    if (refusal) return tl::unexpected(*refusal);
    return command("preshape");
  }
  [[nodiscard]] hal::Result<> close(double) override { return command("close"); }
  [[nodiscard]] hal::Result<> release() override { return command("release"); }
  void stop() noexcept override {}

  hal::HandState now;
  std::optional<hal::Error> error;    ///< Of state().
  std::optional<hal::Error> refusal;  ///< Of preshape().
  std::vector<std::string> commands;

 private:
  hal::Result<> command(const char* name) {
    commands.emplace_back(name);
    return {};
  }
};

class ScriptedCamera final : public hal::DepthCamera {
 public:
  hal::Result<> configure() override {
    ++opened;
    return {};
  }
  hal::Result<> activate() override { return {}; }
  void deactivate() noexcept override {}
  [[nodiscard]] hal::DeviceHealth health() const override { return {}; }
  [[nodiscard]] hal::Result<hal::DepthFrame> next_frame(std::chrono::milliseconds) override {
    if (unplugged) return hal::failure(hal::ErrorCode::LinkLost, "camera", "unplugged");
    if (frames.empty()) return hal::failure(hal::ErrorCode::Timeout, "camera", "no frame");
    hal::DepthFrame frame = std::move(frames.front());
    frames.pop_front();
    return frame;
  }

  std::deque<hal::DepthFrame> frames;
  bool unplugged = false;
  int opened = 0;
};

class SharedClock final : public hal::Clock {
 public:
  explicit SharedClock(const hal::Clock& clock) : clock_(clock) {}
  [[nodiscard]] hal::Timestamp now() const override { return clock_.now(); }

 private:
  const hal::Clock& clock_;
};

inline JointVector phase_home() {
  return (JointVector() << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0).finished();
}

inline planner::Trajectory trajectory(const JointVector& from, const JointVector& to) {
  return planner::make_trajectory(std::vector{from, to}, planner::MotionLimits{}, 0.0).value();
}

/// Phases that begin at once; announcements have tests of their own.
inline Config unannounced() {
  Config config;
  config.task.intent_lead_s = 0.0;
  return config;
}

struct PhaseRig {
  explicit PhaseRig(const Config& config = unannounced(), const JobOptions& options = {}) {
    sim_hal::ArmScript script;
    script.start_rad = phase_home();
    script.external_nm = [this](hal::Timestamp, const JointVector&) { return external_nm; };
    auto made_arm = std::make_unique<sim_hal::MockArm>(script, clock);
    arm = made_arm.get();
    robot.arm = std::move(made_arm);
    auto made_hand = std::make_unique<ScriptedHand>();
    hand = made_hand.get();
    robot.hand = std::move(made_hand);
    auto made_camera = std::make_unique<ScriptedCamera>();
    camera = made_camera.get();
    robot.camera = std::move(made_camera);
    robot.clock = std::make_unique<SharedClock>(clock);
    c.emplace(robot, RigView{hal::built_in_robot(), hand_model, nullptr, hal::Pose::Identity()}, config,
              options, stopwatch);
    started = robot.arm->configure().has_value() && c->arm.start().has_value();
    c->began = c->now = c->since = clock.now();
    arms.emplace(*c);
    hands.emplace(*c);
    cameras.emplace(*c);
    speed.emplace(*c);
    hands->start();
    cameras->start();
    speed->start();
    cycle([] { return std::nullopt; });
  }

  /// One cycle: devices, the phase's work, the arm's command.
  template <class Work>
  std::optional<TaskEvent> cycle(Work work) {
    arms->read(speed->reason());
    hands->read();
    cameras->read();
    speed->update(hands->warning());
    std::optional<TaskEvent> event = work();
    c->arm.end_cycle();
    return event;
  }
  /// Cycles until the phase reports an event, or for some time.
  template <class Work>
  std::optional<TaskEvent> run(Work work, double max_s = 60.0) {
    const hal::Timestamp end = clock.now() + hal::duration_of(max_s);
    while (clock.now() < end)
      if (auto event = cycle(work)) return event;
    return std::nullopt;
  }
  void idle(double s) {
    (void)run([] { return std::optional<TaskEvent>(); }, s);
  }

  void enter(Task task) {
    c->state = task;
    c->since = c->now;
  }

  /// A plan around the present position: transit in A1, approach in A4, and both backwards.
  void make_plan() {
    JointVector pre = phase_home(), grasp = phase_home();
    pre[0] += 0.3;
    grasp = pre;
    grasp[3] += 0.1;
    planner::MotionPlan plan;
    plan.transit = trajectory(phase_home(), pre);
    plan.approach = trajectory(pre, grasp);
    plan.retreat = trajectory(grasp, pre);
    plan.home = trajectory(pre, phase_home());
    c->record.plan = plan;
  }

  /// A decision with one candidate, chosen.
  void make_decision() {
    Outcome outcome;
    outcome.partner.emplace();
    outcome.partner->position = {0.4, 0.0, 0.3};
    outcome.candidates.resize(1);
    outcome.candidates[0].position = {-0.4, 0.0, 0.3};
    outcome.decision.chosen = 0;
    outcome.decision.share = 0.5;
    c->record.decision = std::move(outcome);
  }

  /// A frame of 4 x 3 pixels, exposed now.
  [[nodiscard]] hal::DepthFrame frame(float depth_m) const {
    hal::DepthFrame f;
    f.exposed_at = clock.now();
    f.intrinsics.width = 4;
    f.intrinsics.height = 3;
    f.depth_m.assign(12, depth_m);
    return f;
  }

  [[nodiscard]] std::string notes() const {
    std::string all;
    for (const DeviceNote& n : c->record.faults) all += n.device + ": " + n.what + "\n";
    return all;
  }

  hal::ManualClock clock, stopwatch;
  planner::HandModel hand_model;
  JointVector external_nm = JointVector::Zero();
  hal::Robot robot;
  sim_hal::MockArm* arm = nullptr;
  ScriptedHand* hand = nullptr;
  ScriptedCamera* camera = nullptr;
  std::optional<TaskContext> c;
  std::optional<ArmSupervisor> arms;
  std::optional<HandSupervisor> hands;
  std::optional<CameraSupervisor> cameras;
  std::optional<SpeedScaling> speed;
  bool started = false;
};

}  // namespace colift::control::test
