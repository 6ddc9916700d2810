#include "hal/drivers/barrett_can/replay/hand_log.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <utility>

#include "hal/config/config_file.hpp"

namespace colift::hal {
namespace {

using Kind = HandCall::Kind;

constexpr std::array<std::string_view, 7> kCalls{"configure", "activate", "deactivate", "preshape",
                                                 "close",     "release",  "stop"};
constexpr std::string_view kCall = "call ", kOutcome = "outcome ", kConfig = "config ", kClock = "clock ",
                           kState = "state ";

bool has_value(Kind kind) {
  return kind == Kind::Preshape || kind == Kind::Close;
}

std::optional<double> number(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value)) return std::nullopt;
  return value;
}

std::optional<HandCall> read_call(std::string_view text) {
  const std::size_t space = text.find(' ');
  for (std::size_t k = 0; k < kCalls.size(); ++k) {
    if (text.substr(0, space) != kCalls[k]) continue;
    HandCall call;
    call.kind = static_cast<Kind>(k);
    if (has_value(call.kind) != (space != std::string_view::npos)) return std::nullopt;
    if (!has_value(call.kind)) return call;
    const auto value = number(text.substr(space + 1));
    if (!value) return std::nullopt;
    call.value = *value;
    return call;
  }
  return std::nullopt;
}

constexpr std::array<std::string_view, 9> kCodes{"Timeout",     "LinkLost",      "BadReply",
                                                 "DeviceFault", "LimitExceeded", "NotReady",
                                                 "BadConfig",   "BadInput",      "NotFound"};

}  // namespace

std::string_view to_string(Kind kind) noexcept {
  return kCalls[static_cast<std::size_t>(kind)];
}

std::string outcome_word(const Result<>& result) {
  if (result) return "ok";
  const auto code = static_cast<std::size_t>(result.error().code);
  return std::string(code < kCodes.size() ? kCodes[code] : "error");
}

Result<HandNotes> read_hand_notes(const Candump& log, const std::string& name) {
  HandNotes notes;
  FieldTable table = table_of(notes.config);
  std::optional<bool> moving, held;
  for (const CandumpNote& note : log.notes) {
    const std::string where = fmt::format("{}:{}", name, note.line);
    const std::string_view text = note.text;
    if (text.starts_with(kCall)) {
      auto call = read_call(text.substr(kCall.size()));
      if (!call) return failure(ErrorCode::BadInput, where, "a call of the hand that nobody knows");
      call->at = note.at;
      call->line = note.line;
      call->moving = std::exchange(moving, std::nullopt);
      call->held = std::exchange(held, std::nullopt);
      notes.calls.push_back(std::move(*call));
    } else if (text.starts_with(kOutcome)) {
      if (!notes.calls.empty()) notes.calls.back().outcome = text.substr(kOutcome.size());
    } else if (text.starts_with(kState)) {
      moving = text.find("moving") != std::string_view::npos;
      held = text.find("held") != std::string_view::npos;
    } else if (text.starts_with(kClock)) {
      const auto at_s = number(text.substr(kClock.size()));
      if (!at_s || *at_s < 0.0 || *at_s > 9e9)
        return failure(ErrorCode::BadInput, where, "a clock that cannot be: expected seconds");
      notes.clock_minus_log = duration_of(*at_s) - note.at;
    } else if (text.starts_with(kConfig)) {
      auto set = apply_yaml_text(table, text.substr(kConfig.size()), where, UnknownKeys::LeftOut);
      if (!set) return failure(ErrorCode::BadInput, where, set.error().detail);
    }
  }
  if (auto good = check_fields(table, name); !good)
    return failure(ErrorCode::BadInput, name, good.error().detail);
  return notes;
}

void note_hand_settings(CanLogWriter& log, const BarrettHandConfig& config, const Clock& clock) {
  const Timestamp now = clock.now();
  log.note(ShortText(fmt::format("clock {:.6f}", seconds(now))), now);
  BarrettHandConfig copy = config;
  copy.bus_log.clear();  // of the recording, not of the hand
  const std::string all = effective_yaml(table_of(copy), false);
  for (std::string_view rest = all; !rest.empty();) {
    std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    line = line.substr(0, line.find("  #"));
    if (!line.empty()) log.note(ShortText(fmt::format("config {}", line)), now);
  }
}

void LoggedHand::note(Kind kind, double value) noexcept {
  if (moving_ && held_) {
    const std::string_view how = *moving_ ? (*held_ ? "state moving held" : "state moving")
                                          : (*held_ ? "state at rest held" : "state at rest");
    log_.note(ShortText(how), clock_.now());
  }
  std::array<char, 64> text{};
  const auto end = has_value(kind)
                       ? fmt::format_to_n(text.data(), text.size(), "call {} {}", to_string(kind), value)
                       : fmt::format_to_n(text.data(), text.size(), "call {}", to_string(kind));
  log_.note(ShortText({text.data(), std::min(end.size, text.size())}), clock_.now());
}

Result<> LoggedHand::noted(Result<> result) noexcept {
  std::array<char, 64> text{};
  const auto code = result ? std::size_t{0} : static_cast<std::size_t>(result.error().code);
  const auto end =
      fmt::format_to_n(text.data(), text.size(), "outcome {}",
                       result ? std::string_view("ok") : kCodes[std::min(code, kCodes.size() - 1)]);
  log_.note(ShortText({text.data(), std::min(end.size, text.size())}), clock_.now());
  return result;
}

Result<> LoggedHand::configure() {
  note(Kind::Configure, 0.0);
  return noted(inner_->configure());
}

Result<> LoggedHand::activate() {
  note(Kind::Activate, 0.0);
  return noted(inner_->activate());
}

void LoggedHand::deactivate() noexcept {
  note(Kind::Deactivate, 0.0);
  inner_->deactivate();
}

Result<HandState> LoggedHand::state() {
  if (stopped_.exchange(false)) note(Kind::Stop, 0.0);
  auto state = inner_->state();
  if (state) moving_ = state->moving, held_ = state->held;
  return state;
}

Result<> LoggedHand::preshape(double spread_rad) {
  note(Kind::Preshape, spread_rad);
  return noted(inner_->preshape(spread_rad));
}

Result<> LoggedHand::close(double torque_nm) {
  note(Kind::Close, torque_nm);
  return noted(inner_->close(torque_nm));
}

Result<> LoggedHand::release() {
  note(Kind::Release, 0.0);
  return noted(inner_->release());
}

void LoggedHand::stop() noexcept {
  stopped_ = true;
  inner_->stop();
}

}  // namespace colift::hal
