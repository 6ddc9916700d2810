#pragma once

#include <algorithm>
#include <deque>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

#include "hal/can_bus.hpp"

namespace colift::sim_hal {

/// A CAN bus in memory for tests and lock-step runs: what one node sends, all others receive, in the order of
/// sending. There is no time of its own: `clock` is the test's, and a receive() that finds nothing calls
/// `while_waiting` with the moment until which it would wait. That call lets the others run and moves the
/// clock; it returns false when nothing more will come. The bus has to outlive its nodes. One thread.
class MemoryCan {
 public:
  using WhileWaiting = std::function<bool(hal::Timestamp until)>;
  using State = hal::CanHealth::State;

  /// What becomes of one frame on the wire: it comes `copies` times (0: it is lost), `delay` after its
  /// sending.
  struct Fate {
    int copies = 1;
    hal::Duration delay{0};
  };

  class Node final : public hal::CanBus {
   public:
    Node(MemoryCan& bus, WhileWaiting waiting, std::vector<hal::CanFilter> filters)
        : bus_(bus), waiting_(std::move(waiting)), filters_(std::move(filters)) {
      bus_.nodes_.push_back(this);
    }
    ~Node() override { std::erase(bus_.nodes_, this); }
    Node(const Node&) = delete;
    Node& operator=(const Node&) = delete;

    hal::Result<> open() override {
      close();
      ++opens_;
      if (down_)
        return hal::failure(hal::ErrorCode::LinkLost, "memory can",
                            "the interface is down, as the test wished");
      open_ = true;
      health_.state = bus_off_ ? State::BusOff : State::Active;
      return {};
    }
    void close() noexcept override {
      open_ = false;
      queue_.clear();
      health_.state = State::Closed;
    }

    Received receive(hal::CanFrame& into, hal::Duration timeout) noexcept override {
      if (!open_) return Received::Down;
      const hal::Timestamp until = bus_.clock_.now() + timeout;
      for (;;) {
        if (down_) return Received::Down;
        if (take(into)) return Received::Frame;
        const hal::Timestamp now = bus_.clock_.now();
        if (now >= until || !waiting_) return Received::Nothing;
        // a frame that is under way is waited for, no further
        const hal::Timestamp next = queue_.empty() ? until : std::clamp(queue_.front().due, now, until);
        if (!waiting_(next)) return take(into) ? Received::Frame : Received::Nothing;
      }
    }

    Sent send(const hal::CanFrame& frame) noexcept override {
      if (!open_ || down_) return Sent::Down;
      if (full_ > 0) {
        --full_;
        ++health_.not_sent;
        return Sent::Full;
      }
      ++health_.sent;
      if (!bus_off_) bus_.deliver(frame, this);  // in bus-off, as on Linux, writing goes on without an error
      return Sent::Yes;
    }

    hal::CanHealth health() const noexcept override { return health_; }

    // What a test may do to this node.
    void be(State state) {  ///< As if the controller had reported it.
      if (state == State::BusOff && !bus_off_) ++health_.bus_offs;
      bus_off_ = state == State::BusOff;
      ++health_.error_frames;
      health_.state = state;
    }
    void set_down(bool down) {  ///< Interface down, adapter unplugged; back again, it has to be opened anew.
      down_ = down;
      if (down) health_.state = State::Down;
    }
    void refuse_next(int sends) { full_ = sends; }  ///< The queue is full for the next `sends`.
    void hide_errors() { health_.reports_errors = false; }
    void note_not_acknowledged() { ++health_.error_frames, ++health_.not_acknowledged; }
    void note_bus_error() { ++health_.error_frames, ++health_.bus_errors; }
    [[nodiscard]] int opens() const { return opens_; }

   private:
    friend class MemoryCan;
    struct Letter {
      hal::Timestamp due;
      hal::CanFrame frame;
    };

    void arrive(const hal::CanFrame& frame, hal::Timestamp due) {
      if (!open_ || down_ || bus_off_) return;
      const bool passes = filters_.empty() ||
                          std::any_of(filters_.begin(), filters_.end(),
                                      [&](const hal::CanFilter& f) { return (frame.id & f.mask) == f.id; });
      if (!passes) return;
      const auto after = std::upper_bound(queue_.begin(), queue_.end(), due,
                                          [](hal::Timestamp t, const Letter& l) { return t < l.due; });
      queue_.insert(after, {due, frame});
    }

    bool take(hal::CanFrame& into) {
      if (queue_.empty() || queue_.front().due > bus_.clock_.now()) return false;
      into = queue_.front().frame;
      into.arrived_at = queue_.front().due;
      queue_.pop_front();
      ++health_.received;
      return true;
    }

    MemoryCan& bus_;
    WhileWaiting waiting_;
    std::vector<hal::CanFilter> filters_;
    std::deque<Letter> queue_;
    hal::CanHealth health_;
    bool open_ = false, down_ = false, bus_off_ = false;
    int full_ = 0, opens_ = 0;
  };

  explicit MemoryCan(const hal::Clock& clock) : clock_(clock) {}

  [[nodiscard]] std::unique_ptr<Node> node(WhileWaiting while_waiting = {},
                                           std::vector<hal::CanFilter> filters = {}) {
    return std::make_unique<Node>(*this, std::move(while_waiting), std::move(filters));
  }

  /// Asked for every frame, with its sender's node (null: injected), before it reaches the others.
  std::function<Fate(const hal::CanFrame&, const Node*)> fate;

  /// Sees every frame that is put on the wire, also those that get lost.
  std::function<void(const hal::CanFrame&)> tap;

  /// A frame that none of the nodes sent: garbage, foreign traffic.
  void inject(const hal::CanFrame& frame) { deliver(frame, nullptr); }

 private:
  void deliver(const hal::CanFrame& frame, const Node* from) {
    if (tap) tap(frame);
    const Fate f = fate ? fate(frame, from) : Fate{};
    for (int copy = 0; copy < f.copies; ++copy)
      for (Node* node : nodes_)
        if (node != from) node->arrive(frame, clock_.now() + f.delay);
  }

  const hal::Clock& clock_;
  std::vector<Node*> nodes_;
};

}  // namespace colift::sim_hal
