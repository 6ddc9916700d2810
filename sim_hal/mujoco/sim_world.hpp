#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/arm.hpp"
#include "hal/hand.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "sim_hal/people/body_contact.hpp"
#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "sim_hal/synthetic/shapes.hpp"

namespace colift::sim_hal {

/// How the simulated arm starts and how often it is commanded.
struct SimConfig {
  hal::Duration arm_period = std::chrono::milliseconds(5);  ///< Time between two commands: FRI's usual cycle.
  hal::JointVector start_rad = home_rad();                  ///< Where the arm stands at the start.
  [[nodiscard]] static hal::JointVector home_rad();
};

/// What is true at this moment, for reports and tests; no device reports it.
struct SimTruth {
  hal::Timestamp at{0};
  Pose X_WT = Pose::Identity();  ///< Object.
  double mass_kg = 0.0;
  Vec3 cog_W = Vec3::Zero();
  double tilt_rad = 0.0;  ///< Between the object's up axis now and at time 0; of a cylinder, which may roll,
                          ///< the rise of its axis.
  double height_m = 0.0;  ///< Rise of the centre of gravity since time 0.
  Vec3 robot_force_W = Vec3::Zero();    ///< Of the hand's contacts on the object (N).
  Vec3 robot_torque_W = Vec3::Zero();   ///< The same about the palm (N m).
  Vec3 partner_force_W = Vec3::Zero();  ///< Of the partner on the object (N).
  Vec3 floor_force_W = Vec3::Zero();  ///< Of floor and clutter on the object (N); zero when it is in the air.
  double slip_m = 0.0;                ///< Motion of the object in the palm since the fingers were locked.
  std::optional<Vec3> partner_W;      ///< Where the partner holds it; unset while he does not.
  bool robot_touches_object = false;
  bool robot_hit_something =
      false;  ///< A link of the arm or the palm's back met anything, at any time so far.
  hal::JointVector q_rad = hal::JointVector::Zero();
  int divergences =
      0;  ///< Times that the physics diverged or had no room for contacts; anything but 0 is a bug.
};

/// One millisecond of the world, for who judges it. Valid during the call.
struct TickReport {
  double t_s = 0.0;  ///< Of the scenario.
  const SimTruth& truth;
  const std::vector<BodyContact>& contacts;
  double people_distance_m, partner_distance_m;      ///< To the robot; infinite when nobody is there.
  const hal::JointVector& command_rad;               ///< The client's last one ...
  bool commanded = false;                            ///< ... which came since the last report.
  const hal::JointVector &set_point_rad, &dq_rad_s;  ///< Inside the controller; measured.
  const hal::ImpedanceCommand& impedance;            ///< Stiffness and torque inside the controller.
  const hal::HandState& hand;
  bool pushed = false;  ///< A push of the scenario's faults is on the arm.
};

/// One scenario under physics: floor, clutter, object, LWR 4+, BarrettHand and partner. MuJoCo 2.2 at 1 ms,
/// implicit in advance(). Deterministic: same scenario, model, seed and calls, same bits. Any thread:
/// emulated devices share a world in real time; a call waits at most for one millisecond's step of the
/// physics.
class SimWorld {
 public:
  /// Errors: BadConfig (object below the floor or in the robot, grasp of the partner far off the surface).
  [[nodiscard]] static hal::Result<std::unique_ptr<SimWorld>> make(const Scenario& scenario,
                                                                   const hal::RobotModel& model,
                                                                   std::uint64_t seed,
                                                                   const SimConfig& config);
  ~SimWorld();

  [[nodiscard]] const hal::Clock& clock() const;
  /// Time 0 of the scenario is this time of a robot that lives in real time. Before the first advance().
  void start_at(hal::Timestamp now);
  /// Time 0 of the scenario is now: for devices that take their time to start. Any thread.
  void begin_scenario();
  /// Since the start: the time of the scenario.
  [[nodiscard]] hal::Duration elapsed() const;
  /// Moves time and everything in it; whole milliseconds.
  void advance(hal::Duration by);
  [[nodiscard]] SimTruth truth() const;
  /// Who is touched in the last millisecond, by what and how hard.
  [[nodiscard]] std::vector<BodyContact> body_contacts() const;
  /// Between the robot and anybody of Scenario::people, and the partner (m); infinite when nobody is there.
  [[nodiscard]] double people_distance_m() const;
  [[nodiscard]] double partner_distance_m() const;
  /// Called after every millisecond, in whoever's thread moves the world. Before the first advance().
  void observe(std::function<void(const TickReport&)> observer);

  // What the devices stand on. The controller inside the KRC runs at 1 ms between two commands of the client.
  [[nodiscard]] hal::ArmState arm_state() const;
  void command_arm(const hal::ImpedanceCommand& command);
  void hold_arm();  ///< Without a client: the arm stays where it is commanded.
  [[nodiscard]] hal::HandState hand_state() const;
  void preshape_hand(double spread_rad);
  void close_hand(double torque_nm);
  void close_hand(const std::array<double, hal::kFingers>& torque_nm);  ///< 0: that finger stays.
  void open_hand();
  void open_hand(const std::array<bool, hal::kFingers>& which);
  void stop_hand();          ///< A grip is pressed on.
  void power_hand(bool on);  ///< Off: the worms alone hold.
  [[nodiscard]] bool hand_worms_turn() const;

  /// The partner is asked to take hold of the object at a place (W), or to step aside that way (W,
  /// horizontal) without letting go. Whether he does: only if he is obliging (ScenarioPartner), and not where
  /// there is nothing to hold or no room to stand.
  bool ask_partner(const std::optional<Vec3>& grasp_W, const std::optional<Vec3>& aside_W = {});

  /// People come who take the object off the robot's hand, and keep it where it is then: SimHelpers.
  void take_object();
  /// The same, and they pull it away from the palm, along the horizontal part of where that points, by so
  /// much (m).
  void pull_object_away(double by_m);

  /// The partner confirmed since the last call that a paused object may be lowered (do: confirm-lower).
  bool take_lower_confirmed();
  /// The same of an arm that stopped and may continue (do: confirm-continue).
  bool take_continue_confirmed();

  /// The client's task has entered a state: events of the scenario may count from its first entry
  /// (relative_time()). The only thing that the world is told of its client.
  void task_state(const std::string& name);
  /// A person mends whatever is wrong with the devices: faults of the scenario are over, none will come.
  void end_faults();

  /// Everything that a camera can see, where it is now: object, floor, clutter, robot, partner.
  [[nodiscard]] World shapes() const;

  [[nodiscard]] const Scenario& scenario() const;
  [[nodiscard]] const SimConfig& config() const;
  [[nodiscard]] const hal::RobotModel& model() const;
  [[nodiscard]] std::uint64_t seed() const;

 private:
  struct Impl;
  explicit SimWorld(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::sim_hal
