#include "sim_hal/mujoco/sim_people.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sim_hal/people/touch.hpp"

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001;
constexpr double kFriction = 0.5, kRub_ns_m = 30.0;  // of skin and cloth; slope below the limit of friction
constexpr double kMerged_m = 0.05;                   // contacts so near and alike count once
constexpr double kDisplaced_m = 0.001;               // of a group that meets the floor and the clutter
constexpr double kWalkBlocked_m = 0.05, kReachBlocked_m = 0.03;
constexpr double kBetweenFingers_m = 0.07;  // out of the palm

constexpr double kNear_m = 0.10, kFastest_m_s = 4.0;  // nearer than that everybody is looked at in every tick
constexpr int kMaxRest_ms = 10;

Vec3 velocity_at(const Shape& now, const Shape& before, double along) {
  const auto at = [&](const Shape& s) {
    return Vec3(s.X_WS.translation() + (along - 0.5) * s.size[1] * s.X_WS.linear().col(2));
  };
  return (at(now) - at(before)) / kTick_s;
}

}  // namespace

/// A part of a body against one solid.
struct SimPeople::Touch {
  Nearest nearest;
  std::size_t part = 0;
  const Solid* solid = nullptr;
  Vec3 out_W = Vec3::Zero();  // of the solid
};

SimPeople::SimPeople(const Scenario& scenario, const hal::RobotModel& model) : model_(model) {
  for (const ScenarioPerson& script : scenario.people) people_.push_back({ScriptedPerson(script)});
  for (const hal::RobotLink& link : model_.links)  // a parent comes before its children
    fixed_.push_back(!link.revolute && (link.parent < 0 || fixed_[static_cast<std::size_t>(link.parent)]));
}

void SimPeople::read_solids(const Physics& physics, const std::vector<Shape>& object,
                            const std::vector<Shape>& clutter) {
  solids_.clear();
  for (int link = 0; link < static_cast<int>(model_.links.size()); ++link) {
    const Pose X_WL = physics.link_pose(link);
    const auto index = static_cast<std::size_t>(link);
    for (const hal::LinkShape& s : model_.links[index].shapes)
      solids_.push_back({link_shape(s, X_WL), BodyContact::By::Robot, link, fixed_[index]});
  }
  for (const Shape& s : object) solids_.push_back({s, BodyContact::By::Object});
  for (const Shape& s : clutter) solids_.push_back({s, BodyContact::By::Static});
  solids_.push_back({half_space(Vec3::Zero(), Vec3::UnitZ(), Label::Ground), BodyContact::By::Static});
  for (Solid& solid : solids_) solid.radius_m = bounding_radius(solid.shape);
}

hal::Result<> SimPeople::check_start(const Physics& physics, const std::vector<Shape>& object) const {
  for (std::size_t i = 0; i < people_.size(); ++i) {
    ScriptedPerson first = *people_[i].script;
    first.enter_now();
    PersonView view;
    view.object = &object;
    first.tick(0.0, view, true, true);
    World body;
    first.add_to(body);
    for (int link = 0; link < static_cast<int>(model_.links.size()); ++link) {
      const Pose X_WL = physics.link_pose(link);
      for (const hal::LinkShape& s : model_.links[static_cast<std::size_t>(link)].shapes)
        for (const Shape& part : body.shapes) {
          const double depth = -nearest(as_capsule(part), link_shape(s, X_WL)).distance_m;
          if (depth > 0.0)
            return hal::failure(
                hal::ErrorCode::BadConfig, fmt::format("people[{}].path", i),
                fmt::format("begins {:.3f} m inside the robot, expected a free place", depth));
        }
    }
  }
  return {};
}

void SimPeople::move(Person& person, double t_s, const PersonView& view) const {
  const SoftBody& body = person.body;
  const auto off = [&](BodyPart part, bool left) {
    Shape s;
    s.part = part;
    s.left = left;
    return body.offset(group_of(s)).norm();
  };
  bool walk_blocked = off(BodyPart::Trunk, false) > kWalkBlocked_m;
  for (const BodyPart part : {BodyPart::Thigh, BodyPart::LowerLeg, BodyPart::Foot})
    for (const bool left : {false, true}) walk_blocked |= off(part, left) > kWalkBlocked_m;
  person.script->tick(t_s, view, walk_blocked, off(person.script->reaching_part(), false) > kReachBlocked_m);
}

void SimPeople::look(Person& person, Figure figure, int index, Physics& physics) {
  std::swap(person.before, person.shapes);
  person.shapes = std::move(figure.parts);
  person.facing_W = figure.facing_W;
  for (Shape& part : person.shapes) part.X_WS.translation() += person.body.offset(group_of(part));
  touch(index, person, physics);
  const double free_m = person.nearest_m - kNear_m;
  person.next_look = 0;
  if (free_m > 0.0 && person.body.at_rest())
    person.next_look = static_cast<int>(std::min(free_m / (kFastest_m_s * kTick_s), double{kMaxRest_ms}));
  person.rested = person.next_look;
}

// contacts of one group that lie side by side are one: a hand is not stiffer for its fingers
void SimPeople::add_touch(std::vector<Touch>& touches, Touch touch) const {
  for (Touch& other : touches) {
    if (other.solid->by != touch.solid->by || other.out_W.dot(touch.out_W) < 0.8) continue;
    if ((other.nearest.on_axis_W - touch.nearest.on_axis_W).norm() > kMerged_m) continue;
    if (touch.nearest.distance_m < other.nearest.distance_m) other = touch;
    return;
  }
  touches.push_back(touch);
}

void SimPeople::touch(int index, Person& person, Physics& physics) {
  person.robot_m = person.nearest_m = std::numeric_limits<double>::infinity();
  std::array<std::vector<Touch>, kBodyGroups> touches;
  for (std::size_t i = 0; i < person.shapes.size(); ++i) {
    const Shape part = as_capsule(person.shapes[i]);
    const double radius = bounding_radius(part);
    const std::size_t group = group_of(part);
    const bool displaced = person.body.offset(group).norm() > kDisplaced_m;
    for (const Solid& solid : solids_) {
      const bool robot = solid.by == BodyContact::By::Robot;
      const bool still = solid.by == BodyContact::By::Static;
      if (still && !displaced) continue;
      if (solid.by == BodyContact::By::Object && index == kPartner) continue;
      const double apart =
          (part.X_WS.translation() - solid.shape.X_WS.translation()).norm() - radius - solid.radius_m;
      if (apart > std::max(robot ? person.robot_m : still ? 0.0 : person.nearest_m, 0.0)) continue;
      Touch t{nearest(part, solid.shape), i, &solid};
      if (robot) person.robot_m = std::min(person.robot_m, t.nearest.distance_m);
      if (!still) person.nearest_m = std::min(person.nearest_m, t.nearest.distance_m);
      if (t.nearest.distance_m >= 0.0) continue;
      t.out_W = outward(solid.shape, t.nearest.on_axis_W);
      add_touch(touches[group], t);
    }
  }
  std::array<Vec3, kBodyGroups> force_W;
  force_W.fill(Vec3::Zero());
  const bool moved_on = person.rested == 0 && person.before.size() == person.shapes.size();
  for (std::size_t group = 0; group < kBodyGroups; ++group)
    for (const Touch& t : touches[group]) {
      const Shape& part = person.shapes[t.part];
      BodyContact c;
      // who leans on the robot's base leans on furniture: nothing that a program does moves it
      c.by = t.solid->fixed ? BodyContact::By::Static : t.solid->by;
      c.person = index;
      c.region = region_of(part.part, t.nearest.along, t.out_W, person.facing_W);
      c.left = part.left;
      c.at_W = t.nearest.on_axis_W - (t.nearest.distance_m + part.size[0]) * t.out_W;
      Vec3 v_W = Vec3::Zero(), other_W = Vec3::Zero();
      if (moved_on) v_W = velocity_at(as_capsule(part), as_capsule(person.before[t.part]), t.nearest.along);
      if (t.solid->link >= 0) other_W = physics.link_velocity_W(t.solid->link, c.at_W);
      if (c.by == BodyContact::By::Object) other_W = physics.object_velocity_W(c.at_W);
      const Vec3 slide = v_W - other_W;
      c.other_m_s = other_W.dot(t.out_W);
      c.closing_m_s = -slide.dot(t.out_W);
      c.force_n = contact_force_n(properties_of(c.region), -t.nearest.distance_m, c.closing_m_s);
      const Vec3 along = slide + c.closing_m_s * t.out_W;
      Vec3 rub = -kRub_ns_m * along;
      if (rub.norm() > kFriction * c.force_n) rub *= kFriction * c.force_n / rub.norm();
      c.force_W = c.force_n * t.out_W + rub;
      force_W[group] += c.force_W;
      if (c.by == BodyContact::By::Robot) physics.push_link(t.solid->link, c.at_W, -c.force_W, c.force_n);
      if (c.by == BodyContact::By::Object) physics.push_object(c.at_W, -c.force_W);
      contacts_.push_back(c);
    }
  person.body.step(force_W);
}

void SimPeople::tick(double t_s, Physics& physics, const std::function<std::vector<Shape>()>& object,
                     const std::vector<Shape>& clutter, const Partner& partner) {
  contacts_.clear();
  std::vector<Shape> parts;
  bool known = false;
  const auto read_world = [&] {
    if (std::exchange(known, true)) return;
    parts = object();
    read_solids(physics, parts, clutter);
  };
  if (!people_.empty()) {
    read_world();
    PersonView view;
    const Pose X_WH = physics.link_pose(model_.palm);
    view.palm_W = X_WH.translation();
    view.between_fingers_W = X_WH * Vec3(0, 0, kBetweenFingers_m);
    view.object = &parts;
    for (std::size_t i = 0; i < people_.size(); ++i) {
      Person& person = people_[i];
      move(person, t_s, view);
      if (--person.next_look >= 0) continue;
      World world;
      person.script->add_to(world);
      look(person, {std::move(world.shapes), person.script->facing()}, static_cast<int>(i), physics);
    }
  }
  if (--partner_.next_look >= 0) return;
  read_world();
  look(partner_, partner(), kPartner, physics);
}

void SimPeople::task_state(const std::string& name, double t_s) {
  for (Person& person : people_) person.script->task_state(name, t_s);
}

void SimPeople::add_to(World& world) const {
  for (const Person& person : people_) {
    const std::size_t first = world.shapes.size();
    person.script->add_to(world);
    for (std::size_t i = first; i < world.shapes.size(); ++i)
      world.shapes[i].X_WS.translation() += person.body.offset(group_of(world.shapes[i]));
  }
}

const Vec3& SimPeople::partner_offset(const Shape& part) const {
  return partner_.body.offset(group_of(part));
}

double SimPeople::distance_m() const {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Person& person : people_) nearest_m = std::min(nearest_m, person.robot_m);
  return nearest_m;
}

}  // namespace colift::sim_hal
