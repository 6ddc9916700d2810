// The driver against the emulated controller, which judges it in code of its own: whole sessions by every KRL
// program and control strategy, and faults of the wire and of the controller at a random moment.
#include <cmath>

#include "emulated_arm.hpp"
#include "tests/support/thorough.hpp"

namespace colift {
namespace {

using hal::JointVector;
using sim_hal::KrcFault;

using test::Emulated;

/// Moves A2 and A4 smoothly, for ever, as a good user: anew from the measured pose after each interruption.
struct User {
  JointVector q = JointVector::Zero();
  double s = 0.0, lag = 0.0;
  bool running = false;
  int moved = 0, refused = 0;

  void cycle(hal::Arm& arm) {
    const auto state = arm.wait_cycle();
    if (!state) {
      if (state.error().code != hal::ErrorCode::Timeout) running = false;
      return;
    }
    if (!state->may_command) {
      running = false;
      return;
    }
    if (!running) {
      running = true;
      s = 0.0;
      q = state->q_rad;
    } else {
      s += 0.002;
      const double v = 0.25 * std::min(1.0, s / 0.2);
      q[1] += v * std::sin(2.0 * s) * 0.002;
      q[3] += v * std::sin(3.0 * s) * 0.002;
    }
    hal::ImpedanceCommand c;
    c.q_rad = q;
    ++moved;
    refused += !arm.command(c);
    lag = std::max(lag, (state->q_rad - q).cwiseAbs().maxCoeff());
  }
};

}  // namespace

TEST_CASE("a whole session by every KRL program breaks no rule of the controller", "[fri][emulated]") {
  const std::string script = GENERATE("colift", "stanford", "tum", "cep", "openkc", "vendor");
  sim_hal::KrcConfig krc;
  krc.program.runs_s = 4.0;
  if (script == "vendor") krc.program.strategy = sim_hal::FriControl::JointImpedance;
  Emulated e(script, {}, krc);
  INFO(script);
  REQUIRE(e.arm->configure());
  const auto active = e.arm->activate();
  INFO((active ? "" : active.error().text()));
  INFO(e.told);
  REQUIRE(active);
  User user;
  for (int i = 0; i < 1500; ++i) user.cycle(*e.arm);
  CHECK(user.moved == 1500);
  CHECK(user.refused == 0);
  CHECK(user.lag < 0.02);
  e.arm->deactivate();
  CHECK(e.broken() == "");
  CHECK(e.krc->report().state != sim_hal::FriState::Command);
  CHECK(e.krc->report().missed <= 1);
  CHECK(e.krc->report().late == 0);
  CHECK(e.krc->report().duplicate == 0);
  if (script == "vendor") return;  // its program ends with the session
  // and once more
  const auto again = e.arm->activate();
  INFO((again ? "" : again.error().text()));
  REQUIRE(again);
  user.running = false;
  for (int i = 0; i < 300; ++i) user.cycle(*e.arm);
  CHECK(user.moved == 1800);
  e.arm->deactivate();
  CHECK(e.broken() == "");
}

TEST_CASE("position and Cartesian impedance control by the controller's own judgement", "[fri][emulated]") {
  const std::string script = GENERATE("colift", "stanford", "cep", "openkc");
  const std::string control = GENERATE("position", "cartesian_impedance");
  hal::FriConfig config;
  config.control = control;
  Emulated e(script, config, {}, false);
  INFO(script << " " << control);
  REQUIRE(e.arm->configure());
  const auto active = e.arm->activate();
  INFO((active ? "" : active.error().text()));
  INFO(e.told);
  REQUIRE(active);
  auto state = e.arm->wait_cycle();
  REQUIRE(state);
  if (control == "position") {
    JointVector q = state->q_rad;
    for (int i = 0; i < 1000; ++i) {
      REQUIRE(e.fri->command_position(q));
      q[1] += 2e-4 * std::sin(0.01 * i);
      REQUIRE(e.arm->wait_cycle());
    }
  } else {
    hal::CartesianCommand c;
    c.X = hal::from_wire_frame(e.fri->measurement().cart_measured);
    c.stiffness << 1000, 1000, 1000, 100, 100, 100;
    const double before = c.X.translation().z();
    for (int i = 0; i < 1000; ++i) {
      REQUIRE(e.fri->command_cartesian(c));
      c.X.translation().z() += 1e-4 * std::sin(0.00314159 * i);
      REQUIRE(e.arm->wait_cycle());
    }
    const double way = hal::from_wire_frame(e.fri->measurement().cart_measured).translation().z() - before;
    CHECK(way == Approx(0.0637).margin(0.01));
  }
  e.arm->deactivate();
  CHECK(e.broken() == "");
}

TEST_CASE("faults of wire and controller at a random moment: no rule broken, no step, a way back",
          "[fri][emulated]") {
  const int seed = GENERATE(range(1, 1 + colift::tests::repetitions(60, 10)));
  const auto pick = static_cast<std::uint64_t>(seed);
  sim_hal::KrcConfig config;
  config.restart_s = 0.5;
  config.seed = pick;
  using Kind = KrcFault::Kind;
  const std::vector<std::function<void(KrcFault&)>> kinds = {
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Loss;
        f.value = 1;
        f.percent = true;
      },
      [](KrcFault& f) {
        f.for_s = 0.5;
        f.kind = Kind::Loss;
        f.value = 10;
        f.percent = true;
      },
      [](KrcFault& f) {
        f.for_s = 0.1;
        f.kind = Kind::Loss;
        f.way = KrcFault::Direction::ToClient;
        f.value = 3;
        f.counted = true;
      },
      [](KrcFault& f) {
        f.for_s = 0.1;
        f.kind = Kind::Loss;
        f.way = KrcFault::Direction::ToClient;
        f.value = 10;
        f.counted = true;
      },
      [](KrcFault& f) {
        f.for_s = 0.1;
        f.kind = Kind::Loss;
        f.way = KrcFault::Direction::ToKrc;
        f.value = 3;
        f.counted = true;
      },
      [](KrcFault& f) {
        f.for_s = 0.1;
        f.kind = Kind::Loss;
        f.value = 20;
        f.counted = true;
      },
      [](KrcFault& f) {
        f.for_s = 0.4;
        f.kind = Kind::Delay;
        f.value = 1;
      },
      [](KrcFault& f) {
        f.for_s = 0.4;
        f.kind = Kind::Delay;
        f.value = 5;
      },
      [](KrcFault& f) {
        f.for_s = 0.4;
        f.kind = Kind::Reorder;
      },
      [](KrcFault& f) {
        f.for_s = 0.4;
        f.kind = Kind::Duplicate;
      },
      [](KrcFault& f) {
        f.for_s = 0.4;
        f.kind = Kind::Corrupt;
        f.way = KrcFault::Direction::ToClient;
      },
      [](KrcFault& f) {
        f.for_s = 0.4;
        f.kind = Kind::Burst;
        f.way = KrcFault::Direction::ToClient;
        f.value = 25;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Quality;
        f.value = 1;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Quality;
        f.value = 0;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Monitor;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::EmergencyStop;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::DriveError;
        f.joint = 2;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::DriveWarning;
        f.joint = 2;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::DrivesOff;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Temperature;
        f.value = 90;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Freeze;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Jump;
        f.value = 0.4;
        f.joint = 3;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::NotANumber;
        f.joint = 3;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Contact;
        f.value = 20;
      },
      [](KrcFault& f) {
        f.for_s = 0.3;
        f.kind = Kind::Unplug;
      },
  };
  KrcFault fault;
  kinds[pick % kinds.size()](fault);
  fault.at_s = 1.5 + 0.0137 * static_cast<double>(pick * 7 % 100);
  config.faults = {fault};
  Emulated e("colift", {}, config);
  REQUIRE(e.arm->configure());
  REQUIRE(e.arm->activate());
  User user;
  for (int i = 0; i < 2500; ++i) user.cycle(*e.arm);
  INFO("seed " << seed << "\n" << e.told << e.arm->health().last_error);
  // a datagram with NaN in it is none: the controller gets no answer, as for any other that was lost
  const auto judged = [&] {
    const std::string text = e.broken();
    return fault.kind == Kind::NotANumber && text.find("missed-answers") < 20 &&
                   text.find('\n') == text.size() - 1
               ? ""
               : text;
  };
  CHECK(judged() == "");
  // a person confirms, as often as it takes
  bool back = false;
  for (int i = 0; i < 5 && !back; ++i) {
    e.arm->stop();
    back = e.arm->activate().has_value();
  }
  CHECK(back);
  user.running = false;
  const int before = user.moved;
  for (int i = 0; i < 200; ++i) user.cycle(*e.arm);
  CHECK(user.moved == before + 200);
  e.arm->deactivate();
  CHECK(judged() == "");
}

}  // namespace colift
