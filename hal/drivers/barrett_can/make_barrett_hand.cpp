#include "hal/drivers/barrett_can/make_barrett_hand.hpp"

#include <utility>

#include "hal/can_log/logged_can_bus.hpp"
#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "hal/drivers/barrett_can/hand_thread.hpp"
#include "hal/drivers/barrett_can/replay/hand_log.hpp"

namespace colift::hal {
namespace {

class OwnedBarrettHand final : public Hand {
 public:
  OwnedBarrettHand(std::unique_ptr<CanBus> bus, const BarrettHandConfig& config,
                   std::unique_ptr<CanLogWriter> log)
      : log_(std::move(log)), bus_(logged(std::move(bus))), thread_(driver(config)) {}
  Result<> configure() override { return thread_.configure(); }
  Result<> activate() override { return thread_.activate(); }
  void deactivate() noexcept override { thread_.deactivate(); }
  [[nodiscard]] DeviceHealth health() const override { return thread_.health(); }
  Result<HandState> state() override { return thread_.state(); }
  Result<> preshape(double spread_rad) override { return thread_.preshape(spread_rad); }
  Result<> close(double torque_nm) override { return thread_.close(torque_nm); }
  Result<> release() override { return thread_.release(); }
  [[nodiscard]] std::vector<std::string> realtime() const override { return thread_.realtime(); }
  void stop() noexcept override { thread_.stop(); }

 private:
  std::unique_ptr<CanBus> logged(std::unique_ptr<CanBus> bus) {
    if (!log_) return bus;
    return std::make_unique<LoggedCanBus>(std::move(bus), *log_, clock_);
  }
  std::unique_ptr<Hand> driver(const BarrettHandConfig& config) {
    auto hand = std::make_unique<BarrettHand>(*bus_, config, clock_);
    if (!log_) return hand;
    note_hand_settings(*log_, config, clock_);
    return std::make_unique<LoggedHand>(std::move(hand), *log_, clock_);
  }

  // in this order: the thread ends before what it uses
  SteadyClock clock_;
  std::unique_ptr<CanLogWriter> log_;
  std::unique_ptr<CanBus> bus_;
  HandThread thread_;
};

}  // namespace

std::unique_ptr<Hand> make_barrett_hand(std::unique_ptr<CanBus> bus, const BarrettHandConfig& config,
                                        std::unique_ptr<CanLogWriter> log) {
  return std::make_unique<OwnedBarrettHand>(std::move(bus), config, std::move(log));
}

Result<std::unique_ptr<CanLogWriter>> make_bus_log(const BarrettHandConfig& config) {
  if (config.bus_log.empty()) return nullptr;
  const std::size_t before = config.can.find_last_of(":/");
  return CanLogWriter::create(config.bus_log,
                              before == std::string::npos ? config.can : config.can.substr(before + 1),
                              to_wall_clock());
}

}  // namespace colift::hal
