#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>
#include <string_view>

#include "hal/types/result.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

// What the words for faults of all emulated devices have in common: "T:WHAT[:DURATION]", times in s.

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

[[nodiscard]] tl::unexpected<hal::Error> bad_fault(std::string_view text, std::string because);

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

}  // namespace colift::sim_hal
