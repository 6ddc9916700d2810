#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/mujoco/engine/physics.hpp"
#include "sim_hal/people/body_contact.hpp"
#include "sim_hal/people/scripted_person.hpp"
#include "sim_hal/people/soft_body.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

/// The scenario's people under physics: where their scripts have them, and beside it as far as robot, object
/// and floor push them. Contact is a spring of the region's stiffness between a capsule of the body and a
/// solid, the body a point mass of the region's effective mass (SoftBody); the same force goes to MuJoCo's
/// robot and object. So the two-body model of the limits holds by construction, MuJoCo's own model has no
/// body more than without people, and a run in which nobody is touched is the same bit for bit.
class SimPeople {
 public:
  /// The partner who carries, as he is drawn at this moment; he meets the robot, not the object that he
  /// holds.
  struct Figure {
    std::vector<Shape> parts;
    Vec3 facing_W = Vec3::UnitX();
  };
  using Partner = std::function<Figure()>;

  SimPeople(const Scenario& scenario, const hal::RobotModel& model);

  [[nodiscard]] bool empty() const { return people_.empty(); }
  /// Whether somebody's place at the start of his path is in the robot's. Errors: BadConfig,
  /// "people[1].path".
  [[nodiscard]] hal::Result<> check_start(const Physics& physics, const std::vector<Shape>& object) const;
  /// 1 ms before Physics::step(): moves everybody and pushes robot and object. `object`, `clutter` in W.
  /// Whoever is far from everything is looked at again when he could have come near, at most 10 ms later.
  void tick(double t_s, Physics& physics, const std::function<std::vector<Shape>()>& object,
            const std::vector<Shape>& clutter, const Partner& partner);
  /// The task has entered a state for the first time: who enters after it has his time.
  void task_state(const std::string& name, double t_s);
  /// Adds the people of the scenario as they are, Label::Partner.
  void add_to(World& world) const;
  /// How far a part of the partner is from where he is drawn.
  [[nodiscard]] const Vec3& partner_offset(const Shape& part) const;

  [[nodiscard]] const std::vector<BodyContact>& contacts() const { return contacts_; }
  /// Between the robot and anybody of the scenario's people, and the partner, when they were last looked at
  /// (m); infinite when nobody is there.
  [[nodiscard]] double distance_m() const;
  [[nodiscard]] double partner_distance_m() const { return partner_.robot_m; }

 private:
  struct Person {
    std::optional<ScriptedPerson> script;  // unset: the partner
    SoftBody body = {};
    std::vector<Shape> shapes = {}, before = {};  // as they are, and at the look before
    Vec3 facing_W = Vec3::UnitX();
    int next_look = 0, rested = 0;  // ticks until the next look; ticks since the last one
    double robot_m = std::numeric_limits<double>::infinity();    // to the robot
    double nearest_m = std::numeric_limits<double>::infinity();  // to robot or object
  };
  struct Solid {
    Shape shape;
    BodyContact::By by;
    int link = -1;
    bool fixed = false;  ///< A link that no joint moves: the robot's base.
    double radius_m = 0.0;
  };
  struct Touch;

  void read_solids(const Physics& physics, const std::vector<Shape>& object,
                   const std::vector<Shape>& clutter);
  void move(Person& person, double t_s, const PersonView& view) const;
  void look(Person& person, Figure figure, int index, Physics& physics);
  void touch(int index, Person& person, Physics& physics);
  void add_touch(std::vector<Touch>& touches, Touch touch) const;

  hal::RobotModel model_;
  std::vector<bool> fixed_;  ///< For each link: no joint moves it.
  std::vector<Person> people_;
  std::vector<Solid> solids_;
  Person partner_;
  std::vector<BodyContact> contacts_;
};

}  // namespace colift::sim_hal
