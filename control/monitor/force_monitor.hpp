#pragma once

#include <cstdint>
#include <string>

#include "control/config/monitor_config.hpp"
#include "hal/arm.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"

namespace colift::control {

/// What the hand has to do with the object, and so which forces are expected.
enum class HandLoad : std::uint8_t {
  Empty,     ///< Nothing in the hand. On a trajectory SetpointGenerator detects contact; at rest this does.
  Closing,   ///< The hand closes or is closed, the object stands.
  Carried,   ///< The object is raised or held up.
  Lowering,  ///< It is lowered: something may be under it.
};

/// The force that broke a limit.
struct ForceFinding {
  enum class Kind : std::uint8_t { None, Sideways, Up, Down, Torque, Joint };
  Kind kind = Kind::None;
  double measured = 0.0, limit = 0.0;     ///< N; N m of Torque and Joint.
  hal::Vec3 force_W = hal::Vec3::Zero();  ///< On the hand, when it was found (N).
  int joint = 0;                          ///< Of Joint, from 0.
  HandLoad load = HandLoad::Empty;

  [[nodiscard]] explicit operator bool() const { return kind != Kind::None; }
};

/// The limits that count while the hand bears `load`; none (nullptr) of the empty hand, whose contact
/// threshold counts instead. Points into `config`.
[[nodiscard]] const ForceLimits* force_limits(const ForceMonitorConfig& config, HandLoad load);

/// Compares what the arm feels with what its state explains, once per cycle of the arm and in every state:
/// external joint torques, tared with the empty hand, as force and torque at the palm and by joint. The load
/// of a carried object hangs down, so every direction has a limit of its own. Latched until clear().
/// Allocation-free.
class ForceMonitor {
 public:
  ForceMonitor(const hal::RobotModel& model, const ForceMonitorConfig& config);

  /// From the next cycle on. Entering Closing takes what an arm at rest felt last as zero.
  void expect(HandLoad load);
  /// One cycle. `moves_alone`: the arm follows a trajectory with an empty hand, where SetpointGenerator
  /// detects contact. `in_contact`: somebody is known to push, so that nothing felt now may become the zero.
  void update(const hal::ArmState& state, double dt_s, bool moves_alone, bool in_contact);
  /// Forgets a finding. It is armed again once the force is below its limits.
  void clear();

  [[nodiscard]] const ForceFinding& finding() const { return finding_; }
  /// Filtered force on the hand and torque about the palm against the zero (W).
  [[nodiscard]] const hal::Wrench& felt() const { return felt_; }
  /// Nothing that is felt now is above a limit.
  [[nodiscard]] bool quiet() const { return quiet_; }
  [[nodiscard]] HandLoad load() const { return load_; }

 private:
  [[nodiscard]] ForceFinding judge(const hal::JointVector& tau_nm) const;

  const hal::RobotModel* model_;
  ForceMonitorConfig config_;
  HandLoad load_ = HandLoad::Empty;
  ForceFinding finding_;
  hal::Wrench felt_;
  hal::JointVector zero_nm_ = hal::JointVector::Zero();
  bool zero_known_ = false, quiet_ = true, armed_ = true;
  double moved_s_ = 0.0;  ///< Time until an arm that has moved is taken as settled.
};

/// "41 N push the hand sideways (limit 30 N)"; empty for none.
[[nodiscard]] std::string describe(const ForceFinding& finding);

}  // namespace colift::control
