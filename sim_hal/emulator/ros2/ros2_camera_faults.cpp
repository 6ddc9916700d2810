#include "sim_hal/emulator/ros2/ros2_camera_faults.hpp"

#include <array>

namespace colift::sim_hal {
namespace {

using Kind = Ros2CameraFault::Kind;
using Row = FaultKind<Kind>;

constexpr std::array kRos2Kinds{
    Row{"unplug", Kind::Unplug},
    Row{"silent", Kind::Silent},
    Row{"drop", Kind::Silent},
    Row{"slow", Kind::Slow, 5, 0.5, 29},
    Row{"late", Kind::Late, 200, 1, 2000},
    Row{"jump", Kind::Jump, 500, -10000, 10000},
    Row{"restamp", Kind::Restamp},
    Row{"short", Kind::Short, 50, 0, 99},
    Row{"resized", Kind::Resized},
    Row{"blind", Kind::Blind},
    Row{"freeze", Kind::Freeze},
};

/// "KIND[=VALUE]"
hal::Result<> read_ros2_kind(std::string_view text, std::string_view what, Ros2CameraFault& f) {
  return read_kind_and_value(text, what, kRos2Kinds, "camera over ROS 2", f);
}

}  // namespace

hal::Result<Ros2CameraFault> parse_ros2_camera_fault(std::string_view text) {
  return parse_fault<Ros2CameraFault>(text, "T:KIND[=VALUE][:DURATION], as in 4.0:unplug:2", read_ros2_kind);
}

hal::Result<Ros2CameraFault> ros2_camera_fault(const DeviceFaultEvent& event) {
  return fault_of_scenario<Ros2CameraFault>(event, read_ros2_kind);
}

}  // namespace colift::sim_hal
