#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/can_log/can_log_writer.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/hand.hpp"

namespace colift::hal {

/// A call of the driver as a log tells it.
struct HandCall {
  enum class Kind : std::uint8_t { Configure, Activate, Deactivate, Preshape, Close, Release, Stop };
  Kind kind{};
  double value = 0.0;  ///< rad of Preshape, N m of Close.
  Timestamp at{0};     ///< As the log counts.
  std::uint32_t line = 0;
  std::optional<bool> moving, held;  ///< As the hand was, when the log says so.
  std::string outcome;               ///< "ok", or the error's kind; empty when the log does not say.
};
[[nodiscard]] std::string_view to_string(HandCall::Kind kind) noexcept;
[[nodiscard]] std::string outcome_word(const Result<>& result);

/// What a log's notes say. Lines that are no notes of ours are passed over.
struct HandNotes {
  std::vector<HandCall> calls;
  BarrettHandConfig config;      ///< As the driver had it.
  Timestamp clock_minus_log{0};  ///< To be added to a time of the log for the driver's clock.
};
/// Errors: BadInput with the line, for a call or a setting that is not readable.
[[nodiscard]] Result<HandNotes> read_hand_notes(const Candump& log, const std::string& name);

/// Notes the settings and the clock; once, before the driver's first call.
void note_hand_settings(CanLogWriter& log, const BarrettHandConfig& config, const Clock& clock);

/// A hand whose calls, but state(), go into a log. Log and clock outlive it.
class LoggedHand final : public Hand {
 public:
  LoggedHand(std::unique_ptr<Hand> inner, CanLogWriter& log, const Clock& clock)
      : inner_(std::move(inner)), log_(log), clock_(clock) {}

  Result<> configure() override;
  Result<> activate() override;
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override { return inner_->health(); }
  Result<HandState> state() override;
  Result<> preshape(double spread_rad) override;
  Result<> close(double torque_nm) override;
  Result<> release() override;
  [[nodiscard]] std::vector<std::string> realtime() const override { return inner_->realtime(); }
  void stop() noexcept override;

 private:
  void note(HandCall::Kind kind, double value) noexcept;
  Result<> noted(Result<> result) noexcept;

  std::unique_ptr<Hand> inner_;
  CanLogWriter& log_;
  const Clock& clock_;
  std::optional<bool> moving_, held_;  ///< Of the last state.
  std::atomic<bool> stopped_{false};   ///< stop() comes from any thread, the log is of one.
};

}  // namespace colift::hal
