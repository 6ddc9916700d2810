#include "sim_hal/emulator/camera/camera_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sim_hal/emulator/fault_text.hpp"

namespace colift::sim_hal {
namespace {

using Kind = CameraFault::Kind;

struct Row {
  std::string_view name;
  Kind kind;
  double value, least, most;  // default and range
};

// several names for one kind: scenarios have words of their own
constexpr std::array kRows{
    Row{"unplug", Kind::Unplug, 0, 0, 0},  Row{"silent", Kind::Silent, 0, 0, 0},
    Row{"drop", Kind::Silent, 0, 0, 0},    Row{"slow", Kind::Slow, 5, 0.5, 29},
    Row{"late", Kind::Late, 200, 1, 2000}, Row{"double", Kind::Double, 0, 0, 0},
    Row{"swap", Kind::Swap, 0, 0, 0},      Row{"packets", Kind::Packets, 3, 1, 5},
    Row{"blind", Kind::Blind, 0, 0, 0},    Row{"zeros", Kind::Zeros, 0, 0, 0},
    Row{"half", Kind::Half, 50, 1, 100},   Row{"corrupt", Kind::Corrupt, 50, 1, 100},
    Row{"freeze", Kind::Freeze, 0, 0, 0},  Row{"restamp", Kind::Restamp, 0, 0, 0},
    Row{"moved", Kind::Moved, 5, -45, 45}, Row{"hang", Kind::Hang, 0, 0, 0},
    Row{"crash", Kind::Crash, 0, 0, 0},
};

/// "KIND[=VALUE]"
hal::Result<> read_kind(std::string_view text, std::string_view what, CameraFault& f) {
  const std::size_t equals = what.find('=');
  const std::string_view name = what.substr(0, equals);
  const auto* row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return r.name == name; });
  if (row == kRows.end())
    return bad_fault(
        text, fmt::format("\"{}\" is no fault of the camera; there are {}", name, camera_fault_names()));
  f.kind = row->kind;
  f.value = row->value;
  if (equals == std::string_view::npos) return {};
  if (row->least == row->most) return bad_fault(text, fmt::format("{} takes no value", row->name));
  const auto v = read_number(what.substr(equals + 1));
  if (!v || *v < row->least || *v > row->most)
    return bad_fault(text, fmt::format("the value of {} is \"{}\", expected a number from {:g} to {:g}",
                                       row->name, what.substr(equals + 1), row->least, row->most));
  f.value = *v;
  return {};
}

}  // namespace

std::string camera_fault_names() {
  std::string all;
  for (const Row& row : kRows) all += fmt::format("{}{}", all.empty() ? "" : ", ", row.name);
  return all;
}

hal::Result<CameraFault> parse_camera_fault(std::string_view text) {
  return parse_fault<CameraFault>(text, "T:KIND[=VALUE][:DURATION], as in 4.0:unplug:2", read_kind);
}

hal::Result<CameraFault> camera_fault(const DeviceFaultEvent& event) {
  return fault_of_scenario<CameraFault>(event, read_kind);
}

}  // namespace colift::sim_hal
