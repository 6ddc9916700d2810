#include "sim_hal/emulator/video/video_faults.hpp"

#include <array>

namespace colift::sim_hal {
namespace {

using Kind = VideoFault::Kind;

using Row = FaultKind<Kind>;

constexpr std::array kKinds{
    Row{"unplug", Kind::Unplug},
    Row{"silent", Kind::Silent},
    Row{"drop", Kind::Silent},
    Row{"slow", Kind::Slow, 5, 0.5, 29},
    Row{"late", Kind::Late, 200, 1, 2000},
    Row{"hang", Kind::Hang},
    Row{"short", Kind::Short, 50, 0, 99},
    Row{"damaged", Kind::Damaged},
    Row{"jump", Kind::Jump, 500, -10000, 10000},
    Row{"restamp", Kind::Restamp},
    Row{"foreign", Kind::Foreign},
    Row{"blind", Kind::Blind},
    Row{"freeze", Kind::Freeze},
};

/// "KIND[=VALUE]"
hal::Result<> read_kind(std::string_view text, std::string_view what, VideoFault& f) {
  return read_kind_and_value(text, what, kKinds, "video device", f);
}

}  // namespace

hal::Result<VideoFault> parse_video_fault(std::string_view text) {
  return parse_fault<VideoFault>(text, "T:KIND[=VALUE][:DURATION], as in 4.0:unplug:2", read_kind);
}

hal::Result<VideoFault> video_fault(const DeviceFaultEvent& event) {
  return fault_of_scenario<VideoFault>(event, read_kind);
}

}  // namespace colift::sim_hal
