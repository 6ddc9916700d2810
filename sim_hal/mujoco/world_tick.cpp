#include <algorithm>
#include <cmath>
#include <utility>

#include "sim_hal/mujoco/sim_world_impl.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kStepAside_s = 1.0;   // until somebody who is asked to is there
constexpr double kObserver_s = 0.005;  // time constant of the external torque's observer

double tilt(const Pose& X_WT0, const Pose& X_WT, bool may_roll) {
  if (!may_roll) {
    const double upright = X_WT.linear().col(2).dot(X_WT0.linear().col(2));
    return std::acos(std::clamp(upright, -1.0, 1.0));
  }
  const auto rise = [](const Pose& X) { return std::asin(std::clamp(X.linear()(2, 0), -1.0, 1.0)); };
  return std::abs(rise(X_WT) - rise(X_WT0));
}

}  // namespace

void SimWorld::Impl::tick() {
  external_nm += kTick_s / kObserver_s * (arm_reading.external_nm - external_nm);

  PartnerView view{now_s(), physics->object_pose(), physics->object_velocity_W(), physics->object_turning_W(),
                   robot_T};
  partner_action = partner.tick(view);
  if (figures.size() < partner.holds().size()) place_partners();
  if (partner_action) {
    physics->set_object_load(partner_action->at_W, partner_action->force_W, partner_action->torque_W);
  } else {
    physics->set_object_load(view.X_WT.translation(), Vec3::Zero(), Vec3::Zero());
  }
  if (helpers.hold())
    for (const SimHelpers::Hand& hand :
         helpers.tick(view.X_WT, view.v_W, view.w_W, physics->contacts().robot_force_W,
                      physics->contacts().robot_torque_W))
      physics->push_object(hand.at_W, hand.force_W);
  if (support && !support_stands && now_s() >= scenario.partner.arrives_s) {
    physics->place_support(support->center_W);
    support_stands = true;
  }
  move_clutter();
  people.tick(
      now_s(), *physics, [&] { return object_shapes(physics->object_pose()); }, clutter,
      [&] { return partner_figure(); });
  push();
  physics->set_torque(
      arm.tick(arm_reading.q_rad, arm_reading.dq_rad_s, arm_reading.bias_nm, arm_reading.inertia),
      hand.tick(hand_reading));
  physics->step();
  physics->read(arm_reading, hand_reading);
  clock.advance(kTick);
  note_grasp();
  if (observer) report();
}

// somebody pushes arm or hand, as the scenario says
void SimWorld::Impl::push() {
  for (const DeviceFaultEvent& event : scenario.faults) {
    if (event.action != "push" || !event.active(now_s())) continue;
    const int link = event.link == 0 ? model.palm : model.arm[static_cast<std::size_t>(event.link - 1)];
    physics->pull_link(link, event.value.value_or(0.0) * event.direction.normalized());
  }
}

bool SimWorld::Impl::pushed() const {
  return std::any_of(scenario.faults.begin(), scenario.faults.end(), [&](const DeviceFaultEvent& event) {
    return event.action == "push" && event.active(now_s());
  });
}

void SimWorld::Impl::report() {
  const SimTruth now = truth();
  const hal::HandState fingers = hand_state();
  observer({now_s(), now, people.contacts(), people.distance_m(), people.partner_distance_m(), command_rad,
            std::exchange(commanded, false), arm.set_point_rad(), arm_reading.dq_rad_s, arm.active(), fingers,
            pushed()});
}

void SimWorld::Impl::note_grasp() {
  if (hand.grasps() == grasp) return;
  grasp = hand.grasps();
  const Pose X_WT = physics->object_pose();
  grip_T = X_WT.inverse() * physics->contacts().grip_W.value_or(palm().translation());
  if (physics->contacts().robot_touches_object) robot_T = grip_T;
  X_HT_locked = palm().inverse() * X_WT;
}

std::vector<Shape> SimWorld::Impl::object_shapes(const Pose& X_WT) const {
  std::vector<Shape> shapes;
  for (const ObjectParts::Part& part : object.parts) {
    Shape s = part.shape;
    s.X_WS = X_WT * s.X_WS;
    s.label = Label::Target;
    shapes.push_back(s);
  }
  return shapes;
}

void SimWorld::Impl::move_clutter() {
  if (!clutter_moves) return;
  clutter = clutter_shapes(scenario, now_s());
  for (std::size_t i = 0; i < clutter.size(); ++i)
    if (!scenario.clutter[i].moves.empty()) physics->place_clutter(i, clutter[i].X_WS.translation());
}

World SimWorld::Impl::around_partner() const {
  World around;
  around.shapes = object_shapes(X_WT0);
  around.shapes.insert(around.shapes.end(), clutter.begin(), clutter.end());
  // nor does he stand in the arm
  for (int link = 0; link < static_cast<int>(model.links.size()); ++link)
    for (const hal::LinkShape& shape : model.links[static_cast<std::size_t>(link)].shapes)
      around.shapes.push_back(link_shape(shape, physics->link_pose(link)));
  return around;
}

void SimWorld::Impl::place_partners() {
  const World around = around_partner();
  const Vec3 middle_W = X_WT0 * object.cog_T;
  figures.clear();
  for (const PartnerHold& hold : partner.holds()) {
    const Vec3 contact_W = X_WT0 * hold.grasp_T;
    figures.push_back(place_partner(around, contact_W, contact_W - middle_W));
  }
  aside.resize(figures.size());
}

// his hand stays where it is
bool SimWorld::Impl::partner_steps_aside(const Vec3& direction_W) {
  const PartnerHold* hold = partner.hold_to_show(now_s());
  if (!scenario.partner.obliging || hold == nullptr || figures.empty()) return false;
  const auto index = static_cast<std::size_t>(hold - partner.holds().data());
  const auto shoulder_W = step_aside(around_partner(), figures[index], direction_W);
  if (!shoulder_W) return false;
  aside[index] = Aside{*shoulder_W, now_s() + SimPartner::kHears_s};
  return true;
}

SimTruth SimWorld::Impl::truth() const {
  const ContactReading& contacts = physics->contacts();
  SimTruth truth;
  truth.at = clock.now();
  truth.X_WT = physics->object_pose();
  truth.mass_kg = object.mass_kg;
  truth.cog_W = truth.X_WT * object.cog_T;
  truth.tilt_rad = tilt(X_WT0, truth.X_WT, scenario.object.kind == "cylinder");
  truth.height_m = truth.cog_W.z() - (X_WT0 * object.cog_T).z();
  truth.robot_force_W = contacts.robot_force_W;
  truth.robot_torque_W = contacts.robot_torque_W;
  truth.floor_force_W = contacts.static_force_W;
  if (support_stands) {
    truth.partner_force_W = contacts.support_force_W;
    truth.partner_W = truth.X_WT * scenario.partner.grasp;
  } else if (partner_action) {
    truth.partner_force_W = partner_action->force_W;
    truth.partner_W = partner_action->at_W;
  }
  if (hand.held()) {
    const Vec3 p_H = palm().inverse() * (truth.X_WT * grip_T);
    truth.slip_m = (p_H - X_HT_locked * grip_T).norm();
  }
  truth.robot_touches_object = contacts.robot_touches_object;
  truth.robot_hit_something = contacts.robot_hit;
  truth.q_rad = arm_reading.q_rad;
  truth.divergences = physics->divergences();
  return truth;
}

hal::HandState SimWorld::Impl::hand_state() const {
  const HandReading& reading = hand_reading;
  hal::HandState state;
  state.measured_at = clock.now();
  state.finger_rad = reading.inner_rad;
  state.outer_rad = reading.outer_rad;
  state.spread_rad = 0.5 * (reading.spread_rad[0] + reading.spread_rad[1]);
  state.torque_nm = reading.strain_nm;
  state.tip_force_n = reading.tip_force_n;
  state.moving = hand.moving();
  state.held = hand.held();
  return state;
}

// as he is drawn, but for what pushes him
SimPeople::Figure SimWorld::Impl::partner_figure() const {
  SimPeople::Figure out;
  const double t = now_s();
  const PartnerHold* hold = partner.hold_to_show(t);
  if (hold == nullptr || figures.empty()) return out;
  const auto index = static_cast<std::size_t>(hold - partner.holds().data());
  PartnerFigure figure = figures[index];
  figure.contact_W = physics->object_pose() * hold->grasp_T;
  if (const auto& stepped = aside[index]; stepped && figure.shoulder_W) {
    const double there = std::clamp((t - stepped->from_s) / kStepAside_s, 0.0, 1.0);
    figure.shoulder_W = turned(*figure.shoulder_W, stepped->shoulder_W, there);
  }
  std::optional<double> since_let_go;
  if (hold->until_s) since_let_go = t - *hold->until_s;
  figure.presence = presence_at(t - hold->from_s, since_let_go, hold->leaves);
  if (const auto second_T = partner.second_hand(t)) figure.second_W = physics->object_pose() * *second_T;
  if (!(figure.presence > 0.0)) return out;
  World world;
  world.shapes = object_shapes(physics->object_pose());  // they decide how the hand grips
  const std::size_t first = world.shapes.size();
  add_partner(world, figure);
  out.parts.assign(world.shapes.begin() + static_cast<std::ptrdiff_t>(first), world.shapes.end());
  if (figure.shoulder_W) {
    const Vec3 away(figure.shoulder_W->x(), figure.shoulder_W->y(), 0.0);
    if (away.norm() > 0.0) out.facing_W = -away.normalized();
  }
  return out;
}

}  // namespace colift::sim_hal
