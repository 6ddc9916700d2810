#include <optional>
#include <utility>

#include "sim_hal/imperfect/imperfect_devices.hpp"

namespace colift::sim_hal {
namespace {

class ImperfectHand final : public hal::Hand {
 public:
  ImperfectHand(std::unique_ptr<hal::Hand> inner, const HandErrors& errors)
      : inner_(std::move(inner)), errors_(errors) {}

  hal::Result<> configure() override { return inner_->configure(); }
  hal::Result<> activate() override { return inner_->activate(); }
  void deactivate() noexcept override { inner_->deactivate(); }
  hal::DeviceHealth health() const override { return inner_->health(); }
  hal::Result<> preshape(double spread_rad) override { return inner_->preshape(spread_rad); }
  hal::Result<> close(double torque_nm) override { return inner_->close(torque_nm); }
  hal::Result<> release() override { return inner_->release(); }
  std::vector<std::string> realtime() const override { return inner_->realtime(); }
  void stop() noexcept override { inner_->stop(); }

  hal::Result<hal::HandState> state() override {
    auto state = inner_->state();
    if (!state) return state;
    if (!since_) since_ = state->measured_at;
    const double t_s = hal::seconds(state->measured_at - *since_);
    for (std::size_t i = 0; i < state->torque_nm.size(); ++i) {
      state->torque_nm[i] += errors_.strain_drift_nm_s[i] * t_s;
      state->tip_force_n[i] += errors_.tactile_drift_n_s[i] * t_s;
    }
    return state;
  }

 private:
  std::unique_ptr<hal::Hand> inner_;
  HandErrors errors_;
  std::optional<hal::Timestamp> since_;
};

}  // namespace

std::unique_ptr<hal::Hand> make_imperfect_hand(std::unique_ptr<hal::Hand> inner, const HandErrors& errors) {
  return std::make_unique<ImperfectHand>(std::move(inner), errors);
}

}  // namespace colift::sim_hal
