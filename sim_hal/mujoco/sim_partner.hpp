#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "hal/types/geometry.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

/// What the partner sees and feels of the object.
struct PartnerView {
  double t_s = 0.0;
  Pose X_WT = Pose::Identity();
  Vec3 v_W = Vec3::Zero();  ///< Of the origin of T (m/s).
  Vec3 w_W = Vec3::Zero();  ///< Turning (rad/s).
  /// Where the robot's fingers have locked on the object last, in T; unset until they have.
  std::optional<Vec3> robot_T;
};

/// A time during which the partner's hand is at one place of the object.
struct PartnerHold {
  Vec3 grasp_T = Vec3::Zero();
  double from_s = 0.0;
  std::optional<double> until_s;  ///< Unset: to the end.
  bool leaves = false;            ///< He goes away after it.
};

/// A person's hand on the object, as a spring with damping between the grasp point and where he wants it:
/// 7000 N/m upwards, 1500 N/m sideways, at most 250 N. His hand turns with the object: 8 N m/rad and at most
/// 1.5 N m (about 30 N at the 5 cm half width of a hand).
///
/// compliant: rests his hand until the robot's side rises; then lifts along, 0.15 s later and no faster
/// than 0.25 m/s, and slowly takes out what is left of the tilt that he sees (from half a degree). leader:
/// one second after the robot's fingers have locked he lifts by the task's height in 2 s, holds, lowers. Both
/// tremble by 0.5 mm at 8 to 10 Hz (physiological tremor), phases and frequencies from the seed. support and
/// none apply no force here.
class SimPartner {
 public:
  static constexpr double kHears_s = 1.0;  ///< Until somebody who is asked for something begins to do it.

  SimPartner(const ScenarioPartner& partner, const ScenarioTask& task, std::uint64_t seed);

  /// One step of 1 ms: force on the object at `at_W`, torque beside it. nullopt while he does not hold.
  struct Action {
    Vec3 at_W, force_W, torque_W;
  };
  [[nodiscard]] std::optional<Action> tick(const PartnerView& view);

  /// The task has entered a state: events that count from its first entry are due then.
  void task_state(const std::string& name, double t_s);
  /// He confirmed lowering since the last call ...
  [[nodiscard]] bool take_lower_confirmed() { return std::exchange(lower_confirmed_, false); }
  /// ... or that the arm may continue.
  [[nodiscard]] bool take_continue_confirmed() { return std::exchange(continue_confirmed_, false); }

  /// Where his second hand is (in T); unset while he holds with one.
  [[nodiscard]] std::optional<Vec3> second_hand(double t_s) const;

  /// He is asked to take hold there (in T): lets go a moment later, and holds there soon after. What his
  /// script has for later he forgets. Only where ScenarioPartner::obliging; whether he goes.
  bool ask(const Vec3& grasp_T, double t_s);

  [[nodiscard]] const std::vector<PartnerHold>& holds() const { return holds_; }
  /// The hold that counts at a time: the present one, else the coming one if it begins within 0.6 s, else the
  /// last one. nullptr before anything is to be seen.
  [[nodiscard]] const PartnerHold* hold_to_show(double t_s) const;

 private:
  static constexpr int kDelay_ms = 150;
  struct Grip {
    std::optional<std::size_t> hold;
    Vec3 start_W = Vec3::Zero();
    Eigen::Matrix3d R_WT = Eigen::Matrix3d::Identity();
    double request_m = 0.0;   ///< How much higher he wants his hand than at the start.
    double levelled_m = 0.0;  ///< Part of it that came from the tilt that he saw.
  };
  struct Seen {
    double robot_m = 0.0, own_m = 0.0;  ///< Rise of the robot's side and of his own ...
    double unseen_m = 0.0;              ///< ... and the difference that he does not see.
  };

  void do_events(double t_s);
  [[nodiscard]] Vec3 stumble_n(const PartnerView& view, const Vec3& at_W) const;
  [[nodiscard]] Vec3 sway_m(const PartnerView& view, const Vec3& at_W) const;
  void add_second_hand(const PartnerView& view, Action& action);
  [[nodiscard]] std::optional<std::size_t> holding(double t_s) const;
  void take_hold(std::size_t hold, const PartnerView& view);
  void follow(const Seen& seen);
  void lead(const PartnerView& view, const Seen& now);
  [[nodiscard]] Vec3 tremor(double t_s) const;

  ScenarioPartner partner_;
  ScenarioTask task_;
  std::vector<PartnerHold> holds_;
  std::vector<PartnerScriptEvent> coming_;  ///< In the order of time; those of states not yet entered aside.
  std::vector<PartnerScriptEvent> waiting_;
  std::optional<PartnerScriptEvent> stumbles_, sways_, second_;
  std::optional<Vec3> second_start_W_;
  bool lower_confirmed_ = false, continue_confirmed_ = false;
  std::array<double, 3> tremor_hz_{}, tremor_rad_{};
  Grip grip_;
  std::array<Seen, kDelay_ms> past_{};
  std::size_t tick_ = 0;
  std::optional<Vec3> robot_T_;  ///< The robot's grip that counts, its height and time when it closed.
  double robot_z_m_ = 0.0, locked_at_s_ = 0.0;
};

}  // namespace colift::sim_hal
