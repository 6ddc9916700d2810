#include "tools/experiments/runs/faulty_lift.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "control/recovery/recovery.hpp"
#include "control/task/run_job.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "sim_hal/judge/judge.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "tools/experiments/trials/sighting.hpp"
#include "tools/rig/lock_step/arm_wire.hpp"
#include "tools/rig/lock_step/hand_wire.hpp"

namespace colift::experiments {
namespace {

using sim_hal::DeviceFaultEvent;

constexpr double kSample_s = 0.01, kGrace_s = 30.0;
constexpr double kPulledAway_m = 0.1;
constexpr double kFree_m = 0.3;  // who confirms moves nothing while anybody is nearer than that
constexpr hal::Duration kMends = std::chrono::seconds(3);

/// The three rigs: a simulated world, one device of which may be at the end of a wire.
class FaultyRig {
 public:
  FaultyRig(sim_hal::SimWorld& world, Wire wire, std::uint64_t seed) : world_(world) {
    sim_hal::KrcConfig krc;
    krc.seed = seed;
    if (wire == Wire::Arm) arm_ = std::make_unique<tools::ArmWire>(world, krc);
    if (wire == Wire::Hand) hand_ = std::make_unique<tools::HandWire>(world, seed);
    for (const DeviceFaultEvent& event : world.scenario().faults)
      if (wired(event)) to_come_.push_back(event);
  }

  [[nodiscard]] hal::Robot robot(const control::Config& config) {
    hal::Robot robot;
    std::unique_ptr<hal::Arm> arm;
    if (arm_)
      arm = arm_->arm();
    else
      arm = sim_hal::make_sim_arm(world_);
    if (hand_) arm = hand_->arm(std::move(arm));
    robot.arm = std::make_unique<hal::GuardedArm>(std::move(arm), world_.model(), config.guard_arm);
    std::unique_ptr<hal::Hand> hand;
    if (hand_)
      hand = hand_->hand();
    else
      hand = sim_hal::make_sim_hand(world_);
    robot.hand = std::make_unique<hal::GuardedHand>(std::move(hand), config.guard_hand);
    robot.camera = sim_hal::make_sim_camera(world_);
    if (arm_)
      robot.clock = std::make_unique<tools::WireClock>(arm_->clock);
    else if (hand_)
      robot.clock = std::make_unique<tools::WireClock>(hand_->clock);
    else
      robot.clock = sim_hal::make_sim_clock(world_);
    return robot;
  }

  /// The devices are ready: faults and people count from now.
  void begin() {
    if (arm_ || hand_) world_.begin_scenario();
    enter("");
  }
  /// Faults of the wired device whose time counts from a state; "" is the start.
  void enter(const std::string& state) {
    for (DeviceFaultEvent event : to_come_)
      if (event.in_state == state) inject(event);
    std::erase_if(to_come_, [&](const DeviceFaultEvent& event) { return event.in_state == state; });
  }
  /// The robot is gone; a person removes what was wrong, which takes a while.
  void mend() {
    to_come_.clear();
    world_.end_faults();
    if (arm_) arm_->krc.mend();
    if (hand_) hand_->pucks.mend();
    if (arm_)
      arm_->let_pass(kMends);
    else if (hand_)
      hand_->let_pass(kMends);
    else
      world_.advance(kMends);
  }
  [[nodiscard]] std::vector<std::string> broken_rules() const {
    std::vector<std::string> all;
    if (arm_)
      for (const auto& rule : arm_->krc.report().broken_rules) all.push_back(rule.reason);
    if (hand_)
      for (std::size_t r = 0; r < sim_hal::kHandRules; ++r)
        if (const auto& report = hand_->pucks.report(); report.broken[r] > 0)
          all.push_back(std::string(sim_hal::kHandRuleNames[r]) + ": " + report.first[r]);
    return all;
  }

 private:
  [[nodiscard]] bool wired(const DeviceFaultEvent& event) const {
    return event.action != "push" && ((arm_ && event.device == "arm") || (hand_ && event.device == "hand"));
  }
  void inject(const DeviceFaultEvent& event) {
    if (arm_) {
      auto fault = sim_hal::krc_fault(event);
      if (!fault) throw std::invalid_argument(fault.error().text());
      fault->at_s += hal::seconds(arm_->clock.now());
      arm_->krc.inject(*fault);
    } else {
      auto fault = sim_hal::hand_fault(event);
      if (!fault) throw std::invalid_argument(fault.error().text());
      fault->at_s += hand_->pucks.elapsed_s();
      hand_->pucks.inject(*fault);
    }
  }

  sim_hal::SimWorld& world_;
  std::unique_ptr<tools::ArmWire> arm_;
  std::unique_ptr<tools::HandWire> hand_;
  std::vector<DeviceFaultEvent> to_come_;
};

void observe(FaultyLift& lift, sim_hal::Judge& judge, const sim_hal::TickReport& report) {
  judge.tick(report);
  lift.end_s = report.t_s;
  const bool touched = report.pushed || !report.contacts.empty();
  if (!lift.motion.empty() && report.t_s - lift.motion.back().t_s < kSample_s - 1e-6) {
    lift.motion.back().touched |= touched;
    return;
  }
  // the scenario begins anew once the devices of a wire are ready
  if (!lift.motion.empty() && report.t_s < lift.motion.back().t_s) lift.motion.clear();
  lift.motion.push_back({report.t_s, report.truth.q_rad, touched});
}

/// A new process at the same rig, after a job that has stopped.
FaultyRecovery recover(sim_hal::SimWorld& world, FaultyRig& rig, const control::RigView& view,
                       const control::Config& config, const control::JobOptions& job) {
  rig.mend();
  hal::Robot robot = rig.robot(config);
  const hal::SteadyClock wall;
  control::Recovery recovery(robot, view, config,
                             {job.method, job.seed, control::Drive::InStep, sim_hal::SimConfig::home_rad()},
                             wall);
  FaultyRecovery out;
  const double begin_s = hal::seconds(world.elapsed());
  control::RecoveryHooks hooks;
  std::optional<control::RecoveryStep> before;
  hooks.confirm = [&](control::RecoveryStep step, const std::string&) {
    const bool again = std::exchange(before, step) == step, take = step == control::RecoveryStep::TakeOver;
    if (take || (again && step == control::RecoveryStep::Release)) world.take_object();
    // who is to free an open hand that met the object pulls it away
    if (again && step != control::RecoveryStep::Release) world.pull_object_away(kPulledAway_m);
    return take ? control::Confirmation::PersonHolds : control::Confirmation::Yes;
  };
  hooks.may_move = [&] {
    out.somebody_there = world.people_distance_m() < kFree_m;
    return !out.somebody_there;
  };
  hooks.interrupted = [&] { return hal::seconds(world.elapsed()) - begin_s > kMaxJob_s; };
  hooks.say = [](const std::string&) {};
  const control::RecoveryRecord record = recovery.run(hooks);
  out.home = record.recovered;
  out.somebody_there = out.somebody_there && record.interrupted;
  for (const auto& s : record.steps)
    out.steps += fmt::format("{}{}", out.steps.empty() ? "" : ", ", word(s.step));
  out.reason = record.reason;
  return out;
}

}  // namespace

const char* word(Wire wire) {
  switch (wire) {
    case Wire::Arm:
      return "arm's wire";
    case Wire::Hand:
      return "hand's bus";
    case Wire::None:
      break;
  }
  return "simulated";
}

hal::Result<FaultyLift> run_faulty_lift(const FaultyScene& scene, const control::Config& config,
                                        control::Method method, std::uint64_t seed) {
  const hal::RobotModel& model = hal::built_in_robot();
  sim_hal::SimConfig sim;
  if (scene.wire == Wire::Arm) sim.arm_period = tools::ArmWire::kCycle;
  auto made = sim_hal::SimWorld::make(scene.scenario, model, seed, sim);
  if (!made) return tl::unexpected(made.error());
  sim_hal::SimWorld& world = **made;
  FaultyLift lift;
  // an emulated controller interpolates: steps of commands are its own affair, it judges those of its client
  sim_hal::Judge judge(model, scene.wire != Wire::Arm);
  world.observe([&](const sim_hal::TickReport& report) { observe(lift, judge, report); });
  FaultyRig rig(world, scene.wire, seed);
  std::optional<hal::Robot> robot = rig.robot(config);
  const control::RigView view{model, shared_hand(method).hand, shared_hand(method).tables,
                              sim_hal::camera_pose(scene.scenario.camera)};
  const hal::SteadyClock wall;
  control::JobOptions options;
  options.method = method;
  options.seed = seed;
  const auto enter = [&](control::Task to) {
    const std::string state(word(to));
    world.task_state(state);
    judge.task_state(state);
    rig.enter(state);
    lift.entered.emplace(state, hal::seconds(world.elapsed()));
  };
  control::JobHooks hooks;
  hooks.started = [&] {
    rig.begin();
    enter(control::Task::Observe);
  };
  hooks.changed = [&](control::Task, control::Task to) { enter(to); };
  hooks.asked = [&](const control::PartnerAsk& ask) { world.ask_partner(ask.grasp_W, ask.aside_W); };
  bool endless = false;
  hooks.interrupted = [&] {
    const double t_s = hal::seconds(world.elapsed());
    endless |= t_s > kMaxJob_s;
    if (t_s > kMaxJob_s + kGrace_s) throw std::runtime_error("no end, not even after an interrupt");
    return endless || (scene.interrupted_s && t_s >= *scene.interrupted_s);
  };
  try {
    auto record = control::run_job(*robot, view, config, options, hooks, wall);
    if (record)
      lift.record = std::move(*record);
    else
      lift.failed = "at the start: " + record.error().text();
  } catch (const std::exception& e) {
    lift.failed = fmt::format("exception: {}", e.what());
  }
  if (endless && lift.failed.empty()) lift.failed = fmt::format("no end within {:.0f} s", kMaxJob_s);
  const double end_s = lift.end_s;
  const bool stopped =
      !lift.record.states.empty() && lift.record.states.back().state == control::Task::Stopped;
  if (lift.failed.empty() && stopped) {
    robot.reset();
    judge.task_state("recover");
    try {
      lift.recovery = recover(world, rig, view, config, options);
    } catch (const std::exception& e) {
      lift.failed = fmt::format("exception of the recovery: {}", e.what());
    }
    lift.end_s = end_s;
  }
  lift.verdict = judge.verdict(lift.record.outcome == control::RunRecord::Result::Lifted);
  lift.broken_rules = rig.broken_rules();
  lift.divergences = world.truth().divergences;
  lift.hit_something = world.truth().robot_hit_something;
  return lift;
}

double moved_rad(const FaultyLift& lift, double from_s, double to_s) {
  double most = 0.0;
  const hal::JointVector* rests_at = nullptr;
  for (const FaultyLift::Sample& s : lift.motion) {
    if (s.t_s < from_s || s.t_s > to_s) continue;
    if (rests_at == nullptr || s.touched) rests_at = &s.q_rad;  // a person may push a soft arm away
    most = std::max(most, (s.q_rad - *rests_at).cwiseAbs().maxCoeff());
  }
  return most;
}

}  // namespace colift::experiments
