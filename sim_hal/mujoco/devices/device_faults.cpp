#include "sim_hal/mujoco/devices/device_faults.hpp"

#include <cmath>

namespace colift::sim_hal {

Fault fault_now(const SimWorld& world, std::string_view device) {
  const auto ms = [](double s) { return std::chrono::milliseconds(std::llround(1000.0 * s)); };
  const hal::Duration now = world.elapsed();
  for (const DeviceFaultEvent& event : world.scenario().faults) {
    if (event.device != device || !event.in_state.empty() || now < ms(event.at_s) ||
        now >= ms(event.at_s + event.for_s))
      continue;
    if (event.action == "drop" || event.action == "silent") return Fault::Drop;
    if (event.action == "freeze") return Fault::Freeze;
    if (event.action == "late") return Fault::Late;
    if (event.action == "corrupt") return Fault::Corrupt;
    if (event.action == "unplug") return Fault::Unplug;
    // of pucks and bus, as they show behind a driver
    if (device != "hand") continue;
    if (event.action == "bus-off" || event.action == "down" || event.action == "off" ||
        event.action == "reset" || event.action == "brown-out" || event.action == "error")
      return Fault::Unplug;
    if (event.action == "full" || event.action == "wrong" ||
        (event.action == "loss" && event.value.value_or(100) >= 100))
      return Fault::Drop;
  }
  return Fault::None;
}

}  // namespace colift::sim_hal
