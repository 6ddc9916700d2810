#include "sim_hal/emulator/krc/plant/krc_measurement.hpp"

#include "hal/types/symmetric.hpp"

namespace colift::sim_hal {

Vector6 wrench_of(const hal::JointVector& tau_nm, const hal::ArmJacobian& J) {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const Matrix6 gram = J * J.transpose() + 1e-6 * Matrix6::Identity();
  return hal::solve_symmetric<double, 6>(gram, J * tau_nm);
}

void fill_arm(KrcMeasurement& m, const KrcMotion& motion, const KrcPlantState& plant,
              const hal::ArmDynamics& dynamics, const hal::Pose& X_FT) {
  m.q_rad = wire_joints(plant.q_rad);
  m.X_WT = wire_frame(motion.tool(plant.q_rad));
  m.q_krl_rad = wire_joints(motion.q_krl_rad());
  m.q_offset_rad = wire_joints(motion.q_rad() - motion.q_krl_rad());
  m.X_WT_krl = wire_frame(motion.X_WT_krl());
  m.X_WT_offset = wire_frame(motion.X_WT_krl().inverse() * motion.X_WT());
  m.tau_nm = wire_joints(plant.tau_nm);
  m.tau_external_nm = wire_joints(plant.tau_external_nm);

  const hal::ArmJacobian J = dynamics.jacobian(plant.q_rad, X_FT.translation());
  m.wrench_external = wire_order(wrench_of(plant.tau_external_nm, J));
  static constexpr std::array<int, 6> kRow{0, 1, 2, 5, 4, 3};  // X Y Z Rz Ry Rx
  for (std::size_t row = 0; row < 6; ++row)
    for (std::size_t i = 0; i < 7; ++i)
      m.jacobian[7 * row + i] = static_cast<float>(J(kRow[row], static_cast<int>(i)));
  const hal::JointMatrix M = dynamics.mass_matrix(plant.q_rad);
  for (std::size_t row = 0; row < 7; ++row)
    for (std::size_t i = 0; i < 7; ++i)
      m.mass_matrix[7 * row + i] = static_cast<float>(M(static_cast<int>(row), static_cast<int>(i)));
  m.gravity_nm = wire_joints(dynamics.gravity_nm(plant.q_rad));
}

}  // namespace colift::sim_hal
