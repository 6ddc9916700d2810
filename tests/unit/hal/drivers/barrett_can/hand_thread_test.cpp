#include "hal/drivers/barrett_can/hand_thread.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <new>
#include <semaphore>
#include <thread>
#include <utility>

#include "hand_rig.hpp"

using namespace colift;
using namespace std::chrono_literals;
using hal::ErrorCode;
using hal::Result;

// counts what this thread allocates while `counting` is set
static std::atomic<std::uint64_t> allocated{0};
static thread_local bool counting = false;

void* operator new(std::size_t size) {
  if (counting) ++allocated;
  if (void* p = std::malloc(size ? size : 1)) return p;
  throw std::bad_alloc();
}
// the library frees with our delete what it takes from here
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  if (counting) ++allocated;
  return std::malloc(size ? size : 1);
}
void operator delete(void* p) noexcept {
  std::free(p);
}
void operator delete(void* p, std::size_t) noexcept {
  std::free(p);
}

namespace {

/// A hand that counts, refuses large torques, and can be made to hang inside state().
class CountingHand final : public hal::Hand {
 public:
  std::atomic<int> states{0}, closes{0}, releases{0}, stops{0}, deactivations{0};
  std::atomic<bool> hang{false};
  std::binary_semaphore hanging{0}, go_on{0};
  std::atomic<std::thread::id> thread;

  Result<> configure() override { return {}; }
  Result<> activate() override { return {}; }
  void deactivate() noexcept override { ++deactivations; }
  hal::DeviceHealth health() const override { return {}; }
  Result<hal::HandState> state() override {
    thread = std::this_thread::get_id();
    if (hang.exchange(false)) {
      hanging.release();
      go_on.acquire();
    }
    hal::HandState s;
    s.measured_at = std::chrono::milliseconds(++states);
    s.moving = closes > 0;
    return s;
  }
  Result<> preshape(double) override { return {}; }
  Result<> close(double torque_nm) override {
    if (torque_nm > 1.0) return hal::failure(ErrorCode::LimitExceeded, "counting.close", "too much");
    ++closes;
    return {};
  }
  Result<> release() override {
    ++releases;
    return {};
  }
  void stop() noexcept override { ++stops; }
};

/// A bus whose own allocations do not count.
class UncountedBus final : public hal::CanBus {
 public:
  explicit UncountedBus(hal::CanBus& inner) : inner_(inner) {}
  Result<> open() override { return inner_.open(); }
  void close() noexcept override { inner_.close(); }
  Received receive(hal::CanFrame& into, hal::Duration timeout) noexcept override {
    const bool was = std::exchange(counting, false);
    const Received got = inner_.receive(into, timeout);
    counting = was;
    return got;
  }
  Sent send(const hal::CanFrame& frame) noexcept override {
    const bool was = std::exchange(counting, false);
    const Sent sent = inner_.send(frame);
    counting = was;
    return sent;
  }
  hal::CanHealth health() const noexcept override { return inner_.health(); }

 private:
  hal::CanBus& inner_;
};

}  // namespace

TEST_CASE("a hand with a thread runs by itself, and commands and refusals go both ways", "[hand][thread]") {
  auto owned = std::make_unique<CountingHand>();
  CountingHand& inner = *owned;
  hal::HandThread hand(std::move(owned));
  CHECK(hand.state().error().code == ErrorCode::NotReady);
  REQUIRE(hand.configure());
  while (inner.states < 20) std::this_thread::yield();
  CHECK(inner.thread.load() != std::this_thread::get_id());
  REQUIRE(hand.state());
  CHECK(hand.state()->measured_at > 1ms);
  // a busy machine may not give the thread its turn in time: then nothing was done, and it is tried again
  const auto insist = [](auto call) {
    for (;;)
      if (auto done = call(); done || done.error().code != ErrorCode::Timeout) return done;
  };
  REQUIRE(insist([&] { return hand.activate(); }));
  REQUIRE(insist([&] { return hand.close(0.5); }));
  CHECK(inner.closes == 1);
  CHECK(hand.state()->moving);
  const auto refused = insist([&] { return hand.close(2.0); });
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == ErrorCode::LimitExceeded);
  CHECK(refused.error().text() == "counting.close: too much");
  hand.stop();
  CHECK(inner.stops == 1);
  hand.deactivate();
  CHECK(inner.deactivations == 1);
}

TEST_CASE("a command that the hand's thread cannot take is taken back whole", "[hand][thread]") {
  auto owned = std::make_unique<CountingHand>();
  CountingHand& inner = *owned;
  hal::HandThread hand(std::move(owned));
  REQUIRE(hand.configure());
  inner.hang = true;
  inner.hanging.acquire();
  const auto late = hand.release();
  REQUIRE_FALSE(late);
  CHECK(late.error().code == ErrorCode::Timeout);
  CHECK(hand.state());  // what was last known
  const int states = inner.states;
  inner.go_on.release();
  while (inner.states < states + 5) std::this_thread::yield();
  CHECK(inner.releases == 0);
}

TEST_CASE("asking for the state allocates nothing, at rest, on the way, holding, slipping and hot",
          "[hand]") {
  hal::ManualClock clock;
  FakeHand fake(clock);
  UncountedBus bus(*fake.host);
  hal::BarrettHand hand(bus, {}, clock);
  REQUIRE(hand.configure());
  REQUIRE(hand.activate());
  bool held = false;
  const auto watched = [&](hal::Duration by) {
    fake.pass(by, [&] {
      counting = true;
      const auto state = hand.state();
      counting = false;
      REQUIRE(state);
      held = state->held;
    });
  };
  watched(200ms);
  for (std::size_t f = 0; f < 3; ++f) fake.pucks[f].blocked_at = 1e5;
  REQUIRE(hand.close(0.75));
  watched(2s);
  CHECK(held);
  for (FakePuck& puck : fake.pucks) puck.load_share = 0.2;
  watched(200ms);
  CHECK(hand.report().slipped);
  fake.pucks[0].property[20] = 65;
  watched(1s);
  CHECK(hand.report().warm);
  REQUIRE(hand.release());
  watched(2s);
  CHECK(allocated == 0);
}
