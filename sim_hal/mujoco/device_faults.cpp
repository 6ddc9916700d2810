#include "sim_hal/mujoco/device_faults.hpp"

#include <cmath>

namespace colift::sim_hal {

Fault fault_now(const SimWorld& world, std::string_view device) {
  const auto ms = [](double s) { return std::chrono::milliseconds(std::llround(1000.0 * s)); };
  const hal::Duration now = world.elapsed();
  for (const DeviceFaultEvent& event : world.scenario().faults) {
    if (event.device != device || now < ms(event.at_s) || now >= ms(event.at_s + event.for_s)) continue;
    if (event.action == "drop" || event.action == "silent") return Fault::Drop;
    if (event.action == "freeze") return Fault::Freeze;
    if (event.action == "late") return Fault::Late;
    if (event.action == "corrupt") return Fault::Corrupt;
    if (event.action == "unplug") return Fault::Unplug;
  }
  return Fault::None;
}

}  // namespace colift::sim_hal
