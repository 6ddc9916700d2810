#pragma once

#include <memory>

#include "hal/can_log/can_log_writer.hpp"

namespace colift::hal {

/// A bus whose frames, in both directions, also go into a log. Costs a copy into the log's queue. The clock
/// has to be that of the bus's own time stamps; clock and log outlive the bus.
class LoggedCanBus final : public CanBus {
 public:
  LoggedCanBus(std::unique_ptr<CanBus> inner, CanLogWriter& log, const Clock& clock)
      : inner_(std::move(inner)), log_(log), clock_(clock) {}

  Result<> open() override {
    auto opened = inner_->open();
    log_.note(ShortText(opened ? "bus open" : "bus does not open"), clock_.now());
    return opened;
  }
  void close() noexcept override { inner_->close(); }
  [[nodiscard]] Received receive(CanFrame& into, Duration timeout) noexcept override {
    const Received came = inner_->receive(into, timeout);
    if (came == Received::Frame) log_.frame(into, into.arrived_at, CandumpFrame::Direction::Received);
    return came;
  }
  [[nodiscard]] Sent send(const CanFrame& frame) noexcept override {
    const Timestamp at = clock_.now();
    const Sent sent = inner_->send(frame);
    if (sent == Sent::Yes) log_.frame(frame, at, CandumpFrame::Direction::Sent);
    return sent;
  }
  [[nodiscard]] CanHealth health() const noexcept override { return inner_->health(); }

 private:
  std::unique_ptr<CanBus> inner_;
  CanLogWriter& log_;
  const Clock& clock_;
};

}  // namespace colift::hal
