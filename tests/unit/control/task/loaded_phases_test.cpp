// Grip, lift, hold, lower and test lift without a camera: what joints, forces and fingers say alone.
#include <catch2/catch.hpp>
#include <cmath>

#include "control/task/phases/grip_phase.hpp"
#include "control/task/phases/lift_phase.hpp"
#include "control/task/phases/pause_phase.hpp"
#include "control/task/phases/test_lift_phase.hpp"
#include "phase_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

namespace {

struct Loaded : PhaseRig {
  explicit Loaded(const Config& config = unannounced()) : PhaseRig(config) {
    make_decision();
    hand->now.held = true;
    c->arm.expect(HandLoad::Carried);
  }

  std::optional<TaskEvent> lift_up() {
    enter(Task::Lift);
    lift.begin_lift(Task::AwaitReady);
    return run([this] { return lift.lift(); }, 10.0);
  }
  /// A load on the palm, as the joints feel it.
  void load(double force_n) {
    Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
    wrench[2] = -force_n;
    external_nm =
        hal::jacobian(hal::built_in_robot(), c->arm.commanded(), hal::Vec3::Zero()).transpose() * wrench;
  }

  /// A hold of one sample, and its summary in the record.
  void record_hold() {
    c->record.curve.emplace_back().state = Task::Hold;
    lift.begin_lower();
    REQUIRE(c->record.lift);
  }

  PartnerMonitor partner{*c};
  ObjectMonitor object{*c};
  GraspSelector grasps{*c};
  LetGoMonitor let_go{*c, object};
  LiftEvidence evidence{*c, object, let_go};
  GripPhase grip{*c, partner, object, let_go};
  LiftPhase lift{*c, object, let_go, evidence};
  PausePhase pause{*c, object, let_go};
  TestLiftPhase test_lift{*c, object, let_go, grasps};
};

}  // namespace

TEST_CASE("a closed hand holds something, or is empty", "[phases]") {
  Loaded rig;
  rig.enter(Task::Close);
  rig.grip.begin_close();
  CHECK(rig.hand->commands == std::vector<std::string>{"close"});
  rig.hand->now.moving = true;
  CHECK_FALSE(rig.run([&] { return rig.grip.close(); }, 2.0));
  SECTION("held") {
    rig.hand->now.moving = false;
    CHECK(rig.run([&] { return rig.grip.close(); })->event == Event::HandHeld);
  }
  SECTION("empty") {
    rig.hand->now.moving = rig.hand->now.held = false;
    CHECK(rig.run([&] { return rig.grip.close(); })->event == Event::HandEmpty);
  }
  SECTION("never at rest") {
    CHECK(rig.run([&] { return rig.grip.close(); })->event == Event::HandEmpty);
    CHECK(rig.c->in_state_s() > 8.0);
  }
}

TEST_CASE("a grip is good when the fingers stop where the observed width says", "[phases]") {
  Loaded rig;
  const double expected = planner::stopped_angle(rig.hand_model, rig.c->chosen());
  rig.enter(Task::Verify);
  SECTION("there") {
    rig.hand->now.finger_rad.fill(expected + 0.3);
    rig.hand->now.torque_nm.fill(0.9);
    CHECK(rig.run([&] { return rig.grip.verify(); })->event == Event::GripGood);
  }
  SECTION("without gauges") {
    rig.hand->now.finger_rad.fill(expected);
    rig.hand->now.torque_nm.fill(NAN);
    CHECK(rig.run([&] { return rig.grip.verify(); })->event == Event::GripGood);
  }
  SECTION("held at a quarter of what was asked") {
    rig.hand->now.finger_rad.fill(expected);
    rig.hand->now.torque_nm = {0.25, 0.1, 0.2};
    const auto judged = rig.run([&] { return rig.grip.verify(); });
    CHECK(judged->event == Event::GripBad);
    CHECK(judged->detail.find("held at 0.25 of what was asked (limit 0.40): not lifted") == 0);
  }
  SECTION("too weakly for the load that is expected: the object would slip") {
    rig.hand->now.finger_rad.fill(expected);
    rig.hand->now.torque_nm = {0.2, 0.2, 0.42};
    rig.c->config.decision.known_mass_kg = 8.0;
    const auto judged = rig.run([&] { return rig.grip.verify(); });
    CHECK(judged->event == Event::GripBad);
    CHECK_THAT(judged->detail, Catch::Contains("N expected (8.0 kg") && Catch::Contains("not lifted"));
  }
  SECTION("the same grip of something light") {
    rig.hand->now.finger_rad.fill(expected);
    rig.hand->now.torque_nm = {0.2, 0.2, 0.42};
    rig.c->config.decision.known_mass_kg = 0.5;
    CHECK(rig.run([&] { return rig.grip.verify(); })->event == Event::GripGood);
  }
  SECTION("a mass that is only the usual one refuses what is far too weak, a known one what is too weak") {
    rig.hand->now.finger_rad.fill(expected);
    const double share = rig.c->record.decision->decision.share;
    const double part = GENERATE(0.6, 0.85, 1.2);  // of what the usual mass needs
    const double load_n = part * share * hal::kGravity_m_s2 * rig.c->config.decision.usual_mass_kg;
    const double squeeze_nm = load_n / (2.0 * rig.c->rig.hand.friction) * 0.05;
    rig.hand->now.torque_nm = {0.5 * squeeze_nm, 0.5 * squeeze_nm, squeeze_nm};
    rig.c->config.task.grip.min_held_fraction = 0.0;
    const bool known = GENERATE(true, false);
    if (known) rig.c->config.decision.known_mass_kg = rig.c->config.decision.usual_mass_kg;
    CAPTURE(part, known);
    const auto judged = rig.run([&] { return rig.grip.verify(); });
    CAPTURE(judged->detail);
    CHECK((judged->event == Event::GripGood) == (part > (known ? 1.0 : 0.7)));
  }
  SECTION("elsewhere") {
    rig.hand->now.finger_rad = {expected, expected + 0.6, expected};
    CHECK(rig.run([&] { return rig.grip.verify(); })->event == Event::GripBad);
  }
  SECTION("wider than it was seen: something is between the fingers and the object") {
    rig.hand->now.finger_rad.fill(expected - 0.25);
    rig.hand->now.torque_nm.fill(0.9);
    const auto judged = rig.run([&] { return rig.grip.verify(); });
    CHECK(judged->event == Event::GripBad);
    CHECK_THAT(judged->detail, Catch::Contains("something is between the fingers and the object"));
  }
  SECTION("one finger that wraps a bar is stopped sooner than the others: something is under it") {
    planner::GraspCandidate& bar = rig.c->record.decision->candidates[0];
    bar.kind = planner::GraspKind::Wrap;
    bar.width = 0.05;
    const double alone = planner::stopped_angle(rig.hand_model, bar);
    const double between_m = GENERATE(0.008, 0.020);
    rig.hand->now.finger_rad.fill(alone);
    rig.hand->now.finger_rad[1] = planner::stopped_angle(rig.hand_model, bar, between_m);
    rig.hand->now.torque_nm.fill(0.9);
    const auto judged = rig.run([&] { return rig.grip.verify(); });
    INFO(judged->detail);
    CHECK((judged->event == Event::GripBad) == (between_m > 0.012));
    if (between_m > 0.012) CHECK_THAT(judged->detail, Catch::Contains("between F2 and the object"));
  }
  SECTION("lost") {
    rig.hand->now.finger_rad.fill(expected);
    rig.hand->now.held = false;
    CHECK(rig.run([&] { return rig.grip.verify(); })->event == Event::GripBad);
  }
  CHECK(rig.c->in_state_s() >= 0.3);
}

TEST_CASE("a partner who never holds still ends the wait, a hot or empty hand at once", "[phases]") {
  Loaded rig;
  rig.enter(Task::AwaitReady);
  rig.grip.begin_await_ready();
  CHECK_FALSE(rig.run([&] { return rig.grip.await_ready(); }, 1.0));
  SECTION("timeout") {
    CHECK(rig.run([&] { return rig.grip.await_ready(); })->event == Event::TimeOut);
    CHECK(rig.c->in_state_s() == Approx(20.0).margin(0.02));
  }
  SECTION("hot") {
    rig.hand->now.hot = true;
    CHECK(rig.run([&] { return rig.grip.await_ready(); })->event == Event::GripBad);
  }
  SECTION("empty") {
    rig.hand->now.held = false;
    CHECK(rig.run([&] { return rig.grip.await_ready(); })->event == Event::HandEmpty);
  }
}

TEST_CASE("lift, hold and lower: up by the height, for the time, and down again", "[phases]") {
  Loaded rig;
  const double floor_m = rig.c->palm().translation().z();
  REQUIRE(rig.lift_up());
  CHECK(rig.c->attempts.lifted);
  CHECK(rig.c->palm().translation().z() - floor_m == Approx(0.05).margin(1e-3));
  CHECK(rig.c->in_state_s() > 2.0 + 0.3);

  rig.enter(Task::Hold);
  rig.lift.begin_hold();
  CHECK(rig.run([&] { return rig.lift.hold(); })->event == Event::HoldOver);
  CHECK(rig.c->in_state_s() == Approx(2.0).margin(0.02));

  rig.enter(Task::Lower);
  rig.lift.begin_lower();
  CHECK(rig.run([&] { return rig.lift.lower(); })->event == Event::OnGround);
  CHECK(rig.c->palm().translation().z() - floor_m == Approx(0.0).margin(1e-3));
}

TEST_CASE("what nobody saw is not reported as lifted", "[phases]") {
  Loaded rig;
  rig.evidence.start_lift();
  CHECK_THAT(rig.evidence.against(), Catch::Contains("it was never held at its height"));
  REQUIRE(rig.lift_up());
  rig.evidence.update();
  CHECK_THAT(rig.evidence.against(), Catch::Contains("no picture of the object while it was held"));
}

TEST_CASE("a lift ends with the grip, a slipping or hot hand, and too much load", "[phases]") {
  Loaded rig;
  rig.enter(Task::Lift);
  rig.lift.begin_lift(Task::AwaitReady);
  CHECK_FALSE(rig.run([&] { return rig.lift.lift(); }, 0.5));
  Event wanted = Event::HandEmpty;
  SECTION("grip") {
    rig.hand->now.held = false;
  }
  SECTION("slip") {
    rig.hand->now.slips = true;
    wanted = Event::HandUnfit;
  }
  SECTION("heat") {
    rig.hand->now.hot = true;
    wanted = Event::HandUnfit;
  }
  SECTION("load that grows at once") {
    rig.load(70.0);
    wanted = Event::PartnerLetGo;
  }
  SECTION("load that grows slowly") {
    for (double load_n = 5.0; load_n < 60.0; load_n += 5.0) {
      rig.load(load_n);
      REQUIRE_FALSE(rig.run([&] { return rig.lift.lift(); }, 0.15));
    }
    rig.load(70.0);
    wanted = Event::LimitReached;
  }
  const auto event = rig.run([&] { return rig.lift.lift(); }, 0.5);
  REQUIRE(event);
  CHECK(event->event == wanted);
}

TEST_CASE(
    "with an unknown mass the partner's load by the predicted share is compared with its limit in the lift",
    "[phases]") {
  Config config = unannounced();
  config.decision.partner_load_n = 100.0;
  Loaded rig(config);
  rig.c->record.decision->decision.share = 0.25;  // he bears three times what the robot feels
  rig.c->record.decision->share.interval = planner::ShareRange{0.12, 0.41};
  rig.enter(Task::Lift);
  rig.lift.begin_lift(Task::AwaitReady);
  for (double load_n = 5.0; load_n < 31.0; load_n += 5.0) {
    rig.load(load_n);
    REQUIRE_FALSE(rig.run([&] { return rig.lift.lift(); }, 0.15));
  }
  rig.load(38.0);
  SECTION("beyond it the lift ends") {
    const auto event = rig.run([&] { return rig.lift.lift(); }, 0.8);
    REQUIRE(event);
    CHECK(event->event == Event::LimitReached);
    CHECK_THAT(event->detail, Catch::Contains("the partner bears about 11") &&
                                  Catch::Contains("limit 100 N") &&
                                  Catch::Contains("predicted share of 25 % (12 to 41 %)"));
  }
  SECTION("a mass that was known was compared before the lift") {
    rig.c->record.decision->share.mass_kg = 12.0;
    CHECK_FALSE(rig.run([&] { return rig.lift.lift(); }, 0.8));
  }
}

TEST_CASE("a load that jumps while the object is held means that the partner let go", "[phases]") {
  Loaded rig;
  REQUIRE(rig.lift_up());
  rig.enter(Task::Hold);
  rig.lift.begin_hold();
  rig.load(15.0);
  rig.idle(0.5);
  rig.lift.begin_hold();
  CHECK_FALSE(rig.run([&] { return rig.lift.hold(); }, 0.5));
  SECTION("by more than the limits") {
    rig.load(30.0);
    const auto event = rig.run([&] { return rig.lift.hold(); }, 0.5);
    REQUIRE(event);
    CHECK(event->event == Event::PartnerLetGo);
  }
  SECTION("by less") {
    rig.load(19.0);
    CHECK_FALSE(rig.run([&] { return rig.lift.hold(); }, 0.5));
  }
}

TEST_CASE("the hold begins when arm and partner pass no more load to each other", "[phases]") {
  Loaded rig;
  rig.load(20.0);
  const auto steady = rig.lift_up();
  REQUIRE(steady);
  CHECK(steady->event == Event::AtHeight);
  CHECK_THAT(steady->detail, !Catch::Contains("still changes"));
  rig.record_hold();
  CHECK(rig.c->record.lift->load_steady);

  // at the latest when it had its time to come to rest, and that is said
  Loaded other;
  other.enter(Task::Lift);
  other.lift.begin_lift(Task::AwaitReady);
  const auto swings = [&] {
    other.load(20.0 + 4.0 * std::sin(3.0 * other.c->in_state_s()));
    return other.lift.lift();
  };
  const auto swinging = other.run(swings, 20.0);
  REQUIRE(swinging);
  CHECK(swinging->event == Event::AtHeight);
  CHECK_THAT(swinging->detail, Catch::Contains("still changes"));
  const CarryConfig& carry = other.c->config.task.carry;
  CHECK(other.c->in_state_s() - rig.c->in_state_s() ==
        Approx(carry.max_unsteady_s - carry.settle_s - carry.steady_s).margin(0.2));
  other.record_hold();
  CHECK_FALSE(other.c->record.lift->load_steady);
}

TEST_CASE("after a test lift the rest is lifted slowly", "[phases]") {
  Config config = unannounced();
  config.task.slow_fraction = 1.0;  // there is no camera here, which slows every lift
  config.task.carry.steady_s = 0.0;
  Loaded rig(config);
  rig.enter(Task::Lift);
  rig.c->arm.start_lift(LiftController::Role::Lead, 0.01, 1.0);
  rig.idle(1.5);
  rig.lift.begin_lift(Task::TestLift);
  rig.enter(Task::Lift);
  REQUIRE(rig.run([&] { return rig.lift.lift(); }, 30.0)->event == Event::AtHeight);
  CHECK(rig.c->in_state_s() == Approx(0.04 / 0.005).margin(0.5));
}

TEST_CASE("a test lift that saw nothing is put down, and its grasp is left out", "[phases]") {
  Loaded rig;
  perception::Target& target = rig.c->session.analysis().scene.target.emplace();
  target.cog = {0.0, 0.0, 0.3};
  target.shape.size = {0.8, 0.6, 0.3};
  rig.enter(Task::TestLift);
  rig.test_lift.begin();
  CHECK(rig.test_lift.leg() == TestLiftPhase::Leg::Raising);
  const auto event = rig.run([&] { return rig.test_lift.test_lift(); });
  REQUIRE(event);
  CHECK(event->event == Event::HangsAskew);
  CHECK(rig.test_lift.leg() == TestLiftPhase::Leg::Measuring);
  CHECK(rig.c->attempts.regrasp);
  REQUIRE(rig.c->record.test_lifts.size() == 1);
  CHECK(rig.c->record.test_lifts[0].height_m == Approx(0.03).margin(1e-3));
  CHECK_FALSE(rig.c->record.test_lifts[0].known);
}

TEST_CASE("a load that grows at once during the lift means that the partner let go", "[phases]") {
  Loaded rig;
  rig.enter(Task::Lift);
  rig.lift.begin_lift(Task::AwaitReady);
  rig.load(20.0);
  (void)rig.run([&] { return rig.lift.lift(); }, 0.5);
  rig.let_go.ask_again();
  CHECK_FALSE(rig.run([&] { return rig.lift.lift(); }, 0.2));
  rig.load(70.0);
  const double before_s = rig.c->in_state_s();
  const auto event = rig.run([&] { return rig.lift.lift(); }, 0.5);
  REQUIRE(event);
  CHECK(event->event == Event::PartnerLetGo);
  CHECK(rig.c->in_state_s() - before_s < 0.15);
}

TEST_CASE("a grip that had pressed the object down and bears it now has no partner who let go", "[phases]") {
  Loaded rig;
  rig.enter(Task::Lift);
  rig.lift.begin_lift(Task::AwaitReady);
  rig.load(-40.0);
  (void)rig.run([&] { return rig.lift.lift(); }, 0.5);
  rig.let_go.ask_again();
  rig.load(10.0);
  CHECK_FALSE(rig.run([&] { return rig.lift.lift(); }, 0.5));
}

TEST_CASE("a pause holds the arm where it is, and ends in time without the partner", "[phases]") {
  Loaded rig;
  rig.enter(Task::Lift);
  rig.lift.begin_lift(Task::AwaitReady);
  (void)rig.run([&] { return rig.lift.lift(); }, 1.5);
  REQUIRE(rig.c->arm.view().height_m > 0.01);
  rig.enter(Task::Pause);
  rig.pause.begin(Task::Lift, Event::PartnerLetGo, "his hand left the grasp");
  rig.idle(0.3);
  const double height_m = rig.c->palm().translation().z();
  const auto event = rig.run([&] { return rig.pause.pause(); });
  REQUIRE(event);
  CHECK(event->event == Event::TimeOut);
  CHECK(rig.c->in_state_s() == Approx(20.0).margin(0.1));
  CHECK(rig.c->palm().translation().z() == Approx(height_m).margin(1e-4));
  REQUIRE(rig.c->record.asked.size() == 1);
}

TEST_CASE("an object that stands already is set down, and not said to have been set down by both",
          "[phases]") {
  Loaded rig;
  rig.enter(Task::Pause);
  SECTION("while it was lowered: at once") {
    rig.pause.begin(Task::Lower, Event::PartnerLetGo, "his hand left the grasp");
    REQUIRE(rig.run([&] { return rig.pause.pause(); })->event == Event::OnGround);
    CHECK(rig.c->in_state_s() == Approx(0.5).margin(0.02));
    CHECK_THAT(rig.c->attempts.failure,
               Catch::Contains("not known whether the partner set it down: his hand left"));
  }
  SECTION("while it was lifted: when nobody took it up") {
    rig.pause.begin(Task::Lift, Event::PartnerLetGo, "his hand left the grasp");
    REQUIRE(rig.run([&] { return rig.pause.pause(); })->event == Event::OnGround);
    CHECK(rig.c->in_state_s() == Approx(20.0).margin(0.1));
    CHECK_THAT(rig.c->attempts.failure, Catch::Contains("not known whether the partner lifted it"));
  }
  SECTION("after a limit had ended the lift, that is the cause") {
    rig.c->attempts.failed = true;
    rig.c->attempts.failure = "the object slips 38 mm in the hand";
    rig.pause.begin(Task::Lower, Event::PartnerLetGo, "his end falls");
    REQUIRE(rig.run([&] { return rig.pause.pause(); })->event == Event::OnGround);
    CHECK(rig.c->attempts.failure == "the object slips 38 mm in the hand");
  }
  SECTION("not while it hangs") {
    rig.load(8.0);
    rig.idle(0.5);
    rig.pause.begin(Task::Lower, Event::PartnerLetGo, "his hand left the grasp");
    CHECK(rig.run([&] { return rig.pause.pause(); })->event == Event::TimeOut);
    CHECK_FALSE(rig.c->attempts.failed);
    return;
  }
  CHECK(rig.c->attempts.failed);
  CHECK_FALSE(rig.c->attempts.regrasp);
}

TEST_CASE("the load says that the partner bears his part again", "[phases]") {
  CHECK(is_borne_again(20.0, 21.0, 0.3, false));
  CHECK_FALSE(is_borne_again(30.0, 21.0, 0.3, false));
  CHECK_FALSE(is_borne_again(30.0, 21.0, 0.3, true));
  CHECK(is_borne_again(12.0, 40.0, 0.3, true));         // he had let it sink, and bears more than before
  CHECK_FALSE(is_borne_again(12.0, 40.0, 0.3, false));  // the ground may bear that
}

TEST_CASE("a load that vanishes while the hold waits for a steady one is an object that was lost",
          "[phases]") {
  Loaded rig;
  rig.enter(Task::Lift);
  rig.lift.begin_lift(Task::AwaitReady);
  double at_top_s = NAN;
  const auto swings = [&] {
    const double now_s = rig.c->in_state_s();
    if (std::isnan(at_top_s) && rig.c->arm.lift_at_rest() && rig.c->arm.view().height_m > 0.04)
      at_top_s = now_s;
    const bool lost = now_s - at_top_s > rig.c->config.task.carry.settle_s + 1.0;
    rig.load(lost ? 1.0 : 20.0 + 4.0 * std::sin(3.0 * now_s));
    return rig.lift.lift();
  };
  const auto event = rig.run(swings, 20.0);
  REQUIRE(event);
  CHECK(event->event == Event::HandEmpty);
  CHECK_THAT(event->detail, Catch::Contains("sudden loss of load"));
  CHECK(rig.c->in_state_s() - at_top_s < rig.c->config.task.carry.settle_s + 2.0);
}

TEST_CASE("a load that vanishes in the air is an object that was lost", "[phases]") {
  Loaded rig;
  REQUIRE(rig.lift_up());
  rig.load(20.0);
  rig.idle(0.5);
  rig.enter(Task::Hold);
  rig.lift.begin_hold();
  CHECK_FALSE(rig.run([&] { return rig.lift.hold(); }, 0.5));
  rig.load(2.0);
  const auto event = rig.run([&] { return rig.lift.hold(); }, 0.8);
  REQUIRE(event);
  CHECK(event->event == Event::HandEmpty);
}

TEST_CASE("a lift that meets a limit stands still while it is announced that it goes down", "[phases]") {
  Config config;
  config.task.slow_fraction = 1.0;  // there is no camera here, which slows every lift
  Loaded rig(config);
  rig.enter(Task::Lift);
  rig.lift.begin_lift(Task::AwaitReady);
  CHECK_FALSE(rig.run([&] { return rig.lift.lift(); }, 0.45));
  CHECK(rig.c->arm.view().height_m < 1e-4);
  CHECK_FALSE(rig.run([&] { return rig.lift.lift(); }, 1.5));
  const double height_m = rig.c->arm.view().height_m;
  CHECK(height_m > 0.01);
  rig.enter(Task::Lower);
  rig.lift.begin_lower();
  (void)rig.run([&] { return rig.lift.lower(); }, 0.45);
  CHECK(rig.c->arm.view().height_m > height_m - 0.002);
  CHECK(rig.c->record.intents.back().motion == Motion::Lower);
  (void)rig.run([&] { return rig.lift.lower(); }, 1.5);
  CHECK(rig.c->arm.view().height_m < height_m - 0.005);
}
