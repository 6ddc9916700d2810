#include "tests/support/simulated_lift.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "control/config/method.hpp"
#include "control/task/run_job.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "hal/types/units.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "tools/rig/lock_step/arm_wire.hpp"
#include "tools/rig/lock_step/hand_wire.hpp"

namespace colift::tests {
namespace {

using tools::ArmWire;
using tools::HandWire;
using tools::WireClock;

/// Whether a finger went open while the object was in the air.
class GripWatch {
 public:
  void see(control::Task state, const hal::HandState& hand) {
    using control::Task;
    const bool raised = state == Task::TestLift || state == Task::Lift;
    const bool in_air = raised || state == Task::Hold || state == Task::Lower || state == Task::Stopped;
    lifted_ = in_air && (lifted_ || raised);
    if (!lifted_) {
      most_.reset();
      return;
    }
    if (!most_) most_ = hand.finger_rad;
    for (std::size_t f = 0; f < hand.finger_rad.size(); ++f) {
      (*most_)[f] = std::max((*most_)[f], hand.finger_rad[f]);
      opened_rad_ = std::fmax(opened_rad_, (*most_)[f] - hand.finger_rad[f]);
    }
  }
  [[nodiscard]] double opened_rad() const { return opened_rad_; }

 private:
  bool lifted_ = false;
  std::optional<std::array<double, hal::kFingers>> most_;
  double opened_rad_ = NAN;
};

}  // namespace

SimulatedLift simulate(const sim_hal::Scenario& scenario, control::Method method, std::uint64_t seed,
                       control::Config config, const std::optional<OverWire>& over,
                       const ThroughCamera& through) {
  const hal::RobotModel& model = hal::built_in_robot();
  sim_hal::SimConfig sim;
  if (over) sim.arm_period = ArmWire::kCycle;
  auto made = sim_hal::SimWorld::make(scenario, model, seed, sim);
  if (!made) throw std::runtime_error(made.error().text());
  const std::unique_ptr<sim_hal::SimWorld> world = std::move(*made);
  std::unique_ptr<ArmWire> wire;
  if (over && over->arm) {
    sim_hal::KrcConfig krc;
    krc.seed = seed;
    krc.extrapolated = over->extrapolated;
    krc.quality.bad = over->min_rate;
    krc.limits.velocity_rad_s = krc.limits.velocity_rad_s.cwiseMin(over->joint_rad_s);
    wire = std::make_unique<ArmWire>(*world, krc);
  }
  std::unique_ptr<HandWire> bus;
  if (over && over->hand) bus = std::make_unique<HandWire>(*world, seed, over->hand_bus);
  hal::Robot robot;
  std::unique_ptr<hal::Arm> arm;
  if (wire)
    arm = wire->arm();
  else
    arm = sim_hal::make_sim_arm(*world);
  if (bus) arm = bus->arm(std::move(arm));
  robot.arm = std::make_unique<hal::GuardedArm>(std::move(arm), model, config.guard_arm);
  std::unique_ptr<hal::Hand> hand_device;
  if (bus)
    hand_device = bus->hand();
  else
    hand_device = sim_hal::make_sim_hand(*world);
  robot.hand = std::make_unique<hal::GuardedHand>(std::move(hand_device), config.guard_hand);
  robot.camera = sim_hal::make_sim_camera(*world);
  if (through) robot.camera = through(std::move(robot.camera));
  if (wire)
    robot.clock = std::make_unique<WireClock>(wire->clock);
  else if (bus)
    robot.clock = std::make_unique<WireClock>(bus->clock);
  else
    robot.clock = sim_hal::make_sim_clock(*world);

  config.task.lift_height_m = scenario.task.height;
  config.task.hold_s = scenario.task.hold_s;
  control::set_method_defaults(method, config);
  const planner::HandModel hand;
  const auto tables = std::make_shared<planner::HandCollision>(hand, config.candidates.collision);
  const hal::SteadyClock wall;
  hal::Pose X_WC = sim_hal::camera_pose(scenario.camera);
  if (over) X_WC.pretranslate(over->camera_off_m);
  robot.more_cameras = sim_hal::make_more_sim_cameras(*world);
  const control::RigView rig{model, hand, tables, X_WC, sim_hal::more_camera_poses(scenario)};

  SimulatedLift lift;
  std::optional<hal::Vec3> partner;
  int n = 0;
  double tilt = 0, height = 0, share = 0, slip = 0;
  control::JobHooks hooks;
  const auto inject_arm = [&](sim_hal::KrcFault fault) {
    fault.at_s += hal::seconds(wire->clock.now());
    wire->krc.inject(fault);
  };
  const auto inject_hand = [&](sim_hal::HandFault fault) {
    fault.at_s += bus->pucks.elapsed_s();
    bus->pucks.inject(fault);
  };
  const auto entered = [&](control::Task state) {
    if (!over || !over->entered) return;
    const auto fault = over->entered(state);
    if (!fault) return;
    if (const auto* of_hand = std::get_if<sim_hal::HandFault>(&*fault))
      inject_hand(*of_hand);
    else
      inject_arm(std::get<sim_hal::KrcFault>(*fault));
  };
  // the pucks have to wake and to find their stops first
  hooks.started = [&] {
    if (bus) world->begin_scenario();
    world->task_state(std::string(word(control::Task::Observe)));
    entered(control::Task::Observe);
  };
  hooks.lower_confirmed = [&] { return world->take_lower_confirmed(); };
  hooks.continue_confirmed = [&] { return world->take_continue_confirmed(); };
  GripWatch grip;
  hooks.asked = [&](const control::PartnerAsk& ask) { world->ask_partner(ask.grasp_W, ask.aside_W); };
  if (!scenario.people.empty())
    hooks.cycle = [&](const control::ArmView&) {
      for (const sim_hal::BodyContact& c : world->body_contacts())
        lift.person_contacts += c.by == sim_hal::BodyContact::By::Robot ? 1 : 0;
    };
  hooks.status = [&](const control::JobStatus& status) {
    const sim_hal::SimTruth truth = world->truth();
    grip.see(status.state, world->hand_state());
    lift.to_limit_deg = std::min(lift.to_limit_deg, to_limit_deg(model, truth.q_rad));
    const bool decided = status.state == control::Task::Plan || status.state == control::Task::Approach;
    if (status.state == control::Task::Decide || (decided && !partner)) partner = truth.partner_W;
    if (status.state != control::Task::Hold) return;
    ++n;
    tilt += truth.tilt_rad * 180.0 / std::numbers::pi;
    height += truth.height_m;
    slip = std::max(slip, truth.slip_m);
    share += truth.robot_force_W.z() /
             (truth.robot_force_W.z() + truth.partner_force_W.z() + truth.floor_force_W.z());
  };
  std::vector<OverWire::Fault> to_come = over ? over->faults : std::vector<OverWire::Fault>{};
  std::vector<OverWire::OfHand> hand_to_come = over ? over->hand_faults : std::vector<OverWire::OfHand>{};
  hooks.changed = [&](control::Task, control::Task to) {
    std::erase_if(to_come, [&](const OverWire::Fault& f) {
      if (f.in != to) return false;
      inject_arm(f.fault);
      return true;
    });
    std::erase_if(hand_to_come, [&](const OverWire::OfHand& f) {
      if (f.in != to) return false;
      inject_hand(f.fault);
      return !f.each_time;
    });
    world->task_state(std::string(word(to)));
    entered(to);
  };
  auto record = control::run_job(robot, rig, config, {method, seed}, hooks, wall);
  if (!record) throw std::runtime_error(record.error().text());
  lift.record = std::move(*record);
  if (n > 0) {
    lift.tilt_deg = tilt / n;
    lift.height_m = height / n;
    lift.share_robot = share / n;
    lift.slip_m = slip;
  }
  if (partner && lift.record.decision && lift.record.decision->partner)
    lift.partner_error_m = (lift.record.decision->partner->position - *partner).norm();
  lift.at_end = world->truth();
  lift.hit_something = lift.at_end.robot_hit_something;
  if (wire) lift.wire = wire->krc.report();
  if (bus) lift.pucks = bus->pucks.report();
  if (bus) lift.frames_lost = bus->frames_lost();
  lift.most_open_while_loaded_rad = grip.opened_rad();
  return lift;
}

double to_limit_deg(const hal::RobotModel& robot, const hal::JointVector& q_rad) {
  return hal::rad_to_deg((q_rad - robot.lower_rad()).cwiseMin(robot.upper_rad() - q_rad).minCoeff());
}

double quantile(std::vector<double> values, double p) {
  std::erase_if(values, [](double v) { return std::isnan(v); });
  if (values.empty()) return NAN;
  std::sort(values.begin(), values.end());
  const double at = p * static_cast<double>(values.size() - 1);
  const auto low = static_cast<std::size_t>(at);
  const std::size_t high = std::min(low + 1, values.size() - 1);
  return values[low] + (at - std::floor(at)) * (values[high] - values[low]);
}

}  // namespace colift::tests
