#include "sim_hal/emulator/krc/krc_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace colift::sim_hal {
namespace {

using Kind = KrcFault::Kind;

using Row = FaultKind<Kind>;

constexpr std::array kKinds{
    Row{"loss", Kind::Loss, 0, 1, 1e6},
    Row{"delay", Kind::Delay, 5, 0, 10000},
    Row{"reorder", Kind::Reorder},
    Row{"duplicate", Kind::Duplicate},
    Row{"corrupt", Kind::Corrupt, 100, 0, 100},
    Row{"burst", Kind::Burst, 5, 2, 1000},
    Row{"quality", Kind::Quality, 0, 0, 3},
    Row{"monitor", Kind::Monitor},
    Row{"emergency-stop", Kind::EmergencyStop},
    Row{"estop", Kind::EmergencyStop},
    Row{"drive-error", Kind::DriveError},
    Row{"drive-warning", Kind::DriveWarning},
    Row{"drives-off", Kind::DrivesOff},
    Row{"temperature", Kind::Temperature, 90, -50, 200},
    Row{"freeze", Kind::Freeze},
    Row{"jump", Kind::Jump, 0.3, -6.3, 6.3},
    Row{"nan", Kind::NotANumber},
    Row{"torque-offset", Kind::TorqueOffset, 5, -200, 200},
    Row{"contact", Kind::Contact, 30, -500, 500},
    Row{"load", Kind::LoadData, 0.2, -7, 7},
    Row{"unplug", Kind::Unplug},
    Row{"drop", Kind::Loss, 0, 1, 1e6},
    Row{"silent", Kind::Loss, 0, 1, 1e6},
    Row{"late", Kind::Delay, 15, 0, 10000},
};
constexpr std::array<std::string_view, 4> kQualities{"unacceptable", "bad", "ok", "perfect"};

hal::Result<> read_value(std::string_view text, std::string_view value, const Row& row, KrcFault& f) {
  if (const auto* quality = std::find(kQualities.begin(), kQualities.end(), value);
      f.kind == Kind::Quality && quality != kQualities.end()) {
    f.value = static_cast<double>(quality - kQualities.begin());
    return {};
  }
  if (value.ends_with('%') && row.min < row.max) {
    if (f.kind != Kind::Loss && f.kind != Kind::Corrupt)
      return bad_fault(text, fmt::format("{} takes no percentage", row.name));
    value.remove_suffix(1);
    f.percent = true;
  }
  const auto v =
      read_fault_value(text, row.name, f.percent ? 0.0 : row.min, f.percent ? 100.0 : row.max, value);
  if (!v) return tl::unexpected(v.error());
  f.value = *v;
  f.counted = f.kind == Kind::Loss && !f.percent;
  return {};
}

/// "KIND[.in|.out][=VALUE[%]][@JOINT]"
hal::Result<> read_kind(std::string_view text, std::string_view what, KrcFault& f) {
  if (const auto joint = cut_after(what, '@')) {
    const auto j = read_number(*joint);
    if (!j || *j < 1 || *j > 7 || *j != std::floor(*j))
      return bad_fault(text, fmt::format("the joint is \"{}\", expected 1 to 7", *joint));
    f.joint = static_cast<int>(*j) - 1;
  }
  const auto value = cut_after(what, '=');
  if (what.ends_with(".in")) {
    f.way = KrcFault::Direction::ToKrc;
    what.remove_suffix(3);
  } else if (what.ends_with(".out")) {
    f.way = KrcFault::Direction::ToClient;
    what.remove_suffix(4);
  }
  const auto row = find_fault(text, what, kKinds, "arm");
  if (!row) return tl::unexpected(row.error());
  f.kind = row->kind;
  f.value = row->value;
  if (what == "silent") f.way = KrcFault::Direction::ToClient;
  if (f.way != KrcFault::Direction::Both && !f.on_wire())
    return bad_fault(text, fmt::format("{} happens in the controller, it takes neither .in nor .out", what));
  if (!value) return {};
  if (auto done = read_value(text, *value, *row, f); !done) return done;
  // a number of lost datagrams means lost answers: lost measurements take their answers with them
  if (f.counted && f.way == KrcFault::Direction::Both) f.way = KrcFault::Direction::ToKrc;
  return {};
}

}  // namespace

hal::Result<KrcFault> parse_krc_fault(std::string_view text) {
  return parse_fault<KrcFault>(text, "T:KIND[.in|.out][=VALUE][@JOINT][:DURATION], as in 4.0:loss=3",
                               read_kind);
}

hal::Result<KrcFault> krc_fault(const DeviceFaultEvent& event) {
  return fault_of_scenario<KrcFault>(event, read_kind);
}

}  // namespace colift::sim_hal
