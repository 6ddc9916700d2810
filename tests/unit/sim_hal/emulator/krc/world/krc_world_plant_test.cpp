#include "sim_hal/emulator/mujoco/krc_world_plant.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "../fri_peer.hpp"

using namespace colift;
using namespace colift::sim_hal;
using std::chrono::milliseconds;

namespace {

const hal::ArmDynamics& dynamics() {
  static const hal::ArmDynamics arm(hal::built_in_robot(), hal::ArmDynamics::Load::Hand);
  return arm;
}

struct Rig {
  std::unique_ptr<SimWorld> world;
  std::unique_ptr<KrcWorldPlant> plant;
  explicit Rig(int cycle_ms = 2) {
    SimConfig config;
    config.arm_period = milliseconds(cycle_ms);
    world = SimWorld::make(built_in_scenario(), hal::built_in_robot(), 1, config).value();
    plant = std::make_unique<KrcWorldPlant>(*world, dynamics());
    REQUIRE(plant->set_cycle(milliseconds(cycle_ms)));
  }
  void run(const KrcSetPoint& s, int ms) {
    for (int i = 0; i < ms; i += 2) {
      plant->command(s);
      plant->advance(milliseconds(2));
    }
  }
};

}  // namespace

TEST_CASE("the world under brakes stands still, and gravity is what the sensors feel", "[krc][mujoco]") {
  Rig rig;
  KrcSetPoint s;
  s.q_rad = hal::JointVector::Constant(0.7);  // brakes do not care
  rig.run(s, 500);
  const KrcPlantState arm = rig.plant->state();
  CHECK((arm.q_rad - SimConfig::home_rad()).norm() < 1e-3);
  CHECK((arm.tau_nm - dynamics().gravity_nm(arm.q_rad)).norm() < 0.1);
  CHECK(arm.tau_external_nm.norm() < 0.05);
}

TEST_CASE("the world's arm follows in every strategy", "[krc][mujoco]") {
  for (const FriControl control :
       {FriControl::Position, FriControl::JointImpedance, FriControl::CartesianImpedance}) {
    CAPTURE(static_cast<int>(control));
    Rig rig;
    rig.plant->set_brakes(false);
    KrcSetPoint s;
    s.control = control;
    s.q_rad = SimConfig::home_rad();
    s.cart_stiffness << 2000, 2000, 2000, 200, 200, 200;
    s.cart_damping_ratio.setConstant(0.7);
    const hal::Pose X0 = dynamics().flange(s.q_rad);
    s.X_WT = X0;
    rig.run(s, 200);
    CHECK((rig.plant->state().q_rad - SimConfig::home_rad()).norm() < 3e-3);
    for (int i = 0; i < 500; ++i) {
      s.q_rad[0] += 0.0004;
      s.X_WT.translation().y() += 0.0002;
      rig.run(s, 2);
    }
    rig.run(s, 2000);  // a posture leans slowly
    const KrcPlantState arm = rig.plant->state();
    if (control == FriControl::CartesianImpedance)
      CHECK((dynamics().flange(arm.q_rad).translation() - s.X_WT.translation()).norm() < 2e-3);
    else
      CHECK((arm.q_rad - s.q_rad).norm() < 3e-3);
    CHECK(arm.dq_rad_s.norm() < 0.01);
    CHECK(rig.world->truth().divergences == 0);
  }
}

TEST_CASE("a push on the world's arm bends its springs and shows as external torque", "[krc][mujoco]") {
  Rig rig;
  rig.plant->set_brakes(false);
  KrcSetPoint s;
  s.q_rad = SimConfig::home_rad();
  Vector6 push = Vector6::Zero();
  push[2] = -20.0;
  rig.plant->set_push(push);
  rig.run(s, 2000);
  const KrcPlantState arm = rig.plant->state();
  const hal::JointVector outside = dynamics().jacobian(arm.q_rad).transpose() * push;
  CHECK((arm.tau_external_nm - outside).norm() < 0.3);
  CHECK((arm.tau_nm - dynamics().gravity_nm(arm.q_rad) + outside).norm() < 0.3);
  CHECK((1000.0 * (arm.q_rad - s.q_rad) - outside).norm() < 0.05 * outside.norm());
}

TEST_CASE("a world with another cycle is no plant for this one", "[krc][mujoco]") {
  Rig rig;
  const auto done = rig.plant->set_cycle(milliseconds(5));
  REQUIRE_FALSE(done);
  CHECK(done.error().code == hal::ErrorCode::BadConfig);
  CHECK(done.error().detail.find("2 ms") != std::string::npos);
}

TEST_CASE("over the wire the world's arm moves as it is told", "[krc][mujoco]") {
  hal::ManualClock clock;
  MemoryWire wire(clock);
  Rig rig;
  const hal::Endpoint krc_at{0x7F000001, 50000}, client_at{0x7F000001, 49938};
  const auto krc_end = wire.end(krc_at);
  KrcConfig config;
  config.script = "stanford";
  KrcEmulator krc(config, dynamics(), *rig.plant, *krc_end);
  const auto client = wire.end(client_at, lock_step(krc, clock));
  REQUIRE(krc_end->open());
  REQUIRE(client->open());
  REQUIRE(krc.start(clock.now()));

  std::uint16_t send = 0;
  double moved = 0.0;
  test::Seen m;
  for (int i = 0; i < 1500; ++i) {
    std::array<std::byte, 916> buffer;
    REQUIRE(client->receive(buffer, milliseconds(10)).size == 916);
    m.bytes.assign(buffer.begin(), buffer.end());
    if (m.state() == 2) moved = std::min(moved + 0.0005, 0.3);
    std::vector<std::byte> c(376);
    test::set<std::uint16_t>(c, 0, ++send);
    test::set<std::uint16_t>(c, 2, m.send());
    test::set<std::uint16_t>(c, 4, 376);
    test::set<std::uint16_t>(c, 6, 0x1005);
    test::set<std::int32_t>(c, 72 + 4 * 14, 30);
    test::set<std::int32_t>(c, 72 + 4 * 15, 10);
    test::set<std::uint32_t>(c, 140, 0x35);
    for (std::size_t j = 0; j < 7; ++j) {
      const double q = m.state() == 2 ? m.joints(292)[static_cast<int>(j)] + (j == 0 ? moved : 0.0)
                                      : m.q_total()[static_cast<int>(j)];
      test::set<float>(c, 144 + 4 * j, static_cast<float>(q));
      test::set<float>(c, 272 + 4 * j, 1000.0f);
      test::set<float>(c, 300 + 4 * j, 0.7f);
    }
    client->send(krc_at, c);
    krc.poll(clock.now());
  }
  CHECK(m.state() == 2);
  CHECK(m.q()[0] == Approx(0.3).margin(0.003));
  CHECK(krc.report().broken_rules.empty());
  // the world lives in the controller's time
  CHECK(rig.world->clock().now() - clock.now() <= milliseconds(2));
}
