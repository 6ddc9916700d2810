#include "sim_hal/emulator/fault_text.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <utility>

namespace colift::sim_hal {

tl::unexpected<hal::Error> bad_fault(std::string_view text, std::string reason) {
  return hal::failure(hal::ErrorCode::BadInput, fmt::format("fault \"{}\"", text), std::move(reason));
}

std::optional<double> read_number(std::string_view text) {
  double v = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), v);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(v)) return std::nullopt;
  return v;
}

std::optional<std::string_view> cut_after(std::string_view& text, char mark) {
  const std::size_t at = text.rfind(mark);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view tail = text.substr(at + 1);
  text = text.substr(0, at);
  return tail;
}

hal::Result<TimedText> read_timed(std::string_view text, std::string_view expected) {
  TimedText t;
  const std::size_t first = text.find(':');
  if (first == std::string_view::npos) return bad_fault(text, fmt::format("expected {}", expected));
  const auto at = read_number(text.substr(0, first));
  if (!at || *at < 0.0)
    return bad_fault(text, fmt::format("the time is \"{}\", expected seconds from 0", text.substr(0, first)));
  t.at_s = *at;
  t.what = text.substr(first + 1);
  if (const auto duration = cut_after(t.what, ':')) {
    t.for_s = read_number(*duration);
    if (!t.for_s || *t.for_s <= 0.0)
      return bad_fault(text, fmt::format("the duration is \"{}\", expected seconds above 0", *duration));
  }
  return t;
}

hal::Result<double> read_fault_value(std::string_view text, std::string_view name, double min, double max,
                                     std::string_view value) {
  if (!(min < max)) return bad_fault(text, fmt::format("{} takes no value", name));
  const auto v = read_number(value);
  if (v && *v >= min && *v <= max) return *v;
  return bad_fault(text, fmt::format("the value of {} is \"{}\", expected a number from {:g} to {:g}", name,
                                     value, min, max));
}

std::string text_of(const DeviceFaultEvent& event) {
  return fmt::format("{:g}:{}:{:g}", event.at_s, event.action, event.for_s);
}

}  // namespace colift::sim_hal
