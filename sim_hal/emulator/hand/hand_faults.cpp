#include "sim_hal/emulator/hand/hand_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "sim_hal/emulator/fault_text.hpp"

namespace colift::sim_hal {
namespace {

using Kind = HandFault::Kind;

struct Row {
  std::string_view name;
  Kind kind;
  double value, least, most;  // default and range
};

// several names for one kind: scenarios have words of their own
constexpr std::array kRows{
    Row{"silent", Kind::Silent, 0, 0, 0},
    Row{"loss", Kind::Loss, 100, 0, 100},
    Row{"drop", Kind::Loss, 100, 0, 100},
    Row{"late", Kind::Late, 15, 0, 10000},
    Row{"duplicate", Kind::Duplicate, 0, 0, 0},
    Row{"corrupt", Kind::Corrupt, 100, 0, 100},
    Row{"wrong", Kind::Wrong, 0, 0, 0},
    Row{"reset", Kind::Reset, 0, 0, 0},
    Row{"error", Kind::Error, 1, 1, 32767},
    Row{"hot", Kind::Hot, 75, -40, 200},
    Row{"stuck", Kind::Stuck, 0, 0, 0},
    Row{"freeze", Kind::Freeze, 0, 0, 0},
    Row{"jump", Kind::Jump, 20000, -2e6, 2e6},
    Row{"brown-out", Kind::BrownOut, 0, 0, 0},
    Row{"off", Kind::Off, 0, 0, 0},
    Row{"foreign", Kind::Foreign, 0, 0, 0},
    Row{"bus-off", Kind::BusOff, 0, 0, 0},
    Row{"down", Kind::Down, 0, 0, 0},
    Row{"noise", Kind::Noise, 0, 0, 0},
    Row{"full", Kind::Full, 0, 0, 0},
    Row{"passive", Kind::Passive, 0, 0, 0},
    Row{"unplug", Kind::Down, 0, 0, 0},
};
constexpr std::array<std::string_view, kHandPucks> kPuckNames{"F1", "F2", "F3", "spread"};

/// "KIND[=VALUE][@PUCK]"
hal::Result<> read_kind(std::string_view text, std::string_view what, HandFault& f) {
  if (const auto puck = cut_after(what, '@')) {
    for (std::size_t p = 0; p < kHandPucks; ++p)
      if (*puck == kPuckNames[p] || *puck == fmt::format("{}", p + 1)) f.puck = p;
    if (!f.puck)
      return bad_fault(text, fmt::format("the puck is \"{}\", expected F1, F2, F3 or spread", *puck));
  }
  const auto value = cut_after(what, '=');
  const auto* row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return r.name == what; });
  if (row == kRows.end())
    return bad_fault(text,
                     fmt::format("\"{}\" is no fault of the hand; there are {}", what, hand_fault_names()));
  f.kind = row->kind;
  f.value = row->value;
  if (f.puck && f.kind >= Kind::BrownOut)
    return bad_fault(text, fmt::format("{} is of the whole hand", what));
  if (!value) return {};
  if (row->least == row->most) return bad_fault(text, fmt::format("{} takes no value", row->name));
  const auto v = read_number(value->ends_with('%') ? value->substr(0, value->size() - 1) : *value);
  if (!v || *v < row->least || *v > row->most)
    return bad_fault(text, fmt::format("the value of {} is \"{}\", expected a number from {:g} to {:g}",
                                       row->name, *value, row->least, row->most));
  f.value = *v;
  return {};
}

}  // namespace

std::string hand_fault_names() {
  std::string all;
  for (const Row& row : kRows) all += fmt::format("{}{}", all.empty() ? "" : ", ", row.name);
  return all;
}

hal::Result<HandFault> parse_hand_fault(std::string_view text) {
  return parse_fault<HandFault>(text, "T:KIND[=VALUE][@PUCK][:DURATION], as in 4.0:silent@F2", read_kind);
}

hal::Result<HandFault> hand_fault(const DeviceFaultEvent& event) {
  return fault_of_scenario<HandFault>(event, read_kind);
}

}  // namespace colift::sim_hal
