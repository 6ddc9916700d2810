#pragma once

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/hand_facts.hpp"

namespace colift::hal::barrett {

/// Whether the bus can be believed. It is lost when error frames or the carrier say so, or when five sends in
/// a row were not taken; it is opened again no more often than once in `reopen`, and counts as back only when
/// every puck was asked for its state anew and one of them at least answered.
class BusMonitor {
 public:
  enum class State { Up, Lost, Asking };

  BusMonitor(CanBus& bus, PuckLink& link, Duration reopen) : bus_(bus), link_(link), reopen_(reopen) {}

  void start() { state_ = State::Up, nobody_ = false; }
  /// May wait inside the bus's open() when it is lost (a gateway: up to 2 s; SocketCAN and memory: not).
  void step(Timestamp now);

  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] const ShortText& why() const { return why_; }

 private:
  [[nodiscard]] bool broken();
  void begin_asking(Timestamp now);
  void note_device(Timestamp now);

  CanBus& bus_;
  PuckLink& link_;
  Duration reopen_;
  State state_ = State::Up;
  bool nobody_ = false;  ///< None of the pucks answered when they were asked last.
  Timestamp tried_at_{0}, asking_since_{0};
  ShortText why_;
};

}  // namespace colift::hal::barrett
