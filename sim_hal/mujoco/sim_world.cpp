#include "sim_hal/mujoco/sim_world.hpp"

#include <algorithm>
#include <utility>

#include "sim_hal/mujoco/engine/mjcf.hpp"
#include "sim_hal/mujoco/sim_world_impl.hpp"
#include "sim_hal/mujoco/start_checks.hpp"

namespace colift::sim_hal {

hal::JointVector SimConfig::home_rad() {
  // elbow up and behind, hand in front of the base, half way between forwards and down, all joints bent
  hal::JointVector q;
  q << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0;
  return q;
}

SimWorld::SimWorld(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SimWorld::~SimWorld() = default;

hal::Result<std::unique_ptr<SimWorld>> SimWorld::make(const Scenario& scenario, const hal::RobotModel& model,
                                                      std::uint64_t seed, const SimConfig& config) {
  auto object = object_parts(scenario.object);
  if (!object) return tl::unexpected(object.error());
  if (auto done = check_grasps(scenario.partner, *object); !done) return tl::unexpected(done.error());
  std::optional<SupportBlock> support;
  if (scenario.partner.kind == "support") support = support_block(scenario, *object);
  auto physics = Physics::make(mjcf(scenario, model, *object, support), model, config.start_rad);
  if (!physics) return tl::unexpected(physics.error());
  if (auto done = check_overlap((*physics)->overlap()); !done) return tl::unexpected(done.error());
  std::unique_ptr<Impl> impl(new Impl{
      .scenario = scenario,
      .model = model,
      .object = std::move(*object),
      .config = config,
      .seed = seed,
      .physics = std::move(*physics),
      .arm = ArmControl(config.start_rad, model.effort_nm()),
      .hand = {},
      .partner = SimPartner(scenario.partner, scenario.task, seed),
      .support = support,
      .clutter = clutter_shapes(scenario),
      .people = SimPeople(scenario, model),
      .clutter_moves = std::any_of(scenario.clutter.begin(), scenario.clutter.end(),
                                   [](const ScenarioClutter& c) { return !c.moves.empty(); }),
  });
  impl->X_WT0 = impl->physics->object_pose();
  if (auto done = impl->people.check_start(*impl->physics, impl->object_shapes(impl->X_WT0)); !done)
    return tl::unexpected(done.error());
  impl->physics->read(impl->arm_reading, impl->hand_reading);
  impl->place_partners();
  return std::unique_ptr<SimWorld>(new SimWorld(std::move(impl)));
}

const hal::Clock& SimWorld::clock() const {
  return impl_->clock;
}

void SimWorld::start_at(hal::Timestamp now) {
  impl_->start = now.count();
  impl_->clock.set(now);
}

void SimWorld::begin_scenario() {
  impl_->start = impl_->clock.now().count();
}

hal::Duration SimWorld::elapsed() const {
  return impl_->clock.now() - hal::Timestamp(impl_->start.load());
}

void SimWorld::advance(hal::Duration by) {
  for (auto ticks = by / kTick; ticks > 0; --ticks) {
    const std::scoped_lock lock(impl_->mutex);
    impl_->tick();
  }
}

bool SimWorld::take_lower_confirmed() {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->partner.take_lower_confirmed();
}

bool SimWorld::take_continue_confirmed() {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->partner.take_continue_confirmed();
}

bool SimWorld::ask_partner(const std::optional<Vec3>& grasp_W, const std::optional<Vec3>& aside_W) {
  const std::scoped_lock lock(impl_->mutex);
  if (aside_W) return impl_->partner_steps_aside(*aside_W);
  if (!grasp_W) return false;
  const Vec3 place_T = impl_->physics->object_pose().inverse() * *grasp_W;
  if (!on_surface(impl_->object, place_T)) return false;
  if (!impl_->partner.ask(place_T, impl_->now_s())) return false;
  impl_->place_partners();
  return true;
}

void SimWorld::take_object() {
  const std::scoped_lock lock(impl_->mutex);
  if (!impl_->helpers.hold()) impl_->helpers.take(impl_->physics->object_pose(), impl_->palm().translation());
}

void SimWorld::pull_object_away(double by_m) {
  take_object();
  const std::scoped_lock lock(impl_->mutex);
  Vec3 away_W = impl_->palm().linear().col(2);
  away_W.z() = 0.0;
  impl_->helpers.pull(by_m * away_W);
}

void SimWorld::task_state(const std::string& name) {
  const std::scoped_lock lock(impl_->mutex);
  if (std::find(impl_->entered.begin(), impl_->entered.end(), name) != impl_->entered.end()) return;
  impl_->entered.push_back(name);
  impl_->partner.task_state(name, impl_->now_s());
  impl_->people.task_state(name, impl_->now_s());
  for (DeviceFaultEvent& fault : impl_->scenario.faults) {
    if (fault.in_state != name) continue;
    fault.in_state.clear();
    fault.at_s += impl_->now_s();
  }
}

void SimWorld::end_faults() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->scenario.faults.clear();
}

SimTruth SimWorld::truth() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->truth();
}

std::vector<BodyContact> SimWorld::body_contacts() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->people.contacts();
}

double SimWorld::people_distance_m() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->people.distance_m();
}

double SimWorld::partner_distance_m() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->people.partner_distance_m();
}

void SimWorld::observe(std::function<void(const TickReport&)> observer) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->observer = std::move(observer);
}

hal::ArmState SimWorld::arm_state() const {
  const std::scoped_lock lock(impl_->mutex);
  hal::ArmState state;
  state.measured_at = impl_->clock.now();
  state.q_rad = impl_->arm_reading.q_rad;
  state.q_commanded_rad = impl_->arm.set_point_rad();
  state.tau_nm = impl_->arm.torque_nm();
  state.tau_external_nm = impl_->external_nm;
  return state;
}

void SimWorld::command_arm(const hal::ImpedanceCommand& command) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->command_rad = command.q_rad;
  impl_->commanded = true;
  impl_->arm.command(command, static_cast<int>(impl_->config.arm_period / kTick));
}

void SimWorld::hold_arm() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->arm.hold();
}

hal::HandState SimWorld::hand_state() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->hand_state();
}

void SimWorld::preshape_hand(double spread_rad) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->hand.preshape(spread_rad);
}

void SimWorld::close_hand(double torque_nm) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->hand.close(torque_nm);
}

void SimWorld::close_hand(const std::array<double, hal::kFingers>& torque_nm) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->hand.close(torque_nm);
}

void SimWorld::open_hand() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->hand.open();
}

void SimWorld::open_hand(const std::array<bool, hal::kFingers>& which) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->hand.open(which);
}

void SimWorld::stop_hand() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->hand.stop();
}

void SimWorld::power_hand(bool on) {
  const std::scoped_lock lock(impl_->mutex);
  impl_->hand.power(on);
}

bool SimWorld::hand_worms_turn() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->hand.turns();
}

World SimWorld::shapes() const {
  const std::scoped_lock lock(impl_->mutex);
  World world;
  world.shapes = impl_->object_shapes(impl_->physics->object_pose());
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  world.shapes.insert(world.shapes.end(), impl_->clutter.begin(), impl_->clutter.end());
  for (int link = 0; link < static_cast<int>(impl_->model.links.size()); ++link) {
    const Pose X_WL = impl_->physics->link_pose(link);
    for (const hal::LinkShape& s : impl_->model.links[static_cast<std::size_t>(link)].shapes)
      world.shapes.push_back(link_shape(s, X_WL));
  }
  impl_->people.add_to(world);
  // a block under the object is felt and not seen: it stands for the person who is drawn holding it
  for (Shape& part : impl_->partner_figure().parts) {
    part.X_WS.translation() += impl_->people.partner_offset(part);
    world.shapes.push_back(part);
  }
  return world;
}

const Scenario& SimWorld::scenario() const {
  return impl_->scenario;
}

const SimConfig& SimWorld::config() const {
  return impl_->config;
}

const hal::RobotModel& SimWorld::model() const {
  return impl_->model;
}

std::uint64_t SimWorld::seed() const {
  return impl_->seed;
}

}  // namespace colift::sim_hal
