#include <cmath>
#include <utility>

#include "hal/types/units.hpp"
#include "sim_hal/imperfect/imperfect_devices.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

constexpr std::uint64_t kNoise = 8410;

class ImperfectArm final : public hal::Arm {
 public:
  ImperfectArm(std::unique_ptr<hal::Arm> inner, const hal::RobotModel& model, const ArmErrors& errors)
      : inner_(std::move(inner)), model_(model), errors_(errors) {}

  hal::Result<> configure() override { return inner_->configure(); }
  hal::Result<> activate() override { return inner_->activate(); }
  void deactivate() noexcept override { inner_->deactivate(); }
  hal::DeviceHealth health() const override { return inner_->health(); }
  [[nodiscard]] hal::ArmAbilities abilities() const override { return inner_->abilities(); }
  void stop() noexcept override { inner_->stop(); }

  hal::Result<hal::ArmState> wait_cycle() override {
    auto state = inner_->wait_cycle();
    if (!state || !state->q_rad.allFinite()) return state;
    tool_nm_ = tool_torque(state->q_rad);
    const hal::JointVector true_nm = state->tau_nm;
    const double h = errors_.torque_hysteresis_nm;
    if (!played_) sensed_nm_ = true_nm;
    played_ = true;
    sensed_nm_ = sensed_nm_.cwiseMax((true_nm.array() - h).matrix()).cwiseMin((true_nm.array() + h).matrix());
    hal::JointVector wrong_nm = sensed_nm_ - true_nm + errors_.torque_bias_nm;
    for (int i = 0; i < hal::kArmJoints; ++i) wrong_nm[i] += errors_.torque_noise_nm * normal();
    state->tau_nm += wrong_nm;
    // external torque = what the model needs - what is measured
    state->tau_external_nm += tool_nm_ - wrong_nm;
    return state;
  }

  hal::Result<> command(const hal::ImpedanceCommand& command) override {
    hal::ImpedanceCommand real = command;
    // a joint's torque control makes the measured torque right, not the true one
    real.tau_superposed_nm += tool_nm_ - errors_.torque_bias_nm;
    return inner_->command(real);
  }

 private:
  /// What holds the mass that is not there.
  [[nodiscard]] hal::JointVector tool_torque(const hal::JointVector& q_rad) const {
    const hal::ArmJacobian J = hal::jacobian(model_, q_rad, Vec3::Zero());
    return J.row(2).transpose() * (errors_.tool_mass_kg * hal::kGravity_m_s2);
  }

  /// Mean 0, deviation 1: the sum of twelve uniform numbers, which needs no function of a library.
  double normal() {
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) sum += unit(hash(errors_.seed, kNoise, index_++));
    return sum;
  }

  std::unique_ptr<hal::Arm> inner_;
  const hal::RobotModel& model_;
  ArmErrors errors_;
  bool played_ = false;
  std::uint64_t index_ = 0;
  hal::JointVector sensed_nm_ = hal::JointVector::Zero(), tool_nm_ = hal::JointVector::Zero();
};

}  // namespace

std::unique_ptr<hal::Arm> make_imperfect_arm(std::unique_ptr<hal::Arm> inner, const hal::RobotModel& model,
                                             const ArmErrors& errors) {
  return std::make_unique<ImperfectArm>(std::move(inner), model, errors);
}

}  // namespace colift::sim_hal
