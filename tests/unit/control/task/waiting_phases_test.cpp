// Observe and AwaitPartner: what is waited for, and for how long.
#include <catch2/catch.hpp>

#include "control/task/phases/partner_phase.hpp"
#include "control/task/phases/scene_phase.hpp"
#include "phase_rig.hpp"

using namespace colift;
using namespace colift::control;
using namespace colift::control::test;

namespace {

struct Waiting : PhaseRig {
  PartnerMonitor partner{*c};
  GraspSelector grasps{*c};
  PartnerRequests requests{*c};
  ScenePhase scene{*c, grasps};
  PartnerPhase waiting{*c, partner, requests, grasps};
};

}  // namespace

TEST_CASE("a camera that shows nothing ends the observation at its timeout", "[phases]") {
  Waiting rig;
  rig.enter(Task::Observe);
  const auto event = rig.run([&] { return rig.scene.observe(); });
  REQUIRE(event);
  CHECK(event->event == Event::TimeOut);
  CHECK(rig.c->in_state_s() == Approx(30.0).margin(0.02));
  CHECK(rig.c->doing == "0 of 15 frames of the scene");
}

TEST_CASE("a partner is waited for, a second time not as long", "[phases]") {
  Waiting rig;
  rig.c->attempts.failed = rig.c->attempts.regrasp = true;
  double wanted_s = 30.0;
  SECTION("first") {}
  SECTION("again") {
    rig.c->attempts.approaches = 1;
    wanted_s = 10.0;
  }
  rig.enter(Task::AwaitPartner);
  rig.waiting.begin(Task::BackOff);
  CHECK_FALSE(rig.c->attempts.failed);
  CHECK_FALSE(rig.c->attempts.regrasp);
  const auto event = rig.run([&] { return rig.waiting.await_partner(); });
  REQUIRE(event);
  CHECK(event->event == Event::NobodyCame);
  CHECK(rig.c->in_state_s() == Approx(wanted_s).margin(0.02));
}

TEST_CASE("nobody is asked to grasp elsewhere before there is a decision", "[phases]") {
  Waiting rig;
  CHECK_FALSE(rig.requests.ask({}));
  CHECK_FALSE(rig.requests.pending());
}

TEST_CASE("without a partner's grasp no grasp is chosen", "[phases]") {
  Waiting rig;
  rig.grasps.begin_decision();
  CHECK_FALSE(rig.grasps.choose());
}
