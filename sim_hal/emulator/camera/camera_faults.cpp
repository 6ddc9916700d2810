#include "sim_hal/emulator/camera/camera_faults.hpp"

#include <array>

namespace colift::sim_hal {
namespace {

using Kind = CameraFault::Kind;

using Row = FaultKind<Kind>;

constexpr std::array kKinds{
    Row{"unplug", Kind::Unplug},
    Row{"silent", Kind::Silent},
    Row{"drop", Kind::Silent},
    Row{"slow", Kind::Slow, 5, 0.5, 29},
    Row{"late", Kind::Late, 200, 1, 2000},
    Row{"double", Kind::Double},
    Row{"swap", Kind::Swap},
    Row{"packets", Kind::Packets, 3, 1, 5},
    Row{"short", Kind::Short},
    Row{"clock", Kind::Clock, 20, -30, 30},
    Row{"blind", Kind::Blind},
    Row{"zeros", Kind::Zeros},
    Row{"half", Kind::Half, 50, 1, 100},
    Row{"corrupt", Kind::Corrupt, 50, 1, 100},
    Row{"freeze", Kind::Freeze},
    Row{"restamp", Kind::Restamp},
    Row{"moved", Kind::Moved, 5, -45, 45},
    Row{"hang", Kind::Hang},
    Row{"crash", Kind::Crash},
};

/// "KIND[=VALUE]"
hal::Result<> read_kind(std::string_view text, std::string_view what, CameraFault& f) {
  return read_kind_and_value(text, what, kKinds, "camera", f);
}

}  // namespace

hal::Result<CameraFault> parse_camera_fault(std::string_view text) {
  return parse_fault<CameraFault>(text, "T:KIND[=VALUE][:DURATION], as in 4.0:unplug:2", read_kind);
}

hal::Result<CameraFault> camera_fault(const DeviceFaultEvent& event) {
  return fault_of_scenario<CameraFault>(event, read_kind);
}

}  // namespace colift::sim_hal
