#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "hal/types/result.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

// What the faults of all emulated devices have in common: a time, a kind out of the device's table, a value,
// and the text "T:KIND[=VALUE]...[:DURATION]" (times in s) that they are read from.

/// When something goes wrong, and how much.
struct TimedFault {
  double at_s = 0.0, for_s = 0.5;
  double value = 0.0;
  std::string text;  ///< As it was asked for.

  [[nodiscard]] bool active(double t_s) const { return t_s >= at_s && t_s < at_s + for_s; }
  /// Over by then; what has not begun never does.
  void end(double t_s) {
    for_s = std::clamp(t_s - at_s, 0.0, for_s);
    if (at_s >= t_s) at_s = std::numeric_limits<double>::infinity();
  }
};

/// A row of a device's table. Several names may stand for one kind: scenarios have words of their own.
template <class Kind>
struct FaultKind {
  std::string_view name;
  Kind kind{};
  double value = 0.0, min = 0.0, max = 0.0;  ///< Default and range; an empty range: it takes no value.
};

struct TimedText {
  double at_s = 0.0;
  std::optional<double> for_s;
  std::string_view what;  ///< Lies in the text that was read.
};

/// `expected` says the form, for who wrote another. Errors: BadInput.
[[nodiscard]] hal::Result<TimedText> read_timed(std::string_view text, std::string_view expected);

/// A finite number and nothing else.
[[nodiscard]] std::optional<double> read_number(std::string_view text);

/// Cuts off what follows the last `mark`; nullopt without one.
[[nodiscard]] std::optional<std::string_view> cut_after(std::string_view& text, char mark);

[[nodiscard]] tl::unexpected<hal::Error> bad_fault(std::string_view text, std::string reason);

/// The value of a kind of fault, in its range. Errors: BadInput.
[[nodiscard]] hal::Result<double> read_fault_value(std::string_view text, std::string_view name, double min,
                                                   double max, std::string_view value);

/// The row of a device's table. Errors: BadInput, with all names.
template <class Table>
[[nodiscard]] hal::Result<typename Table::value_type> find_fault(std::string_view text, std::string_view name,
                                                                 const Table& kinds,
                                                                 std::string_view device) {
  const auto row = std::find_if(kinds.begin(), kinds.end(), [&](const auto& k) { return k.name == name; });
  if (row != kinds.end()) return *row;
  std::string all;
  for (const auto& k : kinds) all += fmt::format("{}{}", all.empty() ? "" : ", ", k.name);
  return bad_fault(text, fmt::format("\"{}\" is no fault of the {}; there are {}", name, device, all));
}

/// "KIND[=VALUE]" into a fault that has a kind and a value. Errors: BadInput.
template <class Fault, class Table>
[[nodiscard]] hal::Result<> read_kind_and_value(std::string_view text, std::string_view what,
                                                const Table& kinds, std::string_view device, Fault& f) {
  const auto value = cut_after(what, '=');
  const auto row = find_fault(text, what, kinds, device);
  if (!row) return tl::unexpected(row.error());
  f.kind = row->kind;
  f.value = row->value;
  if (!value) return {};
  const auto v = read_fault_value(text, row->name, row->min, row->max, *value);
  if (!v) return tl::unexpected(v.error());
  f.value = *v;
  return {};
}

/// "T:KIND...[:DURATION]" into a Fault. Errors: BadInput.
template <class Fault, class ReadKind>
[[nodiscard]] hal::Result<Fault> parse_fault(std::string_view text, std::string_view expected,
                                             ReadKind&& read) {
  const auto timed = read_timed(text, expected);
  if (!timed) return tl::unexpected(timed.error());
  Fault f;
  f.text = std::string(text);
  f.at_s = timed->at_s;
  f.for_s = timed->for_s.value_or(f.for_s);
  if (auto done = read(text, timed->what, f); !done) return tl::unexpected(done.error());
  return f;
}

[[nodiscard]] std::string text_of(const DeviceFaultEvent& event);

/// One of a scenario's `faults`, whose `do` is a KIND. Errors: BadConfig.
template <class Fault, class ReadKind>
[[nodiscard]] hal::Result<Fault> fault_of_scenario(const DeviceFaultEvent& event, ReadKind&& read) {
  Fault f;
  f.text = text_of(event);
  f.at_s = event.at_s;
  f.for_s = event.for_s;
  std::string what = event.action;
  if (event.value) what += fmt::format("={:g}", *event.value);
  if (!event.puck.empty()) what += "@" + event.puck;
  if (auto done = read(f.text, what, f); !done) {
    hal::Error error = done.error();
    error.code = hal::ErrorCode::BadConfig;
    return tl::unexpected(std::move(error));
  }
  return f;
}

/// All faults of one device: those of a scenario, then those of a command line. Errors: those of the two
/// readers.
template <class OfEvent, class OfText>
[[nodiscard]] auto faults_of(std::string_view device, const std::vector<DeviceFaultEvent>& events,
                             const std::vector<std::string>& texts, OfEvent of_event, OfText of_text) {
  using Fault = typename decltype(of_text(std::string_view()))::value_type;
  std::vector<Fault> faults;
  hal::Result<> done;
  const auto add = [&](hal::Result<Fault> fault) {
    if (!done) return;
    if (fault)
      faults.push_back(std::move(*fault));
    else
      done = tl::unexpected(fault.error());
  };
  for (const DeviceFaultEvent& event : events)
    if (event.device == device && event.action != "push") add(of_event(event));  // the world pushes
  for (const std::string& text : texts) add(of_text(text));
  if (!done) return hal::Result<std::vector<Fault>>(tl::unexpected(done.error()));
  return hal::Result<std::vector<Fault>>(std::move(faults));
}

}  // namespace colift::sim_hal
