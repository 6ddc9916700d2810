#pragma once

#include <chrono>

#include "hal/drivers/barrett_can/pucks/puck_link.hpp"

namespace colift::hal::barrett {

/// Pumps the link, a millisecond at a time, until `done()`. False when `limit` has passed first, when
/// `give_up()` says so, or when the clock stands still: a wait has an end in any case.
template <class Done, class GiveUp>
bool wait_on(PuckLink& link, const Clock& clock, Duration limit, const Done& done, const GiveUp& give_up) {
  constexpr int kNoProgress = 100'000;  // turns of a clock that stands still
  const Timestamp end = clock.now() + limit;
  int still = 0;
  for (Timestamp last = clock.now();;) {
    link.pump(std::chrono::milliseconds(1));
    if (done()) return true;
    const Timestamp now = clock.now();
    still = now > last ? 0 : still + 1;
    if (now >= end || still > kNoProgress || give_up()) return false;
    last = now;
  }
}

template <class Done>
bool wait_on(PuckLink& link, const Clock& clock, Duration limit, const Done& done) {
  return wait_on(link, clock, limit, done, [] { return false; });
}

}  // namespace colift::hal::barrett
