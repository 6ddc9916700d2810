#include "hal/guards/guarded_hand.hpp"

#include <catch2/catch.hpp>
#include <limits>
#include <numbers>
#include <optional>

#include "sim_hal/mock/mock_hand.hpp"

using namespace colift::hal;
using Catch::Matchers::Contains;

namespace {

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInf = std::numeric_limits<double>::infinity();

/// The error's code; nullopt when all went well.
template <class T>
std::optional<ErrorCode> code(const Result<T>& result) {
  if (result) return std::nullopt;
  return result.error().code;
}

/// A hand that does what it is told and says what the test wrote.
class PlainHand final : public Hand {
 public:
  HandState next;
  bool fail = false;
  int preshapes = 0, closes = 0, releases = 0, stops = 0;

  Result<> configure() override { return {}; }
  Result<> activate() override { return {}; }
  void deactivate() noexcept override {}
  DeviceHealth health() const override { return {}; }
  Result<HandState> state() override {
    if (fail) return failure(ErrorCode::LinkLost, "plain", "as asked");
    return next;
  }
  Result<> preshape(double) override { return done(preshapes); }
  Result<> close(double) override { return done(closes); }
  Result<> release() override { return done(releases); }
  void stop() noexcept override { ++stops; }

 private:
  Result<> done(int& count) {
    ++count;
    if (fail) return failure(ErrorCode::LinkLost, "plain", "as asked");
    return {};
  }
};

struct Rig {
  PlainHand* plain = nullptr;
  ManualClock clock;
  std::unique_ptr<GuardedHand> hand;

  Rig() {
    auto owned = std::make_unique<PlainHand>();
    plain = owned.get();
    hand = std::make_unique<GuardedHand>(std::move(owned), HandGuardConfig{}, &clock);
  }
};

}  // namespace

TEST_CASE("a hand that was closed opens on release alone", "[guard][hand]") {
  Rig rig;
  REQUIRE(rig.hand->preshape(0.5));
  REQUIRE(rig.hand->close(0.8));
  const auto answer = rig.hand->preshape(0.5);
  REQUIRE_FALSE(answer);
  CHECK(answer.error().code == ErrorCode::NotReady);
  CHECK(rig.plain->preshapes == 1);
  REQUIRE(rig.hand->release());
  CHECK(rig.hand->preshape(0.5));
}

TEST_CASE("a stop, a restart or a broken link does not make a closed hand forget that it is closed",
          "[guard][hand]") {
  Rig rig;
  REQUIRE(rig.hand->close(0.8));
  rig.hand->stop();
  rig.hand->deactivate();
  REQUIRE(rig.hand->configure());
  REQUIRE(rig.hand->activate());
  CHECK_FALSE(rig.hand->preshape(0.0));
  rig.plain->fail = true;
  CHECK_FALSE(rig.hand->release());  // it was not told to the hand: the hand is still closed
  rig.plain->fail = false;
  CHECK_FALSE(rig.hand->preshape(0.0));
  CHECK(rig.plain->preshapes == 0);
}

TEST_CASE("a hand that failed to close counts as closed", "[guard][hand]") {
  Rig rig;
  rig.plain->fail = true;
  CHECK_FALSE(rig.hand->close(0.8));
  rig.plain->fail = false;
  CHECK_FALSE(rig.hand->preshape(0.0));
}

TEST_CASE("a hand that says it holds, or does not say, is not opened by a preshape", "[guard][hand]") {
  Rig rig;
  rig.plain->next.held = true;
  CHECK(code(rig.hand->preshape(0.1)) == ErrorCode::NotReady);
  rig.plain->next.held = false;
  rig.plain->fail = true;
  CHECK(code(rig.hand->preshape(0.1)) == ErrorCode::LinkLost);
  rig.plain->fail = false;
  rig.plain->next.finger_rad[0] = kNan;
  CHECK(code(rig.hand->preshape(0.1)) == ErrorCode::BadReply);
  CHECK(rig.plain->preshapes == 0);
}

TEST_CASE("spread and torque out of range never reach the hand", "[guard][hand]") {
  Rig rig;
  for (const double spread : {kNan, kInf, -0.01, std::numbers::pi + 0.01})
    CHECK(code(rig.hand->preshape(spread)) == ErrorCode::LimitExceeded);
  for (const double torque : {kNan, kInf, -kInf, -0.5, 0.0, 1.01})
    CHECK(code(rig.hand->close(torque)) == ErrorCode::LimitExceeded);
  CHECK(rig.plain->preshapes == 0);
  CHECK(rig.plain->closes == 0);
  CHECK(rig.hand->preshape(std::numbers::pi));
  CHECK(rig.hand->close(1.0));
}

TEST_CASE("a state that cannot be is no state", "[guard][hand]") {
  Rig rig;
  const HandState good = rig.plain->next;
  const auto refused = [&](auto change) {
    rig.plain->next = good;
    change(rig.plain->next);
    return !rig.hand->state();
  };
  CHECK(refused([](HandState& s) { s.finger_rad[1] = kNan; }));
  CHECK(refused([](HandState& s) { s.finger_rad[2] = 2.7; }));
  CHECK(refused([](HandState& s) { s.outer_rad[0] = -kInf; }));
  CHECK(refused([](HandState& s) { s.spread_rad = kNan; }));
  CHECK(refused([](HandState& s) { s.spread_rad = 3.5; }));
  CHECK(refused([](HandState& s) { s.torque_nm[0] = kInf; }));
  CHECK(refused([](HandState& s) { s.tip_force_n[2] = 1e9; }));
  CHECK_FALSE(refused([](HandState& s) { s.torque_nm = {kNan, kNan, kNan}; }));  // a hand without gauges
  CHECK_FALSE(refused([](HandState& s) { s.tip_force_n = {kNan, kNan, kNan}; }));
  CHECK_THAT(rig.hand->health().last_error, Contains("hand.state"));
  CHECK(rig.hand->health().rejected == 7);
}

TEST_CASE("a state of long ago is no state", "[guard][hand]") {
  Rig rig;
  rig.clock.advance(std::chrono::milliseconds(90));
  CHECK(rig.hand->state());
  rig.clock.advance(std::chrono::milliseconds(100));
  CHECK(code(rig.hand->state()) == ErrorCode::Timeout);
  rig.plain->next.measured_at = rig.clock.now();
  CHECK(rig.hand->state());
  rig.plain->next.measured_at -= std::chrono::milliseconds(1);
  CHECK(code(rig.hand->state()) == ErrorCode::BadReply);  // older than the last
}

TEST_CASE("a guarded mock hand opens, closes around a thing and lets it go", "[guard][hand]") {
  using colift::sim_hal::MockHand;
  ManualClock clock;
  colift::sim_hal::HandScript script;
  script.contact_rad = [](Timestamp) { return colift::sim_hal::FingerAngles{1.0, 1.0, 1.2}; };
  auto owned = std::make_unique<MockHand>(script, clock);
  MockHand& mock = *owned;
  GuardedHand hand(std::move(owned), HandGuardConfig{}, &clock);
  REQUIRE(hand.configure());
  REQUIRE(hand.activate());
  const auto wait = [&](std::chrono::milliseconds t) {
    for (int i = 0; i < t.count() / 10; ++i) {
      clock.advance(std::chrono::milliseconds(10));
      (void)hand.state();
    }
  };
  REQUIRE(hand.preshape(0.0));
  wait(std::chrono::milliseconds(500));
  REQUIRE(hand.close(0.75));
  wait(std::chrono::milliseconds(1500));
  REQUIRE(hand.state());
  CHECK(hand.state()->held);
  CHECK_FALSE(hand.preshape(0.0));
  mock.inject(MockHand::Fault::Nan, 300, 5);
  REQUIRE(hand.release());
  wait(std::chrono::milliseconds(1500));
  REQUIRE(hand.state());
  CHECK_FALSE(hand.state()->held);
  CHECK(hand.state()->finger_rad[0] < 0.05);
  CHECK(hand.health().rejected >= 5);
}
