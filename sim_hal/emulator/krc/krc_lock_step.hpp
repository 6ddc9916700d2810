#pragma once

#include <algorithm>

#include "sim_hal/emulator/krc/krc_emulator.hpp"
#include "sim_hal/emulator/memory_link.hpp"

namespace colift::sim_hal {

/// Runs the emulator until `until` in a test's time: its cycles and its delayed datagrams.
inline void run_until(KrcEmulator& krc, hal::ManualClock& clock, hal::Timestamp until) {
  krc.poll(clock.now());
  while (krc.next_event() <= until) {
    clock.advance(std::max(krc.next_event() - clock.now(), hal::Duration(0)));
    if (krc.next_cycle() <= clock.now())
      krc.cycle();
    else
      krc.poll(clock.now());
  }
  clock.advance(std::max(until - clock.now(), hal::Duration(0)));
}

/// What the client's end of a MemoryWire does while it waits: the emulator runs until it has sent something,
/// no longer than `until`. One thread for both, no time passes elsewhere.
[[nodiscard]] inline MemoryWire::WhileWaiting lock_step(KrcEmulator& krc, hal::ManualClock& clock) {
  return [&krc, &clock](hal::Timestamp until) {
    run_until(krc, clock, std::min(std::max(krc.next_event(), clock.now()), until));
    return true;
  };
}

}  // namespace colift::sim_hal
