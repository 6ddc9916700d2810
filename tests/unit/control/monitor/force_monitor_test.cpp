// Unexpected force: by direction, by what the hand carries, and how soon.
#include "control/monitor/force_monitor.hpp"

#include <catch2/catch.hpp>

#include "../allocations.hpp"
#include "control/lift/load_estimator.hpp"
#include "hal/robot_model/robot_model.hpp"

using namespace colift;
using namespace colift::control;

namespace {

constexpr double kCycle_s = 0.005;

struct Felt {
  Felt() { state.q_rad << 0.0, 0.35, 0.0, 1.75, 0.0, -0.9, 0.0; }

  /// Somebody or something acts on the palm for some cycles; how many until it was found, -1: never.
  int apply(const hal::Vec3& force_W, const hal::Vec3& torque_W = hal::Vec3::Zero(), int cycles = 100) {
    Eigen::Matrix<double, 6, 1> wrench;
    wrench << force_W, torque_W;
    state.tau_external_nm =
        hal::jacobian(hal::built_in_robot(), state.q_rad, hal::Vec3::Zero()).transpose() * wrench;
    for (int i = 1; i <= cycles; ++i) {
      monitor.update(state, kCycle_s, false, false);
      if (monitor.finding()) return i;
    }
    return -1;
  }

  hal::ArmState state;
  ForceMonitor monitor{hal::built_in_robot(), ForceMonitorConfig{}};
};

}  // namespace

TEST_CASE("a push of 150 N on the hand is found within two cycles, in every state and direction",
          "[monitor]") {
  using Kind = ForceFinding::Kind;
  for (const HandLoad load : {HandLoad::Empty, HandLoad::Closing, HandLoad::Carried, HandLoad::Lowering}) {
    const std::pair<hal::Vec3, Kind> pushes[] = {{{150, 0, 0}, Kind::Sideways},
                                                 {{0, -150, 0}, Kind::Sideways},
                                                 {{0, 0, 150}, Kind::Up},
                                                 {{0, 0, -150}, Kind::Down}};
    for (const auto& [force, kind] : pushes) {
      Felt felt;
      CHECK(felt.apply(hal::Vec3::Zero()) == -1);
      felt.monitor.expect(load);
      INFO(static_cast<int>(load) << ": " << force.transpose());
      const int cycles = felt.apply(force);
      CHECK(cycles >= 1);
      CHECK(cycles <= 2);
      // what hangs down may break a joint's limit by more than the palm's
      const bool joint = kind == Kind::Down && felt.monitor.finding().kind == Kind::Joint;
      CHECK((joint || felt.monitor.finding().kind == kind));
      CHECK(felt.monitor.finding().load == load);
    }
  }
}

TEST_CASE("what a nominal lift feels is expected", "[monitor]") {
  Felt felt;
  (void)felt.apply(hal::Vec3::Zero());
  felt.monitor.expect(HandLoad::Closing);
  CHECK(felt.apply({12, 0, 12}, {3, 0, 0}) == -1);
  felt.monitor.expect(HandLoad::Carried);
  CHECK(felt.apply({20, 0, -48}, {0, 7, 0}) == -1);
  felt.monitor.expect(HandLoad::Lowering);
  CHECK(felt.apply({0, 33, 12}, {0, 4, 0}) == -1);
}

TEST_CASE("torque about the hand is found", "[monitor]") {
  Felt felt;
  (void)felt.apply(hal::Vec3::Zero());
  felt.monitor.expect(HandLoad::Carried);
  CHECK(felt.apply({0, 0, -20}, {0, 40, 0}) > 0);
  CHECK(felt.monitor.finding().kind == ForceFinding::Kind::Torque);
}

TEST_CASE("a finding stays until it is cleared, and is not found again while the force lasts", "[monitor]") {
  Felt felt;
  (void)felt.apply(hal::Vec3::Zero());
  felt.monitor.expect(HandLoad::Carried);
  REQUIRE(felt.apply({150, 0, 0}) > 0);
  (void)felt.apply(hal::Vec3::Zero());
  CHECK(felt.monitor.finding());
  CHECK(felt.monitor.quiet());
  REQUIRE(felt.apply({150, 0, 0}) > 0);
  felt.monitor.clear();
  CHECK(felt.apply({150, 0, 0}) == -1);
  CHECK_FALSE(felt.monitor.quiet());
  CHECK(felt.apply(hal::Vec3::Zero()) == -1);
  CHECK(felt.apply({150, 0, 0}) > 0);
}

TEST_CASE("the monitor does not allocate", "[monitor]") {
  Felt felt;
  felt.monitor.expect(HandLoad::Carried);
  const auto before = allocations();
  (void)felt.apply({150, 0, 0});
  CHECK(allocations() == before);
}
