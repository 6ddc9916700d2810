#include "hal/drivers/barrett_can/make_barrett_hand.hpp"

#include <utility>

#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "hal/drivers/barrett_can/hand_thread.hpp"

namespace colift::hal {
namespace {

class OwnedBarrettHand final : public Hand {
 public:
  OwnedBarrettHand(std::unique_ptr<CanBus> bus, const BarrettHandConfig& config)
      : bus_(std::move(bus)), thread_(std::make_unique<BarrettHand>(*bus_, config, clock_)) {}
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
  // in this order: the thread ends before what it uses
  SteadyClock clock_;
  std::unique_ptr<CanBus> bus_;
  HandThread thread_;
};

}  // namespace

std::unique_ptr<Hand> make_barrett_hand(std::unique_ptr<CanBus> bus, const BarrettHandConfig& config) {
  return std::make_unique<OwnedBarrettHand>(std::move(bus), config);
}

}  // namespace colift::hal
