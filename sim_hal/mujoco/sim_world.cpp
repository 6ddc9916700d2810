#include "sim_hal/mujoco/sim_world.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>

#include "hal/os/inheriting_mutex.hpp"
#include "sim_hal/mujoco/arm_control.hpp"
#include "sim_hal/mujoco/mjcf.hpp"
#include "sim_hal/mujoco/physics.hpp"
#include "sim_hal/mujoco/sim_partner.hpp"
#include "sim_hal/mujoco/sim_people.hpp"
#include "sim_hal/mujoco/sim_person.hpp"
#include "sim_hal/mujoco/start_checks.hpp"
#include "sim_hal/mujoco/support_block.hpp"

namespace colift::sim_hal {
namespace {

constexpr hal::Duration kTick = std::chrono::milliseconds(1);
constexpr double kTick_s = 0.001;
constexpr double kObserver_s = 0.005;  // time constant of the external torque's observer

/// The object's pieces where it stands, for the camera and for people.
std::vector<Shape> placed_parts(const ObjectParts& object, const Pose& X_WT) {
  std::vector<Shape> shapes;
  for (const ObjectParts::Part& part : object.parts) {
    Shape s = part.shape;
    s.X_WS = X_WT * s.X_WS;
    s.label = Label::Target;
    shapes.push_back(s);
  }
  return shapes;
}

double tilt(const Pose& X_WT0, const Pose& X_WT, bool may_roll) {
  if (!may_roll) {
    const double upright = X_WT.linear().col(2).dot(X_WT0.linear().col(2));
    return std::acos(std::clamp(upright, -1.0, 1.0));
  }
  const auto rise = [](const Pose& X) { return std::asin(std::clamp(X.linear()(2, 0), -1.0, 1.0)); };
  return std::abs(rise(X_WT) - rise(X_WT0));
}

}  // namespace

hal::JointVector SimConfig::home_rad() {
  // elbow up and behind, hand in front of the base, half way between forwards and down, all joints bent
  hal::JointVector q;
  q << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0;
  return q;
}

/// Moved by one thread, read by others.
class WorldClock final : public hal::Clock {
 public:
  [[nodiscard]] hal::Timestamp now() const override { return hal::Timestamp(now_.load()); }
  void set(hal::Timestamp now) { now_ = now.count(); }
  void advance(hal::Duration by) { now_.fetch_add(by.count()); }

 private:
  std::atomic<hal::Timestamp::rep> now_{0};
};

struct SimWorld::Impl {
  hal::InheritingMutex mutex = {};  // of everything below; the clock is read without it
  Scenario scenario;
  hal::RobotModel model;
  ObjectParts object;
  SimConfig config;
  std::uint64_t seed;
  std::unique_ptr<Physics> physics;
  ArmControl arm;
  HandDrive hand;
  SimPartner partner;
  std::optional<SupportBlock> support;
  bool support_stands = false;
  WorldClock clock = {};
  std::atomic<hal::Timestamp::rep> start{0};
  std::vector<PartnerFigure> figures = {};  // one for each of the partner's holds
  std::vector<Shape> clutter;
  SimPeople people;
  bool clutter_moves = false;

  ArmReading arm_reading = {};
  HandReading hand_reading = {};
  hal::JointVector external_nm = hal::JointVector::Zero();
  std::optional<SimPartner::Action> partner_action = {};
  Pose X_WT0 = Pose::Identity();

  // the grasp: which one counts, where its middle lies, and how the object lay in the palm
  int grasp = 0;
  Vec3 grip_T = Vec3::Zero();
  std::optional<Vec3> robot_T = {};  // the last grasp that had the object
  Pose X_HT_locked = Pose::Identity();

  void tick();
  void push();
  void note_grasp();
  [[nodiscard]] Pose palm() const { return physics->link_pose(model.palm); }
  [[nodiscard]] double now_s() const { return hal::seconds(clock.now() - hal::Timestamp(start.load())); }
  void place_partners();
  void move_clutter();
  [[nodiscard]] std::vector<Shape> object_shapes() const;
};

void SimWorld::Impl::tick() {
  external_nm += kTick_s / kObserver_s * (arm_reading.external_nm - external_nm);

  PartnerView view{now_s(), physics->object_pose(), physics->object_velocity_W(), physics->object_turning_W(),
                   robot_T};
  partner_action = partner.tick(view);
  if (partner_action) {
    physics->set_object_load(partner_action->at_W, partner_action->force_W, partner_action->torque_W);
  } else {
    physics->set_object_load(view.X_WT.translation(), Vec3::Zero(), Vec3::Zero());
  }
  if (support && !support_stands && now_s() >= scenario.partner.arrives_s) {
    physics->place_support(support->center_W);
    support_stands = true;
  }
  move_clutter();
  if (!people.empty()) people.tick(now_s(), *physics, object_shapes(), clutter);
  push();
  physics->set_torque(
      arm.tick(arm_reading.q_rad, arm_reading.dq_rad_s, arm_reading.bias_nm, arm_reading.inertia),
      hand.tick(hand_reading));
  physics->step();
  physics->read(arm_reading, hand_reading);
  clock.advance(kTick);
  note_grasp();
}

// somebody pushes arm or hand, as the scenario says
void SimWorld::Impl::push() {
  for (const DeviceFaultEvent& event : scenario.faults) {
    if (event.action != "push" || now_s() < event.at_s || now_s() >= event.at_s + event.for_s) continue;
    const int link = event.link == 0 ? model.palm : model.arm[static_cast<std::size_t>(event.link - 1)];
    physics->pull_link(link, event.value.value_or(0.0) * event.direction.normalized());
  }
}

void SimWorld::Impl::note_grasp() {
  if (hand.grasps() == grasp) return;
  grasp = hand.grasps();
  const Pose X_WT = physics->object_pose();
  grip_T = X_WT.inverse() * physics->contacts().grip_W.value_or(palm().translation());
  if (physics->contacts().robot_touches_object) robot_T = grip_T;
  X_HT_locked = palm().inverse() * X_WT;
}

std::vector<Shape> SimWorld::Impl::object_shapes() const {
  return placed_parts(object, physics->object_pose());
}

void SimWorld::Impl::move_clutter() {
  if (!clutter_moves) return;
  clutter = clutter_shapes(scenario, now_s());
  for (std::size_t i = 0; i < clutter.size(); ++i)
    if (!scenario.clutter[i].moves.empty()) physics->place_clutter(i, clutter[i].X_WS.translation());
}

void SimWorld::Impl::place_partners() {
  World around;
  around.shapes = placed_parts(object, X_WT0);
  around.shapes.insert(around.shapes.end(), clutter.begin(), clutter.end());
  const Vec3 middle_W = X_WT0 * object.cog_T;
  figures.clear();
  for (const PartnerHold& hold : partner.holds()) {
    const Vec3 contact_W = X_WT0 * hold.grasp_T;
    figures.push_back(place_partner(around, contact_W, contact_W - middle_W));
  }
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
  if (auto done = impl->people.check_start(*impl->physics, impl->object_shapes()); !done)
    return tl::unexpected(done.error());
  impl->X_WT0 = impl->physics->object_pose();
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

bool SimWorld::ask_partner(const Vec3& place_W) {
  const std::scoped_lock lock(impl_->mutex);
  const Vec3 place_T = impl_->physics->object_pose().inverse() * place_W;
  if (!on_surface(impl_->object, place_T)) return false;
  if (!impl_->partner.ask(place_T, impl_->now_s())) return false;
  impl_->place_partners();
  return true;
}

SimTruth SimWorld::truth() const {
  const std::scoped_lock lock(impl_->mutex);
  const Physics& physics = *impl_->physics;
  const ContactReading& contacts = physics.contacts();
  SimTruth truth;
  truth.at = impl_->clock.now();
  truth.X_WT = physics.object_pose();
  truth.mass_kg = impl_->object.mass_kg;
  truth.cog_W = truth.X_WT * impl_->object.cog_T;
  truth.tilt_rad = tilt(impl_->X_WT0, truth.X_WT, impl_->scenario.object.kind == "cylinder");
  truth.height_m = truth.cog_W.z() - (impl_->X_WT0 * impl_->object.cog_T).z();
  truth.robot_force_W = contacts.robot_force_W;
  truth.robot_torque_W = contacts.robot_torque_W;
  truth.floor_force_W = contacts.static_force_W;
  if (impl_->support_stands) {
    truth.partner_force_W = contacts.support_force_W;
    truth.partner_W = truth.X_WT * impl_->scenario.partner.grasp;
  } else if (impl_->partner_action) {
    truth.partner_force_W = impl_->partner_action->force_W;
    truth.partner_W = impl_->partner_action->at_W;
  }
  if (impl_->hand.held()) {
    const Vec3 p_H = impl_->palm().inverse() * (truth.X_WT * impl_->grip_T);
    truth.slip_m = (p_H - impl_->X_HT_locked * impl_->grip_T).norm();
  }
  truth.robot_touches_object = contacts.robot_touches_object;
  truth.robot_hit_something = contacts.robot_hit;
  truth.q_rad = impl_->arm_reading.q_rad;
  truth.troubles = physics.troubles();
  return truth;
}

std::vector<BodyContact> SimWorld::body_contacts() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->people.contacts();
}

double SimWorld::people_distance_m() const {
  const std::scoped_lock lock(impl_->mutex);
  return impl_->people.distance_m();
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
  impl_->arm.command(command, static_cast<int>(impl_->config.arm_period / kTick));
}

void SimWorld::hold_arm() {
  const std::scoped_lock lock(impl_->mutex);
  impl_->arm.hold();
}

hal::HandState SimWorld::hand_state() const {
  const std::scoped_lock lock(impl_->mutex);
  const HandReading& reading = impl_->hand_reading;
  hal::HandState state;
  state.measured_at = impl_->clock.now();
  state.finger_rad = reading.inner_rad;
  state.outer_rad = reading.outer_rad;
  state.spread_rad = 0.5 * (reading.spread_rad[0] + reading.spread_rad[1]);
  state.torque_nm = reading.strain_nm;
  state.tip_force_n = reading.tip_force_n;
  state.moving = impl_->hand.moving();
  state.held = impl_->hand.held();
  return state;
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

World SimWorld::shapes() const {
  const std::scoped_lock lock(impl_->mutex);
  World world;
  const Pose X_WT = impl_->physics->object_pose();
  world.shapes = placed_parts(impl_->object, X_WT);
  world.shapes.push_back(half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground));
  world.shapes.insert(world.shapes.end(), impl_->clutter.begin(), impl_->clutter.end());
  for (int link = 0; link < static_cast<int>(impl_->model.links.size()); ++link) {
    const Pose X_WL = impl_->physics->link_pose(link);
    for (const hal::LinkShape& s : impl_->model.links[static_cast<std::size_t>(link)].shapes)
      world.shapes.push_back(link_shape(s, X_WL));
  }
  impl_->people.add_to(world);
  // a block under the object is felt and not seen: it stands for the person who is drawn holding it
  const double t = impl_->now_s();
  if (const PartnerHold* hold = impl_->partner.hold_to_show(t); hold && !impl_->figures.empty()) {
    const auto index = static_cast<std::size_t>(hold - impl_->partner.holds().data());
    PartnerFigure figure = impl_->figures[index];
    figure.contact_W = X_WT * hold->grasp_T;
    std::optional<double> since_let_go;
    if (hold->until_s) since_let_go = t - *hold->until_s;
    figure.presence = presence_at(t - hold->from_s, since_let_go);
    add_partner(world, figure);
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
