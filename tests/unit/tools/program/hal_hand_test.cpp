// Bring-up of the hand: opens on its own verb only, says what it met, and stops where it is when asked to.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "sim_hal/mock/mock_hand.hpp"
#include "tools/bring_up/hand/hal_hand_task.hpp"

namespace colift {
namespace {

using tools::HandTask;
using How = tools::HandTaskEnd::How;
using Kind = HandTask::Kind;

/// A hand whose motors have faded with heat: it stops on the object as ever, and presses with `part` of the
/// torque.
class FadedHand final : public hal::Hand {
 public:
  FadedHand(hal::Hand& hand, double part) : hand_(hand), part_(part) {}
  hal::Result<> configure() override { return hand_.configure(); }
  hal::Result<> activate() override { return hand_.activate(); }
  void deactivate() noexcept override { hand_.deactivate(); }
  [[nodiscard]] hal::DeviceHealth health() const override { return hand_.health(); }
  hal::Result<hal::HandState> state() override {
    auto state = hand_.state();
    if (state)
      for (double& torque : state->torque_nm) torque *= part_;
    return state;
  }
  hal::Result<> preshape(double spread_rad) override { return hand_.preshape(spread_rad); }
  hal::Result<> close(double torque_nm) override { return hand_.close(torque_nm); }
  hal::Result<> release() override { return hand_.release(); }
  void stop() noexcept override { hand_.stop(); }

 private:
  hal::Hand& hand_;
  double part_;
};

struct Stand {
  hal::ManualClock clock;
  sim_hal::HandScript script;
  std::unique_ptr<sim_hal::MockHand> hand;
  hal::HandReport report;
  bool interrupted = false;
  double torque_part = 1.0;  ///< Of the asked torque that is measured; NaN: no gauges.
  double interrupt_at_s = std::numeric_limits<double>::infinity();

  explicit Stand(double contact_rad = std::numeric_limits<double>::infinity()) {
    if (std::isfinite(contact_rad))
      script.contact_rad = [contact_rad](hal::Timestamp) {
        return sim_hal::FingerAngles{contact_rad, contact_rad, contact_rad};
      };
    hand = std::make_unique<sim_hal::MockHand>(script, clock);
  }

  tools::HandTaskEnd run(Kind kind, const std::function<void(HandTask&)>& more = {}) {
    HandTask task;
    task.kind = kind;
    task.for_s = 1.0;
    if (more) more(task);
    tools::HandTaskHooks hooks;
    hooks.interrupted = [this] { return interrupted || hal::seconds(clock.now()) > interrupt_at_s; };
    hooks.pause = [this] { clock.advance(std::chrono::milliseconds(2)); };
    hooks.report = [this] { return report; };
    FadedHand faded(*hand, torque_part);
    return run_hand_task(faded, task, clock, hooks);
  }
};

}  // namespace

TEST_CASE("watching a hand moves nothing", "[hal][hand]") {
  Stand s;
  const auto end = s.run(Kind::Watch);
  CHECK(end.how == How::Done);
  CHECK(end.states > 100);
  CHECK_FALSE(end.moved);
  CHECK(end.after.finger_rad == end.before.finger_rad);
}

TEST_CASE("closing on something says that it is held, on nothing that it is not", "[hal][hand]") {
  Stand with(1.2);
  const auto grip = with.run(Kind::Grip);
  INFO(grip.reason);
  CHECK(grip.how == How::Done);
  CHECK(grip.after.held);
  CHECK(grip.after.finger_rad[0] == Approx(1.2).margin(0.01));

  Stand without;
  const auto nothing = without.run(Kind::Close);
  CHECK(nothing.how == How::NoGrip);
  CHECK_FALSE(nothing.after.held);
  CHECK(nothing.reason == "the fingers met nothing");
}

TEST_CASE("a grip with a tenth of the torque that was asked is no grip", "[hal][hand]") {
  Stand hot(1.2);
  hot.torque_part = 0.1;
  hot.report.temperature_c = {57, 55, 56, 50};
  for (const Kind kind : {Kind::Close, Kind::Grip}) {
    const auto end = hot.run(kind, [](HandTask& t) { t.torque_nm = 0.8; });
    CHECK(end.how == How::NoGrip);
    CHECK(end.reason.find("0.08 of the 0.80 N m") != std::string::npos);
    CHECK(end.reason.find("57 C") != std::string::npos);
    // the fingers did stop on something, and nobody opens them
    CHECK(end.after.held);
    HandTask task;
    task.kind = kind;
    CHECK(hand_summary(task, end).find("it holds something;") == std::string::npos);
  }
  // without gauges nothing is known against it
  Stand blind(1.2);
  blind.torque_part = std::nan("");
  CHECK(blind.run(Kind::Grip).how == How::Done);
}

TEST_CASE("a hand that holds something opens with a word of consent only", "[hal][hand]") {
  Stand s(1.2);
  REQUIRE(s.run(Kind::Close).how == How::Done);
  s.report.loaded = true;
  const auto refused = s.run(Kind::Open);
  CHECK(refused.how == How::BadRequest);
  CHECK(refused.reason.find("--yes") != std::string::npos);
  CHECK(refused.after.finger_rad[0] == Approx(1.2).margin(0.01));
  const auto opened = s.run(Kind::Open, [](HandTask& t) { t.although_loaded = true; });
  INFO(opened.reason);
  CHECK(opened.how == How::Done);
  CHECK(opened.after.finger_rad[0] < 0.05);
}

TEST_CASE("preshape turns the spread", "[hal][hand]") {
  Stand s;
  const auto end = s.run(Kind::Preshape, [](HandTask& t) { t.spread_rad = 1.0; });
  INFO(end.reason);
  CHECK(end.how == How::Done);
  CHECK(end.after.spread_rad == Approx(1.0).margin(0.02));
}

TEST_CASE("interrupted while it closes, the fingers stay where they are", "[hal][hand]") {
  Stand s;
  s.interrupt_at_s = 0.5;
  const auto end = s.run(Kind::Close);
  CHECK(end.how == How::Interrupted);
  CHECK(end.after.finger_rad[0] > 0.2);
  CHECK(end.after.finger_rad[0] < 2.0);
  CHECK_FALSE(end.after.moving);
}

TEST_CASE("a slip ends the grip, with its cause where the driver knows one", "[hal][hand]") {
  Stand s(1.2);
  s.report.slipped = true;
  const auto end = s.run(Kind::Grip);
  CHECK(end.how == How::NoGrip);
  CHECK(end.reason == "the grip slipped after 0.0 s");
  s.report.why = hal::ShortText("the spread turned by 9 degrees under load");
  CHECK(s.run(Kind::Grip).reason ==
        "the grip slipped after 0.0 s: the spread turned by 9 degrees under load");
}

TEST_CASE("a hand that is lost while it moves is a failure with its words", "[hal][hand]") {
  Stand s;
  s.hand->inject(sim_hal::MockHand::Fault::Unplug, 40, 100000);
  const auto end = s.run(Kind::Close);
  CHECK(end.how == How::Failed);
  CHECK_FALSE(end.reason.empty());
  CHECK(end.code == hal::ErrorCode::LinkLost);
}

TEST_CASE("each kind of refusal has its advice", "[hal][hand]") {
  using hal::ErrorCode;
  CHECK(tools::hand_advice(ErrorCode::NotReady, "socketcan:can0").find("hal hand init") != std::string::npos);
  CHECK(tools::hand_advice(ErrorCode::LinkLost, "socketcan:can0").find("termination") != std::string::npos);
  CHECK(tools::hand_advice(ErrorCode::BadConfig, "socketcan:can9").find("can9") != std::string::npos);
}

TEST_CASE("screens and documents of a hand cope with what it does not know", "[hal][hand]") {
  tools::HandView v;
  v.bus = "socketcan:can0";
  CHECK(hand_screen(v).find("socketcan:can0") != std::string::npos);
  v.state = hal::HandState{};
  v.state->torque_nm.fill(std::nan(""));
  v.state->tip_force_n.fill(std::nan(""));
  v.report.palm_force_n = std::nan("");
  v.report.silent[2] = true;
  CHECK(hand_screen(v).find("F3 is silent") != std::string::npos);
  CHECK(tactile_text(v).find("no tactile pad reports anything") != std::string::npos);
  const std::string json = hand_document("state", v, {}, {});
  CHECK(json.rfind("{\"schema\":\"colift.hal.hand/1\"", 0) == 0);
  CHECK(json.find("\"silent\":true") != std::string::npos);
}

TEST_CASE("the end says what was read back of the motors, and no more", "[hal][hand]") {
  Stand s(1.2);
  s.report.mode_at_rest = {0, 5, std::nullopt, 3};
  const auto end = s.run(Kind::Close);
  REQUIRE(end.how == How::Done);
  HandTask task;
  task.kind = Kind::Close;
  const std::string text = hand_summary(task, end);
  INFO(text);
  CHECK(text.find("at rest, as read back: F1") != std::string::npos);
  CHECK(text.find("STILL ON: F2 (MODE 5)") != std::string::npos);
  CHECK(text.find("unknown: F3") != std::string::npos);
  CHECK(text.find("keeps its angle: spread") != std::string::npos);
  const std::string json = hand_document("close", {}, task, end);
  CHECK(json.find("\"modes\":[0,5,null,3]") != std::string::npos);
  // nothing that moved: nothing to read back
  CHECK(s.run(Kind::Watch).motors.empty());
}

TEST_CASE("a reading of the hand names who is silent, asleep, in error or on", "[hal][hand]") {
  using hal::barrett::Property;
  hal::HandReading reading;
  for (hal::PuckReading& p : reading.pucks) {
    p.answers = true;
    p.values = {{Property::Stat, 2}, {Property::Mode, 0}, {Property::Vers, 200}, {Property::Ct, 194'987}};
  }
  CHECK(tools::hand_reading_fault(reading).empty());
  reading.pucks[0].values = {{Property::Stat, 0}, {Property::Vers, 200}};
  reading.pucks[1].values = {{Property::Stat, 2}, {Property::Mode, 5}, {Property::Tstop, 0}};
  CHECK(tools::hand_reading_fault(reading).empty());  // asleep is no fault
  const std::string text = tools::hand_reading_text("socketcan:can0", reading);
  INFO(text);
  CHECK(text.find("asleep") != std::string::npos);
  CHECK(text.find("hal hand init") != std::string::npos);
  CHECK(text.find("F2 is on (MODE 5), and nothing but a command ends that") != std::string::npos);
  reading.pucks[2] = {};
  reading.pucks[3].values = {{Property::Stat, 1}, {Property::Error, 7}};
  CHECK(tools::hand_reading_fault(reading).find("F3 is silent") != std::string::npos);
  CHECK(tools::hand_reading_fault(reading).find("spread reports an error (code 7)") != std::string::npos);
  const std::string json = tools::hand_reading_document("socketcan:can0", reading);
  CHECK(json.rfind("{\"schema\":\"colift.hal.hand/1\",\"verb\":\"state\"", 0) == 0);
  CHECK(json.find("\"outcome\":\"failed\"") != std::string::npos);
}

}  // namespace colift
