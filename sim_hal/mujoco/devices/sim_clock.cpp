#include "sim_hal/mujoco/devices/sim_devices.hpp"

namespace colift::sim_hal {
namespace {

class SimClock final : public hal::Clock {
 public:
  explicit SimClock(const hal::Clock& clock) : clock_(clock) {}
  [[nodiscard]] hal::Timestamp now() const override { return clock_.now(); }

 private:
  const hal::Clock& clock_;
};

}  // namespace

std::unique_ptr<hal::Clock> make_sim_clock(const SimWorld& world) {
  return std::make_unique<SimClock>(world.clock());
}

}  // namespace colift::sim_hal
