#pragma once

#include <optional>
#include <vector>

#include "sim_hal/scenario/scenario.hpp"
#include "sim_hal/synthetic/person.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// What a person of a script has around him.
struct PersonView {
  Vec3 palm_W = Vec3::Zero();                  ///< Middle of the robot's palm.
  Vec3 between_fingers_W = Vec3::Zero();       ///< Between palm and fingertips.
  const std::vector<Shape>* object = nullptr;  ///< Its solid parts in W.
};

/// A ScenarioPerson over time: walks along his path with swinging legs, then does what he does at its end
/// within 0.6 s, reaches with his hand or foot at its speed for a goal that may move, and leaves as he came.
/// Posture only: what he meets pushes a SoftBody.
class ScriptedPerson {
 public:
  explicit ScriptedPerson(const ScenarioPerson& script);

  /// 1 ms. `walk_blocked`: legs or trunk are held off by something, `reach_blocked`: the hand or foot that
  /// reaches is. A walker then stays where he is until he leaves, a hand until it is free.
  void tick(double t_s, const PersonView& view, bool walk_blocked, bool reach_blocked);

  /// The task has entered a state for the first time: his time may count from it.
  void task_state(const std::string& name, double t_s);

  /// Whatever his time is.
  void enter_now() { script_.in_state.clear(), script_.enters_s = 0.0, script_.leaves_s.reset(); }

  [[nodiscard]] bool present() const { return present_; }
  [[nodiscard]] const Vec3& facing() const { return facing_; }
  /// Adds his parts, Label::Partner, in the same order at any time.
  void add_to(World& world) const;
  /// Part that reaches, of its group.
  [[nodiscard]] BodyPart reaching_part() const { return script_.with_foot ? BodyPart::Foot : BodyPart::Hand; }

 private:
  [[nodiscard]] Vec3 on_path(double walked_m, Vec3* direction) const;
  [[nodiscard]] std::optional<Vec3> goal(const PersonView& view) const;
  [[nodiscard]] Vec3 under(const PersonView& view) const;
  void turn_to(const Vec3& direction);
  void reach(const PersonView& view, bool blocked);
  [[nodiscard]] Vec3 resting_tip() const;
  [[nodiscard]] Posture posture() const;

  ScenarioPerson script_;
  double length_m_ = 0.0;
  bool present_ = false, gone_ = false, stopped_ = false;
  double walked_m_ = 0.0, stride_ = 0.0;  // stride: how far the legs swing, 0 to 1
  double settled_ = 0.0;                  // 0 upright, 1 in the posture of the end
  Vec3 at_ = Vec3::Zero(), facing_ = Vec3::UnitX();
  std::optional<Vec3> tip_W_;  // of what reaches
  double goal_z_m_ = 0.0;      // height that he bends for
  double lean_m_ = 0.0;
};

}  // namespace colift::sim_hal
