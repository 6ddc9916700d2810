#pragma once

#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// What an arm that only yields may be out by (J): the spring of a lower leg, pressed with its
/// quasi-static limit, holds 0.14 J.
inline constexpr double kGivesWay_j = 0.1;

/// Energy that the commands put into the arm. The controller inside the arm is a spring from the joints to a
/// set point (joint impedance): whoever moves the set point against the spring works on it, and so does a
/// change of stiffness or of the superposed torque. Dampers only take. What a person pushes into a soft arm
/// and gets back from it is therefore not in this figure, and what an arm drives into him is. Energy that
/// commands take out, following him, is no credit for what they put in later.
class CommandedEnergy {
 public:
  /// One millisecond. `rests`: the arm stands and nobody touches it; the sum begins anew.
  void tick(const TickReport& report, bool rests);
  /// Since the arm last rested (J): put in less taken out ...
  [[nodiscard]] double sum_j() const { return sum_j_; }
  /// ... and the same since the sum was lowest.
  [[nodiscard]] double put_in_j() const { return sum_j_ - lowest_j_; }

 private:
  hal::JointVector q_rad_ = hal::JointVector::Zero(), set_point_rad_ = hal::JointVector::Zero();
  hal::JointVector stiffness_nm_rad_ = hal::JointVector::Zero();
  hal::JointVector superposed_nm_ = hal::JointVector::Zero();
  hal::JointVector rest_rad_ = hal::JointVector::Zero();        // measured
  hal::JointVector rest_spring_nm_ = hal::JointVector::Zero();  // what holds a load that is not superposed
  bool known_ = false;
  double sum_j_ = 0.0, lowest_j_ = 0.0;
};

}  // namespace colift::sim_hal
