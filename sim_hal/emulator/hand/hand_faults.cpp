#include "sim_hal/emulator/hand/hand_faults.hpp"

#include <fmt/format.h>

#include <array>

namespace colift::sim_hal {
namespace {

using Kind = HandFault::Kind;

using Row = FaultKind<Kind>;

constexpr std::array kKinds{
    Row{"silent", Kind::Silent},
    Row{"loss", Kind::Loss, 100, 0, 100},
    Row{"drop", Kind::Loss, 100, 0, 100},
    Row{"late", Kind::Late, 15, 0, 10000},
    Row{"duplicate", Kind::Duplicate},
    Row{"corrupt", Kind::Corrupt, 100, 0, 100},
    Row{"wrong", Kind::Wrong},
    Row{"reset", Kind::Reset},
    Row{"error", Kind::Error, 1, 1, 32767},
    Row{"hot", Kind::Hot, 75, -40, 200},
    Row{"stuck", Kind::Stuck},
    Row{"freeze", Kind::Freeze},
    Row{"jump", Kind::Jump, 20000, -2e6, 2e6},
    Row{"turn", Kind::Turn, 3000, -20000, 20000},
    Row{"weight", Kind::Weight, 0.3, -3, 3},
    Row{"master", Kind::Master, 900, 0, 5000},
    Row{"altered", Kind::Altered, 900, 0, 5000},
    Row{"brown-out", Kind::BrownOut},
    Row{"off", Kind::Off},
    Row{"sag", Kind::Sag, 20, 18, 48},
    Row{"foreign", Kind::Foreign},
    Row{"bus-off", Kind::BusOff},
    Row{"down", Kind::Down},
    Row{"noise", Kind::Noise},
    Row{"full", Kind::Full},
    Row{"passive", Kind::Passive},
    Row{"unplug", Kind::Down},
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
  const auto row = find_fault(text, what, kKinds, "hand");
  if (!row) return tl::unexpected(row.error());
  f.kind = row->kind;
  f.value = row->value;
  if (f.kind == Kind::Turn && f.puck.value_or(kHandSpread) != kHandSpread)
    return bad_fault(text, "a finger's worm cannot be turned from outside; only the spread has none");
  if (f.kind == Kind::Turn) f.puck = kHandSpread;
  if (f.kind == Kind::Weight && f.puck == kHandSpread)
    return bad_fault(text, "the spread has no strain gauge; a weight hangs on F1, F2 or F3");
  if (f.puck && f.kind >= Kind::BrownOut)
    return bad_fault(text, fmt::format("{} is of the whole hand", what));
  if (!value) return {};
  const auto v = read_fault_value(text, row->name, row->min, row->max,
                                  value->ends_with('%') ? value->substr(0, value->size() - 1) : *value);
  if (!v) return tl::unexpected(v.error());
  f.value = *v;
  return {};
}

}  // namespace

hal::Result<HandFault> parse_hand_fault(std::string_view text) {
  return parse_fault<HandFault>(text, "T:KIND[=VALUE][@PUCK][:DURATION], as in 4.0:silent@F2", read_kind);
}

hal::Result<HandFault> hand_fault(const DeviceFaultEvent& event) {
  return fault_of_scenario<HandFault>(event, read_kind);
}

}  // namespace colift::sim_hal
