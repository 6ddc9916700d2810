// Approach, halt, back-off and retreat with a mock arm: legs, and how each ends.
#include <catch2/catch.hpp>

#include "control/task/phases/approach_phase.hpp"
#include "control/task/phases/back_off_phase.hpp"
#include "control/task/phases/contact_phase.hpp"
#include "control/task/phases/retreat_phase.hpp"
#include "phase_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

namespace {

struct EmptyHand : PhaseRig {
  explicit EmptyHand(const Config& config = unannounced()) : PhaseRig(config) {
    make_plan();
    make_decision();
    retreat.set_home(phase_home());
  }

  void begin_approach() {
    enter(Task::Approach);
    approach.begin();
  }
  void approach_until(ApproachPhase::Leg leg) {
    begin_approach();
    const auto nothing = run([&]() -> std::optional<TaskEvent> {
      auto event = approach.approach();
      if (!event && approach.leg() == leg && c->arm.progress() > 0.2)
        return TaskEvent{Event::Interrupted, ""};
      return event;
    });
    REQUIRE(nothing);
    REQUIRE(nothing->event == Event::Interrupted);
  }
  [[nodiscard]] std::optional<TaskEvent> back_off_after(Event cause) {
    enter(Task::BackOff);
    back_off.begin(cause, approach.abandon(), approach.set_out());
    return run([this] { return back_off.back_off(); });
  }
  /// Met by something that pushes for so long.
  [[nodiscard]] std::optional<TaskEvent> contact_after(double push_s, bool nobody_near = true) {
    enter(Task::Contact);
    contact.begin("unexpected contact");
    Eigen::Matrix<double, 6, 1> push = Eigen::Matrix<double, 6, 1>::Zero();
    push[1] = 60.0;
    external_nm =
        hal::jacobian(hal::built_in_robot(), c->arm.commanded(), hal::Vec3::Zero()).transpose() * push;
    if (auto event = run([&] { return contact.contact(nobody_near); }, push_s)) return event;
    external_nm.setZero();
    return run([&] { return contact.contact(nobody_near); });
  }
  [[nodiscard]] double off(const hal::JointVector& q) const {
    return (c->arm.commanded() - q).cwiseAbs().maxCoeff();
  }

  PartnerMonitor partner{*c};
  ObjectMonitor object{*c};
  GraspSelector grasps{*c};
  ScenePhase scene{*c, grasps};
  ApproachPhase approach{*c, partner};
  BackOffPhase back_off{*c, partner};
  LetGoMonitor let_go{*c, object};
  LiftEvidence evidence{*c, object, let_go};
  RetreatPhase retreat{*c, object, grasps, scene, evidence};
  ContactPhase contact{*c};
};

}  // namespace

TEST_CASE("an approach runs its two legs and ends at the grasp", "[phases]") {
  EmptyHand rig;
  rig.begin_approach();
  CHECK(rig.approach.leg() == ApproachPhase::Leg::Transit);
  CHECK(rig.hand->commands == std::vector<std::string>{"preshape"});
  const auto event = rig.run([&] { return rig.approach.approach(); });
  REQUIRE(event);
  CHECK(event->event == Event::Arrived);
  CHECK(rig.approach.leg() == ApproachPhase::Leg::Straight);
  CHECK(rig.off(rig.c->record.plan->approach.goal()) < 1e-6);
  CHECK(rig.c->attempts.approaches == 1);
}

TEST_CASE("an approach waits for a hand that still opens", "[phases]") {
  EmptyHand rig;
  rig.hand->now.moving = true;
  rig.begin_approach();
  CHECK_FALSE(rig.run([&] { return rig.approach.approach(); }, 7.0));
  CHECK(rig.approach.leg() == ApproachPhase::Leg::Transit);
  const auto event = rig.run([&] { return rig.approach.approach(); }, 2.0);
  REQUIRE(event);
  CHECK(event->event == Event::HandUnfit);
  CHECK_THAT(event->detail, Catch::Contains("not open after 8 s"));
}

TEST_CASE("a hand that refuses to open ends the approach before the arm moves", "[phases]") {
  EmptyHand rig;
  rig.hand->refusal = hal::Error{hal::ErrorCode::NotReady, "hand.preshape", "the hand holds something"};
  rig.begin_approach();
  const auto event = rig.run([&] { return rig.approach.approach(); }, 0.1);
  REQUIRE(event);
  CHECK(event->event == Event::HandUnfit);
  CHECK_THAT(event->detail, Catch::Contains("the hand holds something"));
  const auto back = rig.back_off_after(Event::HandUnfit);
  REQUIRE(back);
  CHECK(back->event == Event::BackHome);
  CHECK(rig.off(phase_home()) == 0.0);
}

TEST_CASE("a finger that stays closed ends the approach on its path, and the arm goes back", "[phases]") {
  EmptyHand rig;
  rig.hand->now.finger_rad[1] = 0.7;
  rig.begin_approach();
  const auto event = rig.run([&] { return rig.approach.approach(); }, 0.3);
  REQUIRE(event);
  CHECK(event->event == Event::HandUnfit);
  CHECK_THAT(event->detail, Catch::Contains("finger 2 is at 40 deg"));
  const auto back = rig.back_off_after(Event::HandUnfit);
  REQUIRE(back);
  CHECK(back->event == Event::BackHome);
  CHECK(rig.off(phase_home()) < 1e-6);
}

TEST_CASE("an arm that takes no commands for a moment sets out afterwards, and felt no force", "[phases]") {
  EmptyHand rig;
  rig.arm->inject(sim_hal::MockArm::Fault::Nan, *rig.arm->cycle() + 1, 40);
  rig.idle(0.1);
  REQUIRE_FALSE(rig.c->arm.view().running);
  rig.begin_approach();
  CHECK(rig.approach.leg() == ApproachPhase::Leg::Announced);
  CHECK_FALSE(rig.run([&] { return rig.approach.approach(); }, 0.5));
  CHECK(rig.approach.leg() == ApproachPhase::Leg::Transit);
}

TEST_CASE("an arm that never takes commands is announced for no longer than its timeout", "[phases]") {
  EmptyHand rig;
  rig.arm->stop();
  rig.idle(0.1);
  rig.begin_approach();
  const auto event = rig.run([&] { return rig.approach.approach(); });
  REQUIRE(event);
  CHECK(event->event == Event::TimeOut);
  CHECK(rig.c->in_state_s() < 10.0);
}

TEST_CASE("an approach whose path starts elsewhere does not set out, says where, and feels no force",
          "[phases]") {
  EmptyHand rig;
  hal::JointVector elsewhere = phase_home();
  elsewhere[2] += 0.2;
  rig.c->record.plan->transit = trajectory(elsewhere, phase_home());
  rig.begin_approach();
  const auto event = rig.run([&] { return rig.approach.approach(); });
  REQUIRE(event);
  CHECK(event->event == Event::TimeOut);
  CHECK_THAT(event->detail, Catch::Contains("A3"));
}

TEST_CASE("a contact on the way blocks the approach", "[phases]") {
  EmptyHand rig;
  rig.approach_until(ApproachPhase::Leg::Transit);
  Eigen::Matrix<double, 6, 1> push = Eigen::Matrix<double, 6, 1>::Zero();
  push[1] = 60.0;
  rig.external_nm =
      hal::jacobian(hal::built_in_robot(), rig.c->arm.commanded(), hal::Vec3::Zero()).transpose() * push;
  const auto event = rig.run([&] { return rig.approach.approach(); }, 0.2);
  REQUIRE(event);
  CHECK(event->event == Event::Blocked);
}

TEST_CASE("what an open hand meets at the object is left when its force is gone", "[phases]") {
  EmptyHand rig;
  rig.approach_until(ApproachPhase::Leg::Straight);
  SECTION("a moment, and nobody near") {
    const auto event = rig.contact_after(0.3);
    REQUIRE(event);
    CHECK(event->event == Event::ForceGone);
    CHECK_THAT(event->detail, Catch::Contains("unexpected contact"));
    CHECK(rig.c->in_state_s() >= rig.c->config.monitor.force.yield_s);
  }
  SECTION("somebody near") {
    const auto event = rig.contact_after(0.3, false);
    REQUIRE(event);
    CHECK(event->event == Event::Blocked);
    CHECK_THAT(event->detail, Catch::Contains("somebody is near"));
  }
  SECTION("who keeps pushing is no object") {
    const auto event = rig.contact_after(2.0);
    REQUIRE(event);
    CHECK(event->event == Event::Blocked);
    CHECK_THAT(event->detail, Catch::Contains("the force stays"));
  }
}

TEST_CASE("a hand that met the object goes straight back, and not to the grasp first", "[phases]") {
  EmptyHand rig;
  rig.approach_until(ApproachPhase::Leg::Straight);
  REQUIRE(rig.contact_after(0.3)->event == Event::ForceGone);
  const hal::JointVector grasp = rig.c->record.plan->approach.goal();
  const double stopped_off = rig.off(grasp);
  rig.c->attempts.failed = rig.c->attempts.touched = true;
  rig.enter(Task::Retreat);
  rig.retreat.begin_retreat(true);
  double nearest = stopped_off;
  const auto event = rig.run([&] {
    nearest = std::min(nearest, rig.off(grasp));
    return rig.retreat.retreat();
  });
  REQUIRE(event);
  CHECK(nearest > stopped_off - 1e-3);
  CHECK(event->event == Event::TryAgain);
  CHECK(rig.off(phase_home()) < 1e-6);
}

TEST_CASE("as often as the arm may set out, a hand that met something tries elsewhere", "[phases]") {
  EmptyHand rig;
  rig.approach_until(ApproachPhase::Leg::Straight);
  REQUIRE(rig.contact_after(0.3)->event == Event::ForceGone);
  rig.c->attempts.failed = rig.c->attempts.touched = true;
  rig.c->attempts.approaches = rig.c->config.task.attempts.max_approaches;
  rig.enter(Task::Retreat);
  rig.retreat.begin_retreat(true);
  CHECK(rig.run([&] { return rig.retreat.retreat(); })->event == Event::BackInVain);
}

TEST_CASE("on the way back an open hand may meet the object, but not for ever, and not on the way home",
          "[phases]") {
  EmptyHand rig;
  rig.begin_approach();
  REQUIRE(rig.run([&] { return rig.approach.approach(); }));
  rig.enter(Task::Retreat);
  rig.retreat.begin_retreat(false);
  int contacts = 0;
  for (; contacts < 100 && rig.retreat.may_touch(); ++contacts) rig.retreat.begin_retreat(true);
  CHECK(contacts == 3);
  rig.retreat.begin_retreat(false);
  CHECK(rig.retreat.may_touch());
  const auto home = rig.run([&]() -> std::optional<TaskEvent> {
    if (rig.retreat.leg() == RetreatPhase::Leg::Home) return TaskEvent{Event::Interrupted, ""};
    return rig.retreat.retreat();
  });
  REQUIRE(home);
  CHECK(home->event == Event::Interrupted);
  CHECK_FALSE(rig.retreat.may_touch());
}

TEST_CASE("an approach that is given up says once whether it was near the object", "[phases]") {
  EmptyHand rig;
  rig.approach_until(ApproachPhase::Leg::Straight);
  CHECK(rig.approach.abandon());
  CHECK_FALSE(rig.approach.abandon());
}

TEST_CASE("a halt ends when the camera is back, or at its timeout", "[phases]") {
  EmptyHand rig;
  rig.enter(Task::Halt);
  rig.approach.begin_halt();
  rig.c->readings.camera_lost = true;
  auto event = rig.approach.halt();
  CHECK_FALSE(event);
  rig.c->now += hal::duration_of(rig.c->config.task.partner_timeout_s + 0.1);
  event = rig.approach.halt();
  REQUIRE(event);
  CHECK(event->event == Event::TimeOut);
  rig.c->readings.camera_lost = false;
  CHECK(rig.approach.halt()->event == Event::CameraBack);
}

TEST_CASE("who only moved his hand is followed from where the arm stopped", "[phases]") {
  EmptyHand rig;
  rig.approach_until(ApproachPhase::Leg::Transit);
  const auto event = rig.back_off_after(Event::PartnerMoved);
  REQUIRE(event);
  CHECK(event->event == Event::BackHome);
  CHECK(rig.back_off.leg() == BackOffPhase::Leg::Braking);
  CHECK(rig.off(phase_home()) > 0.02);
}

TEST_CASE("for a partner who let go the arm goes all the way back", "[phases]") {
  EmptyHand rig;
  SECTION("from the transit") {
    rig.approach_until(ApproachPhase::Leg::Transit);
    const auto event = rig.back_off_after(Event::PartnerLetGo);
    REQUIRE(event);
    CHECK(event->event == Event::BackHome);
    CHECK(rig.back_off.leg() == BackOffPhase::Leg::Backwards);
  }
  SECTION("from near the object: first to the pre-grasp") {
    rig.approach_until(ApproachPhase::Leg::Straight);
    const auto event = rig.back_off_after(Event::PartnerLetGo);
    REQUIRE(event);
    CHECK(event->event == Event::BackHome);
    CHECK(rig.back_off.leg() == BackOffPhase::Leg::Home);
  }
  CHECK(rig.off(phase_home()) < 0.01);
}

TEST_CASE("after five approaches the job is given up", "[phases]") {
  EmptyHand rig;
  rig.approach_until(ApproachPhase::Leg::Transit);
  rig.c->attempts.approaches = 5;
  const auto event = rig.back_off_after(Event::PartnerMoved);
  REQUIRE(event);
  CHECK(event->event == Event::BackInVain);
  CHECK(rig.off(phase_home()) < 0.01);
}

TEST_CASE("a hand is open when every finger that answers is", "[phases]") {
  EmptyHand rig;
  rig.enter(Task::Release);
  rig.retreat.begin_release();
  CHECK(rig.hand->commands == std::vector<std::string>{"release"});
  rig.hand->now.finger_rad = {0.0, 1.2, 0.0};
  SECTION("one stays closed") {
    const auto event = rig.run([&] { return rig.retreat.release(); }, 20.0);
    REQUIRE(event);
    CHECK(event->event == Event::TimeOut);
  }
  SECTION("the one that stays closed is the one that does not answer") {
    rig.c->readings.without_puck = 1;
    const auto event = rig.run([&] { return rig.retreat.release(); }, 1.0);
    REQUIRE(event);
    CHECK(event->event == Event::HandOpen);
  }
  SECTION("all open") {
    rig.hand->now.finger_rad = {};
    const auto event = rig.run([&] { return rig.retreat.release(); }, 1.0);
    REQUIRE(event);
    CHECK(event->event == Event::HandOpen);
  }
}

TEST_CASE("a hand that still carries something stays closed", "[phases]") {
  EmptyHand rig;
  rig.hand->now.held = true;
  const auto load = [&](double force_n) {
    Eigen::Matrix<double, 6, 1> wrench = Eigen::Matrix<double, 6, 1>::Zero();
    wrench[2] = -force_n;
    rig.external_nm =
        hal::jacobian(hal::built_in_robot(), rig.c->arm.commanded(), hal::Vec3::Zero()).transpose() * wrench;
  };
  load(20.0);
  rig.idle(0.5);
  rig.enter(Task::Release);
  const double before_m = rig.c->palm().translation().z();
  rig.retreat.begin_release();
  CHECK(rig.c->arm_moves());  // so that it is slowed for people, and waits for them no longer than elsewhere
  SECTION("whatever the time: it is set down by 20 mm at most, then a person decides") {
    const auto event = rig.run([&] { return rig.retreat.release(); }, 60.0);
    REQUIRE(event);
    CHECK(event->event == Event::StillLoaded);
    CHECK(rig.hand->commands.empty());
    CHECK(before_m - rig.c->palm().translation().z() == Approx(0.02).margin(0.002));
  }
  SECTION("and for no longer than a wait may take, where the arm waits for somebody") {
    rig.c->arm.set_scale(0.0);
    const hal::Timestamp begun = rig.c->now;
    const auto event = rig.run([&] { return rig.retreat.release(); }, 200.0);
    REQUIRE(event);
    CHECK(event->event == Event::StillLoaded);
    CHECK(hal::seconds(rig.c->now - begun) < rig.c->config.monitor.max_wait_s + 10.0);
    CHECK(rig.hand->commands.empty());
    CHECK(before_m - rig.c->palm().translation().z() < 0.002);
  }
  SECTION("once it stands, the hand opens") {
    CHECK_FALSE(rig.run([&] { return rig.retreat.release(); }, 1.0));
    load(1.0);
    rig.hand->now.finger_rad.fill(1.2);
    CHECK_FALSE(rig.run([&] { return rig.retreat.release(); }, 1.0));
    CHECK(rig.hand->commands == std::vector<std::string>{"release"});
    CHECK_FALSE(rig.c->arm_moves());
  }
}

TEST_CASE("a retreat goes from the object, then home, and says how the job stands", "[phases]") {
  EmptyHand rig;
  rig.begin_approach();
  REQUIRE(rig.run([&] { return rig.approach.approach(); }));
  rig.enter(Task::Retreat);
  rig.retreat.begin_retreat(false);
  CHECK(rig.retreat.leg() == RetreatPhase::Leg::FromObject);
  Attempts& attempts = rig.c->attempts;
  Event wanted = Event::BackInVain;
  SECTION("nothing failed, but nobody saw the object in the air") {
    const auto event = rig.run([&] { return rig.retreat.retreat(); });
    REQUIRE(event);
    CHECK(event->event == Event::BackInVain);
    CHECK(event->detail == "not lifted: it was never held at its height");
    return;
  }
  SECTION("the first grip failed: tries again") {
    attempts.failed = true;
    wanted = Event::TryAgain;
  }
  SECTION("the second grip failed") {
    attempts.failed = true;
    attempts.approaches = 2;
    attempts.failure = "the fingers met nothing";
    wanted = Event::BackInVain;
  }
  SECTION("a lift that failed is not tried again") {
    attempts.failed = attempts.lifted = true;
    wanted = Event::BackInVain;
  }
  SECTION("a test lift asks for another grasp") {
    attempts.failed = attempts.lifted = attempts.regrasp = true;
    wanted = Event::TryAgain;
  }
  const auto event = rig.run([&] { return rig.retreat.retreat(); });
  REQUIRE(event);
  CHECK(event->event == wanted);
  CHECK(event->detail == attempts.failure);
  CHECK(rig.retreat.leg() == RetreatPhase::Leg::Home);
  CHECK(rig.off(phase_home()) < 0.01);
}

TEST_CASE("a retreat without a path home stays clear of the object, and says why", "[phases][faults]") {
  EmptyHand rig;
  rig.begin_approach();
  REQUIRE(rig.run([&] { return rig.approach.approach(); }));
  JointVector elsewhere = phase_home();
  elsewhere[0] += 0.4;  // than where the plan began, and without a collision world nothing leads there
  rig.retreat.set_home(elsewhere);
  rig.enter(Task::Retreat);
  rig.retreat.begin_retreat(false);
  const auto event = rig.run([&] { return rig.retreat.retreat(); });
  REQUIRE(event);
  CHECK(event->event == Event::TimeOut);
  CHECK_THAT(event->detail, Catch::Contains("no collision world"));
  CHECK(rig.off(rig.c->record.plan->retreat.goal()) < 0.01);
  CHECK(rig.c->arm.at_rest());
}

TEST_CASE("a retreat keeps the acceleration that the configuration allows planned motions", "[phases]") {
  const auto hardest = [](double allowed_rad_s2) {
    Config config = unannounced();
    config.motion.acceleration_rad_s2 = allowed_rad_s2;
    EmptyHand rig(config);
    rig.begin_approach();
    REQUIRE(rig.run([&] { return rig.approach.approach(); }));
    rig.enter(Task::Retreat);
    rig.retreat.begin_retreat(false);
    constexpr double kCycle_s = 0.005;
    JointVector q = rig.c->arm.commanded(), v = JointVector::Zero();
    double most = 0.0;
    REQUIRE(rig.run([&]() -> std::optional<TaskEvent> {
      const JointVector now = rig.c->arm.commanded(), speed = (now - q) / kCycle_s;
      most = std::max(most, (speed - v).cwiseAbs().maxCoeff() / kCycle_s);
      q = now;
      v = speed;
      if (rig.retreat.leg() == RetreatPhase::Leg::Home) return TaskEvent{Event::Interrupted, ""};
      return rig.retreat.retreat();
    }));
    return most;
  };
  CHECK(hardest(0.05) < 0.06);  // T1 has 0.5 rad/s^2
  CHECK(hardest(2.0) > 0.06);
}

TEST_CASE("neither arm nor hand moves before it was announced for half a second", "[phases]") {
  EmptyHand rig(Config{});
  rig.begin_approach();
  CHECK_FALSE(rig.run([&] { return rig.approach.approach(); }, 0.45));
  CHECK(rig.approach.leg() == ApproachPhase::Leg::Announced);
  CHECK(rig.hand->commands.empty());
  CHECK(rig.off(phase_home()) == 0.0);
  const auto arrived = rig.run([&] { return rig.approach.approach(); });
  REQUIRE(arrived);
  CHECK(arrived->event == Event::Arrived);

  rig.hand->commands.clear();
  rig.enter(Task::Release);
  rig.retreat.begin_release();
  CHECK_FALSE(rig.run([&] { return rig.retreat.release(); }, 0.45));
  CHECK(rig.hand->commands.empty());
  (void)rig.run([&] { return rig.retreat.release(); }, 0.2);
  CHECK(rig.hand->commands == std::vector<std::string>{"release"});

  std::vector<Motion> motions;
  for (const Intent& intent : rig.c->record.intents) motions.push_back(intent.motion.value());
  CHECK(motions == std::vector{Motion::Approach, Motion::Close, Motion::Open, Motion::Retreat});
}
