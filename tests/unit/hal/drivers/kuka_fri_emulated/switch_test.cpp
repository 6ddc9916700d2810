// Another control strategy at run time, and what goes wrong on the way to it: the emulated controller judges.
#include "emulated_arm.hpp"
#include "tests/support/thorough.hpp"

namespace colift {
namespace {

using hal::FriControl;
using hal::JointVector;
using sim_hal::KrcFault;
using test::Emulated;

/// Holds the measured pose in whatever is active, for so many cycles; how far a joint went.
double hold(Emulated& e, int cycles) {
  JointVector q;
  hal::CartesianCommand frame;
  double moved = 0.0;
  for (int i = 0; i < cycles; ++i) {
    const auto state = e.fri->wait_cycle();
    REQUIRE(state);
    REQUIRE(state->may_command);
    if (i == 0) {
      q = state->q_rad;
      frame.X = hal::from_wire_frame(e.fri->measurement().cart_measured);
    }
    moved = std::max(moved, (state->q_rad - q).cwiseAbs().maxCoeff());
    hal::ImpedanceCommand c;
    c.q_rad = q;
    const auto sent = e.fri->control() == FriControl::JointImpedance ? e.fri->command(c)
                      : e.fri->control() == FriControl::Position     ? e.fri->command_position(q)
                                                                     : e.fri->command_cartesian(frame);
    INFO((sent ? "" : sent.error().text()));
    REQUIRE(sent);
  }
  return moved;
}

hal::Result<> switch_to(Emulated& e, const std::string& control) {
  e.fri->deactivate();
  if (auto set = e.fri->set_control(control); !set) return set;
  return e.fri->activate();
}

void inject(Emulated& e, const std::string& kind, double in_s, const std::string& for_s) {
  const double at_s = hal::seconds(e.clock.now()) + in_s;
  e.krc->inject(sim_hal::parse_krc_fault(std::to_string(at_s) + ":" + kind + ":" + for_s).value());
}

JointVector measured(const Emulated& e) {
  return e.plant->state().q_rad;
}

}  // namespace

TEST_CASE("strategies follow one another on one link, by every program that takes them", "[fri][emulated]") {
  const std::string script = GENERATE("colift", "stanford", "cep", "openkc");
  Emulated e(script, {}, {}, false);
  INFO(script);
  REQUIRE(e.fri->configure());
  REQUIRE(e.fri->activate());
  CHECK(hold(e, 300) < 1e-3);
  for (const auto& [control, mode] : std::vector<std::pair<std::string, FriControl>>{
           {"position", FriControl::Position},
           {"cartesian_impedance", FriControl::CartesianImpedance},
           {"joint_impedance", FriControl::JointImpedance},
           {"cartesian_impedance", FriControl::CartesianImpedance},
           {"position", FriControl::Position}}) {
    const JointVector before = measured(e);
    const auto done = switch_to(e, control);
    INFO(control << " " << (done ? "" : done.error().text()) << "\n" << e.told);
    REQUIRE(done);
    CHECK(e.fri->measurement().control == mode);
    CHECK(hold(e, 300) < 2e-3);
    CHECK((measured(e) - before).cwiseAbs().maxCoeff() < 5e-3);
    CHECK(e.broken() == "");
  }
  e.fri->deactivate();
  CHECK(e.broken() == "");
}

TEST_CASE("a strategy does not change in command mode, by no program of another kind, and to no other word",
          "[fri][emulated]") {
  Emulated e("colift", {}, {}, false);
  CHECK(e.fri->set_control("position").error().code == hal::ErrorCode::NotReady);  // not open
  REQUIRE(e.fri->configure());
  CHECK(e.fri->set_control("gravity").error().code == hal::ErrorCode::BadInput);
  REQUIRE(e.fri->activate());
  const auto commanding = e.fri->set_control("position");
  REQUIRE_FALSE(commanding);
  CHECK(commanding.error().detail.find("in command mode") != std::string::npos);
  CHECK(e.fri->set_control("joint_impedance"));  // as it is
  CHECK(hold(e, 100) < 1e-3);
  e.fri->deactivate();

  Emulated tum("tum", {}, {}, false);
  REQUIRE(tum.fri->configure());
  const auto own = tum.fri->set_control("position");
  REQUIRE_FALSE(own);
  CHECK(own.error().detail.find("keeps a strategy of its own") != std::string::npos);
  REQUIRE(tum.fri->activate());
  CHECK(hold(tum, 100) < 1e-3);
}

TEST_CASE(
    "a KRC that stays in monitor mode: refused with a reason, at rest, and the old strategy still comes",
    "[fri][emulated]") {
  const std::string script = GENERATE("colift", "stanford", "cep", "openkc");
  hal::FriConfig config;
  config.ready_s = 12.0;
  Emulated e(script, config, {}, false);
  INFO(script);
  REQUIRE(e.fri->configure());
  REQUIRE(e.fri->activate());
  hold(e, 100);
  e.fri->deactivate();
  const JointVector before = measured(e);
  REQUIRE(e.fri->set_control("position"));
  inject(e, "quality=bad", 0.0, "15");
  const auto refused = e.fri->activate();
  REQUIRE_FALSE(refused);
  INFO(refused.error().text());
  CHECK(refused.error().detail.find("quality") != std::string::npos);
  CHECK(e.krc->report().state == sim_hal::FriState::Monitor);
  CHECK((measured(e) - before).cwiseAbs().maxCoeff() < 1e-3);
  const hal::Timestamp well = e.clock.now() + std::chrono::seconds(16);
  while (e.clock.now() < well) (void)e.fri->wait_cycle();
  const auto back = switch_to(e, "joint_impedance");
  INFO((back ? "" : back.error().text()) << "\n" << e.told);
  CHECK(back);
  hold(e, 100);
  CHECK(e.broken() == "");
}

TEST_CASE("the quality drops, or drives go, at any moment of a switch: no motion, no broken rule, a way back",
          "[fri][emulated]") {
  const std::string script = GENERATE("colift", "stanford", "cep", "openkc");
  const std::string kind = GENERATE("quality=unacceptable", "emergency-stop", "monitor", "loss.out=30");
  const double moment_s = GENERATE(0.05, 0.4, 0.9, 1.5, 2.4);
  if (colift::tests::kSanitized && moment_s != 0.9) return;
  hal::FriConfig config;
  config.ready_s = 8.0;
  sim_hal::KrcConfig krc;
  krc.restart_s = 0.5;
  Emulated e(script, config, krc, false);
  INFO(script << " " << kind << " " << moment_s);
  REQUIRE(e.fri->configure());
  REQUIRE(e.fri->activate());
  hold(e, 100);
  const JointVector before = measured(e);
  inject(e, kind, moment_s, "0.3");
  const auto done = switch_to(e, "position");
  if (!done) CHECK(done.error().detail.size() > 20);
  CHECK((measured(e) - before).cwiseAbs().maxCoeff() < 0.02);
  bool back = false;
  std::string why;
  for (int i = 0; i < 6 && !back; ++i) {
    // an operator acknowledges, and the program is off the wire for a moment
    for (const auto until = e.clock.now() + std::chrono::seconds(1); e.clock.now() < until;)
      (void)e.fri->wait_cycle();
    const auto again = switch_to(e, "joint_impedance");
    back = again.has_value();
    if (!back) why += again.error().text() + "\n";
  }
  INFO(e.told << why);
  REQUIRE(back);
  hold(e, 100);
  CHECK((measured(e) - before).cwiseAbs().maxCoeff() < 0.02);
  CHECK(e.broken() == "");
}

TEST_CASE("no answer of the program during a switch is named as that", "[fri][emulated]") {
  hal::FriConfig config;
  config.ready_s = 6.0;
  Emulated e("tum", config, {}, false);  // another program than the one that is expected
  config.script = GENERATE("colift", "stanford", "openkc");
  hal::FriArm other(config, e.wire.end(test::kPc, sim_hal::lock_step(*e.krc, e.clock)), e.clock);
  REQUIRE(other.configure());
  REQUIRE(other.set_control("position"));
  const auto refused = other.activate();
  REQUIRE_FALSE(refused);
  INFO(config.script << ": " << refused.error().text());
  CHECK(refused.error().detail.find("does not answer within") != std::string::npos);
  CHECK(e.krc->report().state == sim_hal::FriState::Monitor);
}

}  // namespace colift
