#include "hal/drivers/barrett_can/pucks/bus_monitor.hpp"

namespace colift::hal::barrett {
namespace {
constexpr int kFullInARow = 5;
}

bool BusMonitor::broken() {
  switch (bus_.health().state) {
    case CanHealth::State::BusOff:
      say(why_,
          "bus-off: the bus is off, its controller met too many errors (termination? supply of the hand?)");
      return true;
    case CanHealth::State::Down:
    case CanHealth::State::Closed:
      say(why_, "the CAN interface is down or its adapter is unplugged");
      return true;
    default:
      break;
  }
  if (link_.full_in_a_row() < kFullInARow) return false;
  say(why_, "the adapter takes no frames: {} in a row were not sent", link_.full_in_a_row());
  return true;
}

void BusMonitor::begin_asking(Timestamp now) {
  state_ = State::Asking;
  asking_since_ = now;
  link_.drop_all();
  for (const Puck puck : kAllPucks) link_.ask(puck, Property::Stat);
}

void BusMonitor::note_device(Timestamp now) {
  state_ = State::Lost;
  tried_at_ = now;
  link_.drop_all();
}

void BusMonitor::step(Timestamp now) {
  switch (state_) {
    case State::Up:
      if (!broken()) return;
      nobody_ = false;
      return note_device(now);
    case State::Lost: {
      // a controller may come back by itself (restart-ms); a full queue and a dead interface do not
      const bool full = link_.full_in_a_row() >= kFullInARow;
      if (!full && !nobody_ && !broken()) return begin_asking(now);
      if (now - tried_at_ < reopen_) return;
      tried_at_ = now;
      link_.clear_full();
      if (bus_.open() && !broken()) begin_asking(now);
      return;
    }
    case State::Asking: {
      if (broken()) return note_device(now);
      bool nobody = true;
      for (const Puck puck : kAllPucks) {
        const bool answered = link_.reported(puck, Property::Stat).asked_at >= asking_since_;
        if (!answered && !link_.unanswered(puck, Property::Stat)) return;
        nobody = nobody && !answered;
      }
      nobody_ = nobody;
      // a gateway opened anew says nothing of a bus that is off still
      if (nobody) return note_device(now);
      state_ = State::Up;
      return;
    }
  }
}

}  // namespace colift::hal::barrett
