#include "run_example.hpp"

#include <cmath>
#include <limits>

#include "hal/types/time.hpp"
#include "planner/load_sharing/load_sharing.hpp"
#include "sim_hal/synthetic/kinect/kinect_noise.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"
#include "sim_hal/synthetic/scenes.hpp"

namespace colift::tests {
namespace {

using control::Task;
using hal::Vec3;
using sim_hal::Label;

constexpr double kTableYaw = 0.35;
constexpr double kMass = 4.0, kGravity = 9.81;
const Vec3 kTable(0.80, 0.0, 0.0);

Eigen::Matrix3d turn() {
  return Eigen::AngleAxisd(kTableYaw, Vec3::UnitZ()).toRotationMatrix();
}

Vec3 at_table(double x, double y, double z) {
  return kTable + turn() * Vec3(x, y, z);
}

sim_hal::World world(double rise_m) {
  sim_hal::World w;
  w.shapes.push_back(sim_hal::half_space({0, 0, 0}, Vec3::UnitZ(), Label::Ground));
  const Vec3 up(0, 0, rise_m);
  w.shapes.push_back(sim_hal::box(at_table(0, 0, 0.435) + up, {0.8, 0.5, 0.03}, kTableYaw, Label::Target));
  for (const double x : {-0.36, 0.36})
    for (const double y : {-0.21, 0.21})
      w.shapes.push_back(
          sim_hal::box(at_table(x, y, 0.21) + up, {0.04, 0.04, 0.42}, kTableYaw, Label::Target));
  return w;
}

const Vec3 kContact = at_table(0.40, 0.02, 0.435);

sim_hal::World with_person(double rise_m) {
  const Vec3 up(0, 0, rise_m);
  return sim_hal::with_partner(world(rise_m), {kContact + up, at_table(0.85, 0.2, 1.3), std::nullopt});
}

hal::DepthFrame frame_of(const sim_hal::World& w, const hal::Pose& X_WC, std::uint64_t seed, double t_s) {
  hal::DepthFrame frame = sim_hal::measure(sim_hal::cast_rays(w, {}, X_WC), {}, seed);
  frame.exposed_at = std::chrono::milliseconds(static_cast<int>(1e3 * t_s));
  return frame;
}

picture::SolidScene solids(const sim_hal::World& w) {
  picture::SolidScene scene;
  for (const sim_hal::Shape& shape : w.shapes) scene.solids.push_back(picture::solid_of(shape));
  return scene;
}

void add_robot(picture::SolidScene& scene, const hal::JointVector& q_rad) {
  const auto robot = picture::robot_solids(hal::built_in_robot(), q_rad, hal::coupled_posture(1.2));
  scene.solids.insert(scene.solids.end(), robot.begin(), robot.end());
}

hal::Timestamp at(double t_s) {
  return std::chrono::milliseconds(static_cast<int>(std::lround(1e3 * t_s)));
}

// 0 before `from`, 1 after `to`, smooth between.
double ramp(double t, double from, double to) {
  const double x = std::clamp((t - from) / (to - from), 0.0, 1.0);
  return x * x * (3 - 2 * x);
}

RunExample look_at_table() {
  RunExample e;
  e.setting.scenario = "table.yaml";
  e.setting.robot = "simulated rig";
  e.setting.seed = 7;
  e.setting.share = 0.5;
  e.setting.command = "colift run --seed 7 --share 0.5 --report 'lift <1> & more.html'";
  e.setting.X_WC = sim_hal::look_at({-0.2, -1.5, 1.4}, {0.7, 0, 0.3});
  e.setting.model = &hal::built_in_robot();
  e.setting.config = {{"task.hold_s", "--set"}};
  const control::Config config;
  const planner::HandModel hand;
  const hal::ManualClock clock;
  e.record.analysis =
      control::analyse_scene({frame_of(world(0), e.setting.X_WC, 1, 0.5), e.setting.X_WC, true, {}},
                             control::Method::Fast, config, hand, clock)
          .value();
  e.record.states = {{at(0.0), Task::Observe, "the run began"},
                     {at(0.6), Task::AwaitPartner, "an object to carry and feasible grasps were found"}};
  e.record.timing.sim_s = 30.6;
  e.record.timing.wall_s = 3.2;
  e.truth.mass_kg = kMass;
  e.truth.cog = at_table(0, 0, 0.35);
  return e;
}

// looked at once for all tests
const RunExample& seen_run() {
  static const RunExample seen = look_at_table();
  return seen;
}

}  // namespace

RunExample refused_run() {
  RunExample e = seen_run();
  e.record.outcome = control::RunRecord::Result::Refused;
  e.record.reason = "no partner grasped the object within 30 s";
  e.record.states.push_back({at(30.6), Task::Refused, e.record.reason});
  return e;
}

namespace {

RunExample lift_table() {
  RunExample e = seen_run();
  control::RunRecord& r = e.record;
  control::Config config;
  config.decision.weights.epsilon = planner::epsilon_for_share(0.5).value();
  const hal::ManualClock clock;
  r.frame_partner = frame_of(with_person(0), e.setting.X_WC, 2, 3.9);
  r.decision = control::decide(*r.analysis, {std::nullopt, r.frame_partner}, config, clock).value();
  r.outcome = control::RunRecord::Result::Lifted;
  r.reason = "held 5.0 cm for 2.0 s, lowered, released";
  r.plan = planner::MotionPlan{};
  r.plan->reach.grasp_rad << 0.2, 0.9, 0.0, -1.4, 0.0, 0.6, 0.0;
  r.plan->reach.lifted_rad << 0.2, 0.85, 0.0, -1.4, 0.0, 0.65, 0.0;
  r.plan->plan_ms = 2.1;
  r.plan->shortcut_ms = 3.4;
  r.plan->exact_ms = 8.8;
  const auto enter = [&](double t, Task state, const char* reason) {
    r.states.push_back({at(t), state, reason});
  };
  enter(3.9, Task::Decide, "the partner grasps the object");
  enter(4.0, Task::Plan, "a reachable grasp is chosen");
  enter(4.0, Task::Approach, "collision-free path to the grasp found");
  enter(9.4, Task::Close, "hand at the grasp");
  enter(10.8, Task::Verify, "every finger is in contact");
  enter(11.2, Task::AwaitReady, "the grip has the planned width and force");
  enter(11.7, Task::Lift, "the partner holds and is at rest");
  enter(13.7, Task::Hold, "target height reached");
  enter(15.7, Task::Lower, "held for as long as was asked");
  enter(17.9, Task::Release, "the object stands on the ground");
  enter(19.0, Task::Retreat, "the hand is open");
  enter(24.2, Task::Done, "back home");
  for (int i = 0; i < 300; ++i) {
    const double t = 9.4 + i / 30.0;
    const double up = ramp(t, 11.7, 13.7) - ramp(t, 15.7, 17.7);
    const double air = ramp(t, 11.7, 12.1) - ramp(t, 17.3, 17.7);
    const double wave = std::sin(9 * t);
    control::LiftSample s;
    s.t_s = t;
    for (const auto& change : r.states)
      if (hal::seconds(change.at) <= t) s.state = change.state;
    s.palm_height_m = 0.05 * up;
    s.object_rise_m = i % 50 == 3 ? std::numeric_limits<double>::quiet_NaN() : 0.0497 * up + 4e-4 * wave;
    s.tilt_rad = 0.009 * up + 1e-3 * std::abs(wave);
    s.slip_m = 0.001 * ramp(t, 11.9, 12.6) + 1e-4 * wave;
    s.load_n = 19.4 * air + 0.5 * wave * air + 0.1 * wave;
    r.curve.push_back(s);
    e.truth.curve.push_back({t, 19.2 * air, 20.04 * air, kMass * kGravity * (1 - air), 0.0085 * up,
                             0.0492 * up, 0.0008 * ramp(t, 11.9, 12.6)});
  }
  control::LoadEstimate load;
  load.mass_kg = 4.04;
  load.mass_95 = {3.6, 4.5};
  load.share_robot = 0.49;
  load.share_95 = {0.44, 0.55};
  load.cog = r.analysis->scene.target->cog;
  load.cog_sigma_m = 0.02;
  r.lift.emplace();
  r.lift->height_m = 0.0497;
  r.lift->tilt_rad = 0.0094;
  r.lift->share_robot = load.share_robot;
  r.lift->share_predicted = r.decision->decision.share;
  r.lift->slip_m = 0.001;
  r.lift->mass_kg = load.mass_kg;
  r.lift->load = load;
  r.frame_lifted = frame_of(with_person(0.05), e.setting.X_WC, 3, 14.7);
  r.timing = {0.12, 4.1, 14.3, 24.2, 3.2};
  e.truth.partner = kContact;
  e.scenes.before = solids(with_person(0));
  e.scenes.lifted = solids(with_person(0.05));
  add_robot(*e.scenes.before, r.plan->reach.grasp_rad);
  add_robot(*e.scenes.lifted, r.plan->reach.lifted_rad);
  return e;
}

}  // namespace

RunExample lifted_run() {
  static const RunExample lifted = lift_table();
  return lifted;
}

RunExample stopped_run() {
  RunExample e = lifted_run();
  control::RunRecord& r = e.record;
  r.outcome = control::RunRecord::Result::Aborted;
  r.reason = "the partner let go while the object was carried; holds, the grip stays closed";
  std::erase_if(r.states, [](const auto& s) { return s.at > at(12.5); });
  r.states.push_back({at(12.9), Task::Stopped, r.reason});
  r.lift.reset();
  r.hand_keeps_grip = true;
  r.faults = {{at(6.0), "camera", "no picture for 0.4 s"},
              {at(12.2), "hand", "an answer with a bad \"length\" <8>"}};
  std::erase_if(r.curve, [](const auto& s) { return s.t_s > 13.5; });
  return e;
}

}  // namespace colift::tests
