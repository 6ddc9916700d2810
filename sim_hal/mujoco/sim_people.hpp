#pragma once

#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/mujoco/physics.hpp"
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
  SimPeople(const Scenario& scenario, const hal::RobotModel& model);

  [[nodiscard]] bool empty() const { return people_.empty(); }
  /// Whether somebody's place at the start of his path is in the robot's. Errors: BadConfig,
  /// "people[1].path".
  [[nodiscard]] hal::Result<> check_start(const Physics& physics, const std::vector<Shape>& object) const;
  /// 1 ms before Physics::step(): moves everybody and pushes robot and object. `object`, `clutter` in W.
  void tick(double t_s, Physics& physics, const std::vector<Shape>& object,
            const std::vector<Shape>& clutter);
  /// Adds everybody as he is, Label::Partner.
  void add_to(World& world) const;

  [[nodiscard]] const std::vector<BodyContact>& contacts() const { return contacts_; }
  /// Between anybody and the robot now (m); infinite when nobody is there.
  [[nodiscard]] double distance_m() const { return distance_m_; }

 private:
  struct Person {
    ScriptedPerson script;
    SoftBody body;
    std::vector<Shape> shapes, before;  // as they are, and a tick ago
  };
  struct Solid {
    Shape shape;
    BodyContact::By by;
    int link = -1;
    double radius_m = 0.0;
  };
  struct Touch;

  void read_solids(const Physics& physics, const std::vector<Shape>& object,
                   const std::vector<Shape>& clutter);
  void place(Person& person, double t_s, const PersonView& view);
  void touch(int index, Person& person, Physics& physics);
  void add_touch(std::vector<Touch>& touches, Touch touch) const;

  hal::RobotModel model_;
  std::vector<Person> people_;
  std::vector<Solid> solids_;
  std::vector<BodyContact> contacts_;
  double distance_m_ = std::numeric_limits<double>::infinity();
};

}  // namespace colift::sim_hal
