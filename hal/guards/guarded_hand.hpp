#pragma once

#include <memory>

#include "hal/config/range.hpp"
#include "hal/hand.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// Limits of requests and states at the last gate before the hand.
struct HandGuardConfig {
  double max_torque_nm = 1.0;
  double stale_s = 0.1;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_torque_nm", max_torque_nm, kPositive, "Max closing torque at the fingertips (N m).");
    v("stale_s", stale_s, kPositive, "A state older than this is no state (s).");
  }
};

/// A Hand around a Hand: no NaN, no angle or torque out of range passes in either direction; preshape() is
/// refused while the inner hand is held or was closed and not released (I4: a loaded hand opens on release()
/// alone).
class GuardedHand final : public Hand {
 public:
  /// With a clock (that of the states' time stamps, outliving the guard) a state's age is judged too.
  GuardedHand(std::unique_ptr<Hand> inner, const HandGuardConfig& config, const Clock* clock = nullptr);
  ~GuardedHand() override;
  Result<> configure() override;
  Result<> activate() override;
  void deactivate() noexcept override;
  DeviceHealth health() const override;
  Result<HandState> state() override;
  Result<> preshape(double spread_rad) override;
  Result<> close(double torque_nm) override;
  Result<> release() override;
  [[nodiscard]] std::vector<std::string> realtime() const override;
  void stop() noexcept override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal
