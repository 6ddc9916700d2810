#include "hal/drivers/barrett_can/hand_thread.hpp"

#include <atomic>
#include <thread>
#include <utility>

#include "hal/os/realtime.hpp"
#include "hal/types/latest_value.hpp"
#include "hal/types/short_text.hpp"

namespace colift::hal {
namespace {

constexpr Duration kUntilTaken = std::chrono::milliseconds(50);  // an ordinary kernel under load wakes late
constexpr Duration kUntilDone = std::chrono::milliseconds(200);  // deactivate() waits for the bus
constexpr int kPriority = 70;  // below the arm's, which answers its controller
constexpr Duration kLookAgain = std::chrono::microseconds(50);

/// A Result that is copied without allocation.
struct Outcome {
  bool good = false;
  ErrorCode code = ErrorCode::NotReady;
  ShortText where, detail;

  Outcome() = default;
  explicit Outcome(const Error& e) : code(e.code), where(e.where), detail(e.detail) {}
  [[nodiscard]] tl::unexpected<Error> error() const { return failure(code, where.str(), detail.str()); }
};

struct Snapshot {
  Outcome outcome;
  HandState state;
};

enum class Call { Activate, Deactivate, Preshape, Close, Release };

}  // namespace

struct HandThread::Impl {
  enum class Letter { Empty, Posted, Taken, Done };

  std::unique_ptr<Hand> inner;
  Duration period;
  LatestValue<Snapshot> newest;
  std::atomic<bool> run{false}, begun{false};
  std::vector<std::string> realtime;  // written before `begun`
  std::thread thread;
  // one letter at a time: the caller fills it in while Empty, the thread answers it while Taken
  std::atomic<Letter> letter{Letter::Empty};
  Call call = Call::Activate;
  double value = 0.0;
  Outcome answer;

  void look() {
    Snapshot s;
    if (auto state = inner->state()) {
      s.outcome.good = true;
      s.state = *state;
    } else {
      s.outcome = Outcome(state.error());
    }
    newest.write(s);
  }

  Result<> carry_out() {
    switch (call) {
      case Call::Activate:
        return inner->activate();
      case Call::Deactivate:
        inner->deactivate();
        return {};
      case Call::Preshape:
        return inner->preshape(value);
      case Call::Close:
        return inner->close(value);
      case Call::Release:
        return inner->release();
    }
    return {};
  }

  void take_letter() {
    Letter posted = Letter::Posted;
    if (!letter.compare_exchange_strong(posted, Letter::Taken, std::memory_order_acq_rel)) return;
    if (auto done = carry_out()) {
      answer = Outcome();
      answer.good = true;
    } else {
      answer = Outcome(done.error());
    }
    look();  // what a caller asks next already knows of it
    letter.store(Letter::Done, std::memory_order_release);
  }

  void loop() {
    name_thread("colift-hand");
    realtime =
        ask_for_realtime({.priority = kPriority, .lock_memory = false, .stack_bytes = 65536, .heap_bytes = 0})
            .words;
    begun.store(true, std::memory_order_release);
    while (run.load(std::memory_order_acquire)) {
      take_letter();
      look();
      std::this_thread::sleep_for(period);
    }
  }

  void start() {
    run = true;
    begun = false;
    thread = std::thread([this] { loop(); });
    while (!begun.load(std::memory_order_acquire)) std::this_thread::sleep_for(kLookAgain);
  }

  void rest() {
    run = false;
    if (thread.joinable()) thread.join();
    letter = Letter::Empty;
  }

  Result<> hand_over(const char* where, Call what, double with = 0.0) {
    if (!thread.joinable()) {
      call = what;
      value = with;
      return carry_out();
    }
    const SteadyClock clock;
    const Timestamp start = clock.now();
    const auto late = [&](const char* words) { return failure(ErrorCode::Timeout, where, words); };
    if (letter.load(std::memory_order_acquire) == Letter::Taken)
      return late("the hand's thread still works on the command before");
    call = what;
    value = with;
    letter.store(Letter::Posted, std::memory_order_release);
    for (;;) {
      if (letter.load(std::memory_order_acquire) == Letter::Done) {
        letter.store(Letter::Empty, std::memory_order_relaxed);
        if (answer.good) return {};
        return answer.error();
      }
      const Duration waited = clock.now() - start;
      if (waited > kUntilTaken) {
        Letter posted = Letter::Posted;
        if (letter.compare_exchange_strong(posted, Letter::Empty, std::memory_order_acq_rel))
          return late("the hand's thread took no command within 50 ms: nothing was done");
      }
      if (waited > kUntilDone) return late("the hand's thread has not finished the command");
      std::this_thread::sleep_for(kLookAgain);
    }
  }
};

HandThread::HandThread(std::unique_ptr<Hand> inner, Duration period) : impl_(std::make_unique<Impl>()) {
  impl_->inner = std::move(inner);
  impl_->period = period;
  Snapshot none;
  none.outcome = Outcome({ErrorCode::NotReady, "hand.state", "the hand is not open, call configure() first"});
  impl_->newest.write(none);
}

HandThread::~HandThread() {
  impl_->rest();
}

Result<> HandThread::configure() {
  impl_->rest();
  auto configured = impl_->inner->configure();
  impl_->look();
  if (configured) impl_->start();
  return configured;
}

Result<> HandThread::activate() {
  return impl_->hand_over("hand.activate", Call::Activate);
}

void HandThread::deactivate() noexcept {
  // as often as it takes: this one has to get through, and a lost bus is opened in no more than 2 s
  for (int tries = 0; tries < 500 && !impl_->hand_over("hand.deactivate", Call::Deactivate); ++tries) {
  }
}

DeviceHealth HandThread::health() const {
  return impl_->inner->health();
}

Result<HandState> HandThread::state() {
  const Snapshot s = impl_->newest.read();
  if (!s.outcome.good) return s.outcome.error();
  return s.state;
}

Result<> HandThread::preshape(double spread_rad) {
  return impl_->hand_over("hand.preshape", Call::Preshape, spread_rad);
}

Result<> HandThread::close(double torque_nm) {
  return impl_->hand_over("hand.close", Call::Close, torque_nm);
}

Result<> HandThread::release() {
  return impl_->hand_over("hand.release", Call::Release);
}

std::vector<std::string> HandThread::realtime() const {
  return impl_->realtime;
}

void HandThread::stop() noexcept {
  impl_->inner->stop();
}

}  // namespace colift::hal
