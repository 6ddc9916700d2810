#pragma once

#include <optional>

#include "control/config/load_config.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/joints.hpp"
#include "hal/types/time.hpp"

namespace colift::control {

/// Wrench on the hand about the palm, in W, that explains external joint torques: tau = J^T F by damped least
/// squares. Damping sets in near singular postures only, where it makes the wrench too small rather than wild
/// (Nakamura and Hanafusa 1986). Allocation-free.
[[nodiscard]] hal::Wrench palm_wrench(const hal::RobotModel& model, const hal::JointVector& q_rad,
                                      const hal::JointVector& tau_external_nm);

/// What the arm feels at the palm: external joint torques, tared when the hand was empty, taken to a wrench
/// by the Jacobian's damped pseudo-inverse of the transpose. Deterministic, allocation-free.
class LoadEstimator {
 public:
  LoadEstimator(const hal::RobotModel& model, const LoadConfig& config);

  /// Takes what is felt now as nothing (mean over the updates while taring; none: keeps the last tare).
  void start_tare();
  void end_tare();
  /// A state that is not newer than the last one, or not a number, changes nothing.
  void update(hal::Timestamp at, const hal::JointVector& q_rad, const hal::JointVector& tau_external_nm);

  /// Filtered wrench of the environment on the hand, about the palm, in W. Unset before the first update.
  [[nodiscard]] std::optional<hal::Wrench> wrench_W() const;
  /// Part of the weight that the robot carries (N): positive when it pulls the hand down; 0 before the first
  /// update.
  [[nodiscard]] double load_n() const;

 private:
  const hal::RobotModel* model_;
  LoadConfig config_;
  bool taring_ = false;
  int tare_count_ = 0;
  hal::JointVector tare_ = hal::JointVector::Zero(), tare_sum_ = hal::JointVector::Zero();
  std::optional<hal::Timestamp> last_;
  std::optional<hal::Wrench> wrench_;
};

}  // namespace colift::control
