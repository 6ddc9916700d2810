#pragma once

#include <cmath>
#include <optional>

#include "hal/drivers/kuka_fri/wire/fri_packets.hpp"
#include "hal/types/joints.hpp"

namespace colift::hal {

/// Which check a command failed, with its numbers. Made into words outside of the cycle.
struct FriLimit {
  enum class What : std::uint8_t {
    None,
    NotFinite,
    Position,
    Step,
    Start,
    Stiffness,
    Damping,
    Torque,
    Frame,
    Speed,
    Wrench
  };
  What what = What::None;
  std::uint8_t axis = 0;  ///< Joint from 0, or x y z rx ry rz.
  double found = 0.0, limit = 0.0;
};

/// The joint position that goes over the wire. Outside of command mode it is the controller's own, bit by
/// bit; in command mode it moves with its user's commands, comes to rest when it is told to, and never steps.
///
/// The user's first command is the measured pose, but the controller follows its own commanded one, and an
/// arm on springs hangs between the two. The difference is kept as an offset. What of it a load explains
/// (external torque over stiffness) stays, or the arm would sink by it at every start; the rest is walked
/// down within acceleration limits: a step of it would be a jerk, or the end of command mode.
///
/// After lost datagrams the controller has gone on by itself (it extrapolates). If it says so, the set point
/// goes on from there, and what the user lags behind becomes such an offset.
class JointSetPoint {
 public:
  struct Limits {
    JointVector limit_rad, velocity_rad_s;
    double acceleration_rad_s2 = 15.0;
  };
  explicit JointSetPoint(const Limits& limits) : limits_(limits) {}

  /// What the controller commands: cmdJntPos + cmdJntPosFriOffset, in float as on the wire.
  [[nodiscard]] static FriJoints followed(const FriMeasurement& m);
  /// At rest, on springs: true where the load `tau_nm` on the arm has the sign opposite to what `off_rad`
  /// (measured minus commanded) says of it, in a pattern over the joints that no accident explains.
  [[nodiscard]] static bool pulls_backwards(const JointVector& off_rad, const JointVector& tau_nm);
  /// The same, where that pattern agrees with the load.
  [[nodiscard]] static bool explained(const JointVector& off_rad, const JointVector& tau_nm);
  [[nodiscard]] static JointVector joints(const FriJoints& q);

  /// Outside of command mode.
  void mirror(const FriJoints& followed);
  /// The next command is a first one; `measured` is where it has to be. `load_nm`: external torque on the arm
  /// that hangs on springs of `stiffness_nm_rad`; zero where it does not.
  void expect_first(const JointVector& measured_rad, const JointVector& load_nm = JointVector::Zero(),
                    const JointVector& stiffness_nm_rad = JointVector::Zero());
  /// The springs' stiffness from now on: a load hangs higher on stiffer ones.
  void set_stiffness(const JointVector& stiffness_nm_rad);
  /// Lost datagrams: `cycles` were not answered. True when the controller has gone on by itself.
  bool bridge(const FriJoints& followed, int cycles);
  /// A longer gap: from where the controller is now, at rest.
  void restart(const FriJoints& followed);

  /// A command for the open cycle. `steps`: cycles that it may span; `period_s`: the shortest that a cycle
  /// may be, for what its limits grant.
  FriLimit command(const JointVector& q_rad, int steps, double period_s, double safety_limits);
  /// No command came: the last one again.
  void repeat();
  /// Nobody may command: the next step on the way to rest.
  void brake(double period_s);

  [[nodiscard]] const FriJoints& wire() const { return wire_; }
  [[nodiscard]] const JointVector& q_rad() const { return q_; }
  [[nodiscard]] bool at_rest() const { return step_.isZero() && offset_ == held_; }

 private:
  void send(const JointVector& q_rad);
  void ramp(double period_s);
  void release();
  void hold_load();

  Limits limits_;
  FriJoints wire_{};
  JointVector q_ = JointVector::Zero(), step_ = JointVector::Zero();          ///< As on the wire; per cycle.
  JointVector goal_ = JointVector::Zero();                                    ///< The user's last command.
  JointVector offset_ = JointVector::Zero(), doffset_ = JointVector::Zero();  ///< wire = goal + offset
  JointVector held_ = JointVector::Zero();     ///< Part of the offset that a load explains.
  JointVector load_nm_ = JointVector::Zero();  ///< That load: held_ times the stiffness.
  JointVector start_load_nm_ = JointVector::Zero(), start_stiffness_ = JointVector::Zero();
  std::optional<JointVector> first_at_;
  bool bridged_ = false;
};

}  // namespace colift::hal
