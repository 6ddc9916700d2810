#pragma once

#include <memory>

#include "hal/hand.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// A hand that runs by itself: a thread of its own asks the inner hand for its state again and again, as
/// BarrettHand needs it; callers get the newest state without waiting or locking. All calls but stop() and
/// health() come from one thread.
///
/// configure() runs in the caller's thread while the hand's own one rests. A command is handed over and
/// answered within some milliseconds; when the hand's thread does not take it within 50 ms (it may be opening
/// a bus again) it is taken back and fails with Timeout: nothing was done then. state() gives what was last
/// known, with its time of measurement: whoever needs it fresh looks at that (GuardedHand does).
class HandThread final : public Hand {
 public:
  explicit HandThread(std::unique_ptr<Hand> inner, Duration period = std::chrono::milliseconds(1));
  ~HandThread() override;
  HandThread(const HandThread&) = delete;
  HandThread& operator=(const HandThread&) = delete;

  Result<> configure() override;
  Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override;
  Result<HandState> state() override;
  Result<> preshape(double spread_rad) override;
  Result<> close(double torque_nm) override;
  Result<> release() override;
  /// After configure().
  [[nodiscard]] std::vector<std::string> realtime() const override;
  void stop() noexcept override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal
