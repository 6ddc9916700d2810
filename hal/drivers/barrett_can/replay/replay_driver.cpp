#include "hal/drivers/barrett_can/replay/replay_driver.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/drivers/barrett_can/barrett_hand.hpp"
#include "hal/drivers/barrett_can/replay/hand_log.hpp"

namespace colift::hal {
namespace {

constexpr Duration kPoll = std::chrono::milliseconds(1);  // as HandThread
// Who calls as soon as a motion has ended sees that end some milliseconds earlier or later.
constexpr Duration kSameState = std::chrono::milliseconds(200);
constexpr Duration kMost = std::chrono::hours(24);

Result<> call(BarrettHand& hand, const HandCall& call) {
  switch (call.kind) {
    case HandCall::Kind::Configure:
      return hand.configure();
    case HandCall::Kind::Activate:
      return hand.activate();
    case HandCall::Kind::Deactivate:
      hand.deactivate();
      return {};
    case HandCall::Kind::Preshape:
      return hand.preshape(call.value);
    case HandCall::Kind::Close:
      return hand.close(call.value);
    case HandCall::Kind::Release:
      return hand.release();
    case HandCall::Kind::Stop:
      hand.stop();
      return {};
  }
  return {};
}

}  // namespace

Result<DriverReplay> replay_driver(const Candump& log, const std::string& name) {
  const auto notes = read_hand_notes(log, name);
  if (!notes) return tl::unexpected(notes.error());
  if (notes->calls.empty() || log.frames.empty())
    return failure(ErrorCode::NotFound, name,
                   "names no calls of the hand, as a log of --bus-log does: only the emulator can be asked");
  const Duration shift = notes->clock_minus_log;
  const Timestamp first = std::min(notes->calls.front().at, log.frames.front().frame.arrived_at);
  const Timestamp last = std::max(notes->calls.back().at, log.frames.back().frame.arrived_at);
  if (last - first > kMost || first + shift < Timestamp{0})
    return failure(ErrorCode::BadInput, name,
                   "its times are no session: over a day, or before the clock began");

  ManualClock clock;
  clock.advance(first + shift);
  barrett::RecordedPucks pucks(log.frames, shift, clock);
  BarrettHand hand(pucks, notes->config, clock);
  bool configured = false;
  const auto run_until = [&](Timestamp until) {
    while (clock.now() < until) {
      if (configured) (void)hand.state();
      if (clock.now() < until) clock.advance(std::min<Duration>(kPoll, until - clock.now()));
    }
  };
  for (const HandCall& c : notes->calls) {
    run_until(c.at + shift);
    for (const Timestamp end = clock.now() + kSameState; configured && c.moving && clock.now() < end;) {
      const auto state = hand.state();
      if (state && state->moving == *c.moving && state->held == *c.held) break;
      clock.advance(kPoll);
    }
    const auto result = call(hand, c);
    if (c.kind == HandCall::Kind::Configure) configured = true;
    if (!c.outcome.empty() && outcome_word(result) != c.outcome)
      pucks.note_difference(c.line, fmt::format("{} was {} then and is {} now{}", to_string(c.kind),
                                                c.outcome, outcome_word(result),
                                                result ? "" : fmt::format(" ({})", result.error().detail)));
  }
  run_until(pucks.end());
  DriverReplay replay;
  static_cast<barrett::ReplayFindings&>(replay) = pucks.finish();
  replay.calls = notes->calls.size();
  replay.recorded_s = seconds(last - first);
  return replay;
}

}  // namespace colift::hal
