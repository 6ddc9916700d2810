#include "sim_hal/emulator/hand_faults.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

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
    Row{"unplug", Kind::Down, 0, 0, 0},
};
constexpr std::array<std::string_view, kHandPucks> kPuckNames{"F1", "F2", "F3", "spread"};

tl::unexpected<hal::Error> bad(std::string_view text, std::string because) {
  return hal::failure(hal::ErrorCode::BadInput, fmt::format("fault \"{}\"", text), std::move(because));
}

std::optional<double> number(std::string_view text) {
  double v = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(v)) return std::nullopt;
  return v;
}

/// Cuts off what follows the last `mark`.
std::optional<std::string_view> cut(std::string_view& text, char mark) {
  const std::size_t at = text.rfind(mark);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view tail = text.substr(at + 1);
  text = text.substr(0, at);
  return tail;
}

/// "KIND[=VALUE][@PUCK]"
hal::Result<> read_kind(std::string_view text, std::string_view what, HandFault& f) {
  if (const auto puck = cut(what, '@')) {
    for (std::size_t p = 0; p < kHandPucks; ++p)
      if (*puck == kPuckNames[p] || *puck == fmt::format("{}", p + 1)) f.puck = p;
    if (!f.puck) return bad(text, fmt::format("the puck is \"{}\", expected F1, F2, F3 or spread", *puck));
  }
  const auto value = cut(what, '=');
  const auto* row = std::find_if(kRows.begin(), kRows.end(), [&](const Row& r) { return r.name == what; });
  if (row == kRows.end())
    return bad(text, fmt::format("\"{}\" is no fault of the hand; there are {}", what, hand_fault_names()));
  f.kind = row->kind;
  f.value = row->value;
  if (f.puck && f.kind >= Kind::BrownOut) return bad(text, fmt::format("{} is of the whole hand", what));
  if (!value) return {};
  if (row->least == row->most) return bad(text, fmt::format("{} takes no value", row->name));
  const auto v = number(value->ends_with('%') ? value->substr(0, value->size() - 1) : *value);
  if (!v || *v < row->least || *v > row->most)
    return bad(text, fmt::format("the value of {} is \"{}\", expected a number from {:g} to {:g}", row->name,
                                 *value, row->least, row->most));
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
  HandFault f;
  f.text = std::string(text);
  const std::size_t first = text.find(':');
  if (first == std::string_view::npos)
    return bad(text, "expected T:KIND[=VALUE][@PUCK][:DURATION], as in 4.0:silent@F2");
  const auto at = number(text.substr(0, first));
  if (!at || *at < 0.0)
    return bad(text, fmt::format("the time is \"{}\", expected seconds from 0", text.substr(0, first)));
  f.at_s = *at;
  std::string_view what = text.substr(first + 1);
  if (const auto duration = cut(what, ':')) {
    const auto d = number(*duration);
    if (!d || *d <= 0.0)
      return bad(text, fmt::format("the duration is \"{}\", expected seconds above 0", *duration));
    f.for_s = *d;
  }
  if (auto done = read_kind(text, what, f); !done) return tl::unexpected(done.error());
  return f;
}

hal::Result<HandFault> hand_fault(const DeviceFaultEvent& event) {
  HandFault f;
  f.text = fmt::format("{:g}:{}:{:g}", event.at_s, event.action, event.for_s);
  f.at_s = event.at_s;
  f.for_s = event.for_s;
  if (auto done = read_kind(f.text, event.action, f); !done) {
    hal::Error error = done.error();
    error.code = hal::ErrorCode::BadConfig;
    return tl::unexpected(std::move(error));
  }
  return f;
}

}  // namespace colift::sim_hal
