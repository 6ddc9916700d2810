// What the supervisors make of the devices: lost, back, slow.
#include <catch2/catch.hpp>

#include "phase_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

namespace {

std::uint64_t next_cycle(const PhaseRig& rig) {
  return rig.arm->cycle().value_or(0) + 1;
}

}  // namespace

TEST_CASE("five missed cycles of the arm are nothing; a fifth of a second is an interruption that heals",
          "[supervision]") {
  PhaseRig rig;
  REQUIRE(rig.started);
  rig.arm->inject(sim_hal::MockArm::Fault::Drop, next_cycle(rig), 5);
  rig.idle(0.05);
  CHECK_FALSE(rig.arms->interrupted());
  CHECK(rig.notes().empty());

  rig.arm->inject(sim_hal::MockArm::Fault::Drop, next_cycle(rig), 40);
  rig.idle(0.1);
  CHECK(rig.arms->interrupted());
  CHECK_FALSE(rig.arms->lost());
  rig.idle(0.2);
  CHECK_FALSE(rig.arms->interrupted());
  CHECK_THAT(rig.notes(), Catch::Contains("arm: takes commands again after 0."));
  CHECK(rig.arms->take_restart());
  CHECK_FALSE(rig.arms->take_restart());
}

TEST_CASE("an arm that stays away for longer than its timeout is lost", "[supervision]") {
  PhaseRig rig;
  rig.arm->inject(sim_hal::MockArm::Fault::Drop, next_cycle(rig), 1000);
  rig.idle(0.9);
  CHECK_FALSE(rig.arms->lost());
  rig.idle(0.3);
  CHECK(rig.arms->lost());
  CHECK_FALSE(rig.arms->fault().empty());
}

TEST_CASE("an arm that left command mode before anybody looked at it is lost, and not waited for for ever",
          "[supervision]") {
  PhaseRig rig;
  REQUIRE(rig.c->arm.view().starts > 0);
  rig.arm->stop();
  ArmSupervisor late(*rig.c);
  for (const hal::Timestamp end = rig.clock.now() + hal::duration_of(1.5); rig.clock.now() < end;) {
    late.read("");
    rig.c->arm.end_cycle();
  }
  CHECK_FALSE(rig.c->arm.view().state.may_command);
  CHECK(late.lost());
  CHECK_THAT(late.fault(), Catch::Contains("takes no commands"));
}

TEST_CASE("an arm whose link is lost is lost at once", "[supervision]") {
  PhaseRig rig;
  rig.arm->inject(sim_hal::MockArm::Fault::Unplug, next_cycle(rig), 1000);
  rig.cycle([] { return std::optional<TaskEvent>(); });
  CHECK(rig.arms->lost());
}

TEST_CASE("how many missed cycles count is a parameter", "[supervision]") {
  Config config;
  config.task.supervision.arm_max_misses = 30;
  PhaseRig rig(config);
  rig.arm->inject(sim_hal::MockArm::Fault::Drop, next_cycle(rig), 20);
  rig.idle(0.09);
  CHECK_FALSE(rig.arms->interrupted());
}

TEST_CASE("a hand that does not answer for 0.2 s is lost, and the silent puck is known by name",
          "[supervision]") {
  PhaseRig rig;
  rig.hand->error = hal::Error{hal::ErrorCode::Timeout, "hand.f2.state", "no answer"};
  rig.idle(0.15);
  CHECK_FALSE(rig.hands->lost());
  rig.idle(0.1);
  CHECK(rig.hands->lost());
  REQUIRE(rig.hands->silent_puck());
  CHECK(*rig.hands->silent_puck() == 1);

  rig.hands->continue_without_puck();
  CHECK_FALSE(rig.hands->lost());
  CHECK(rig.c->readings.without_puck == 1u);

  rig.hand->error.reset();
  rig.idle(0.02);
  CHECK_FALSE(rig.hands->lost());
}

TEST_CASE("a hand whose link is lost is lost at once, and no puck alone", "[supervision]") {
  PhaseRig rig;
  rig.hand->error = hal::Error{hal::ErrorCode::LinkLost, "hand", "the bus is gone"};
  rig.cycle([] { return std::optional<TaskEvent>(); });
  CHECK(rig.hands->lost());
  CHECK_FALSE(rig.hands->silent_puck());
}

TEST_CASE("the arm goes slowly while the hand warns, and says so once", "[supervision]") {
  PhaseRig rig;
  rig.hand->now.warning.set("F1 is warm");
  rig.idle(1.0);
  CHECK(rig.speed->reason() == "the hand: F1 is warm");
  CHECK(rig.c->arm.view().slow);
  rig.hand->now.warning.set("");
  rig.idle(1.0);
  CHECK(rig.speed->reason().empty());
  CHECK_FALSE(rig.c->arm.view().slow);
  CHECK_THAT(rig.notes(), Catch::Contains("arm: continues at reduced speed: the hand: F1 is warm"));
  CHECK_THAT(rig.notes(), Catch::Contains("arm: goes at its full speed again"));
}

TEST_CASE("old pictures slow a moving arm, fresh ones let it go on", "[supervision]") {
  PhaseRig rig;
  rig.enter(Task::Approach);
  const auto film = [&](int frames, double period_s, hal::Duration late) {
    for (int i = 0; i < frames; ++i) {
      hal::DepthFrame frame = rig.frame(1.0f + 0.001f * static_cast<float>(rig.c->now.count() % 997));
      frame.exposed_at -= late;
      rig.camera->frames.push_back(frame);
      rig.idle(period_s);
    }
  };
  film(60, 0.033, 10ms);
  CHECK(rig.speed->reason().empty());
  film(60, 0.033, 200ms);
  CHECK_THAT(rig.speed->reason(), Catch::Contains("ms old in the mean"));
  film(60, 0.033, 10ms);
  CHECK(rig.speed->reason().empty());
}

TEST_CASE("a frame is passed on when it is whole, new, and no repeat in front of a moving arm",
          "[supervision]") {
  PhaseRig rig;
  const auto nothing = [] { return std::optional<TaskEvent>(); };
  rig.clock.advance(1ms);
  rig.camera->frames.push_back(rig.frame(1.0f));
  rig.cycle(nothing);
  CHECK(rig.c->readings.frame.has_value());
  rig.cycle(nothing);
  CHECK_FALSE(rig.c->readings.frame.has_value());

  hal::DepthFrame torn = rig.frame(1.1f);
  torn.depth_m.resize(7);
  rig.camera->frames.push_back(torn);
  rig.cycle(nothing);
  CHECK_FALSE(rig.c->readings.frame.has_value());

  rig.camera->frames.push_back(rig.frame(1.0f));
  rig.cycle(nothing);
  CHECK(rig.c->readings.frame.has_value());  // the same picture of a scene at rest

  rig.enter(Task::Approach);
  rig.camera->frames.push_back(rig.frame(1.0f));
  rig.cycle(nothing);
  CHECK_FALSE(rig.c->readings.frame.has_value());
}

TEST_CASE("a camera without new frames is lost after 0.3 s, and back with the next", "[supervision]") {
  PhaseRig rig;
  rig.idle(0.25);
  CHECK_FALSE(rig.c->readings.camera_lost);
  rig.idle(0.1);
  CHECK(rig.c->readings.camera_lost);
  rig.camera->frames.push_back(rig.frame(1.0f));
  rig.idle(0.01);
  CHECK_FALSE(rig.c->readings.camera_lost);
  CHECK_THAT(rig.notes(), Catch::Contains("camera: is back"));
}

TEST_CASE("an unplugged camera is opened again every two seconds", "[supervision]") {
  PhaseRig rig;
  rig.camera->unplugged = true;
  rig.idle(1.9);
  CHECK(rig.c->readings.camera_lost);
  CHECK(rig.camera->opened == 0);
  rig.idle(4.3);
  CHECK(rig.camera->opened == 3);
}
