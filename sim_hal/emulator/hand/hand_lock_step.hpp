#pragma once

#include <algorithm>
#include <limits>

#include "sim_hal/emulator/hand/hand_emulator.hpp"
#include "sim_hal/emulator/memory_can_bus.hpp"

namespace colift::sim_hal {

/// Runs the emulator until `until` in a test's time.
inline void run_until(HandEmulator& hand, hal::ManualClock& clock, hal::Timestamp until) {
  hand.step(clock.now());
  while (hand.next_event() <= until) {
    clock.advance(std::max(hand.next_event() - clock.now(), hal::Duration(0)));
    hand.step(clock.now());
  }
  clock.advance(std::max(until - clock.now(), hal::Duration(0)));
}

/// What the client's node of a MemoryCan does while it waits: the emulator runs until its next event, no
/// longer than `until`. One thread for both, no time passes elsewhere.
[[nodiscard]] inline MemoryCan::WhileWaiting lock_step(HandEmulator& hand, hal::ManualClock& clock) {
  return [&hand, &clock](hal::Timestamp until) {
    hand.step(clock.now());
    run_until(hand, clock, std::min(std::max(hand.next_event(), clock.now()), until));
    return true;
  };
}

/// Faults of the client's end, brought about in memory.
inline void let_faults_reach(HandEmulator& hand, MemoryCan::Node& client) {
  hand.on_bus = [&client](HandFault::Kind kind, bool begins) {
    if (kind == HandFault::Kind::Down) client.set_down(begins);
    if (kind == HandFault::Kind::Noise) client.note_bus_error();
    if (kind == HandFault::Kind::Full) client.refuse_next(begins ? std::numeric_limits<int>::max() : 0);
    if (kind == HandFault::Kind::Passive)
      client.be(begins ? MemoryCan::State::Passive : MemoryCan::State::Active);
    if (kind == HandFault::Kind::BusOff)
      client.be(begins ? MemoryCan::State::BusOff : MemoryCan::State::Active);
  };
  hand.on_unacknowledged = [&client] { client.note_not_acknowledged(); };
}

}  // namespace colift::sim_hal
