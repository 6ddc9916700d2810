// An arm on springs with something in its hand: it hangs below its commanded pose. A start from the measured
// pose must not make that the commanded one.

#include "fri_arm_rig.hpp"

namespace colift {

using namespace test;

namespace {

constexpr double kDegree = 0.0174533;

/// A load on A2 and A4, and how far the springs give way under it.
struct Loaded {
  FakeKrc krc;
  std::unique_ptr<hal::FriArm> arm;
  std::array<float, 7> before{};

  explicit Loaded(float a2_nm, float a4_nm) {
    krc.m.tau_external_nm[1] = a2_nm;
    krc.m.tau_external_nm[3] = a4_nm;
    hang(1000.0f);
    before = krc.followed();
    arm = krc.arm();
    REQUIRE(arm->configure());
  }
  void hang(float stiffness_nm_rad) {
    for (const std::size_t i : {1u, 3u})
      if (krc.m.tau_external_nm[i] != 0.0f) krc.sag_rad[i] = krc.m.tau_external_nm[i] / stiffness_nm_rad;
  }
  /// Holds where it is for a second, as every user begins.
  void start_and_hold(double stiffness_nm_rad = 1000.0) {
    REQUIRE(arm->activate());
    std::optional<JointVector> at;
    for (int i = 0; i < 500; ++i) {
      const auto state = next(*arm);
      if (!state.may_command) continue;
      if (!at) at = state.q_rad;
      hal::ImpedanceCommand c = hold_at(*at);
      c.stiffness_nm_rad.setConstant(stiffness_nm_rad);
      REQUIRE(arm->command(c));
      hang(static_cast<float>(stiffness_nm_rad));
    }
  }
  void stop() {
    arm->deactivate();
    krc.monitor_mode();
    hang(1000.0f);
    krc.start_when_good = true;
  }
  [[nodiscard]] double sunk_rad(std::size_t joint) const {
    return static_cast<double>(krc.followed()[joint] - before[joint]);
  }
};

}  // namespace

TEST_CASE("five starts under 15 N m do not let the arm sink", "[fri][faults]") {
  Loaded run(15.0f, -12.0f);
  for (int i = 0; i < 5; ++i) {
    run.start_and_hold();
    CHECK(std::abs(run.sunk_rad(1)) < 0.2 * kDegree);
    CHECK(std::abs(run.sunk_rad(3)) < 0.2 * kDegree);
    run.stop();
  }
  CHECK(run.krc.worst_dv_rad_s < 0.05);
}

TEST_CASE("nor does a quality that was bad for a while", "[fri][faults]") {
  Loaded run(15.0f, 0.0f);
  run.start_and_hold();
  for (int i = 0; i < 4; ++i) {
    run.krc.m.quality = hal::FriQuality::Unacceptable;
    bool held = false;
    for (int k = 0; k < 50; ++k) {
      const auto state = run.arm->wait_cycle();
      held = held || (state && !state->may_command);
    }
    REQUIRE(held);
    run.krc.m.quality = hal::FriQuality::Perfect;
    std::optional<JointVector> at;
    for (int k = 0; k < 300; ++k) {
      const auto state = run.arm->wait_cycle();
      if (!state || !state->may_command) continue;
      if (!at) at = state->q_rad;
      REQUIRE(run.arm->command(hold_at(*at)));
    }
  }
  CHECK(std::abs(run.sunk_rad(1)) < 0.2 * kDegree);
}

TEST_CASE("on stiffer springs the same load hangs higher", "[fri][faults]") {
  Loaded run(15.0f, 0.0f);
  run.start_and_hold(1500.0);
  // 15 mrad before; 10 mrad hold it now, so that the measured pose stays
  CHECK(run.sunk_rad(1) == Approx(15.0 / 1000.0 - 15.0 / 1500.0).margin(1e-3));
}

TEST_CASE("a load with the wrong sign is named before a start", "[fri][faults]") {
  const auto told = [](const char* sign, float load_nm) {
    FakeKrc krc;
    krc.m.tau_external_nm[1] = load_nm;
    krc.m.tau_external_nm[3] = -0.4f * load_nm;
    krc.sag_rad[1] = 0.015f;
    krc.sag_rad[3] = -0.006f;
    hal::FriConfig config = FakeKrc::quick();
    config.external_torque = sign;
    const auto arm = krc.arm(config);
    REQUIRE(arm->configure());
    for (int i = 0; i < 20; ++i) (void)next(*arm);
    CHECK(arm->status().torque_reversed == !describe_torque_sign(arm->status(), config).empty());
    if (arm->status().torque_reversed)
      CHECK(arm->health().last_error.find("wrong sign") != std::string::npos);
    return arm->status().torque_reversed;
  };
  CHECK(told("on_environment", 15.0f));
  CHECK(told("on_arm", -15.0f));
  CHECK_FALSE(told("on_arm", 15.0f));
  CHECK_FALSE(told("on_environment", -15.0f));
  CHECK_FALSE(told("on_environment", 1.0f));  // too little to say it
}

namespace {

/// An arm in Cartesian impedance whose tool hangs loaded; its Jacobian says that A2 moves the tool along x.
struct LoadedFrame {
  static constexpr float kLever_m = 0.8f, kTorque_nm = 16.0f, kForce_n = kTorque_nm / kLever_m;
  FakeKrc krc;
  std::unique_ptr<hal::FriArm> arm;

  explicit LoadedFrame(float sign_of_wrench, float sag_rad = 0.016f) {
    krc.m.control = hal::FriControl::CartesianImpedance;
    krc.m.cart_measured = hal::to_wire_frame(hal::Pose::Identity());
    krc.m.jacobian[1] = kLever_m;  // row X, column A2
    krc.m.tau_external_nm[1] = kTorque_nm;
    krc.m.wrench_external[0] = sign_of_wrench * kForce_n;
    krc.sag_rad[1] = sag_rad;
    hal::FriConfig config = FakeKrc::quick();
    config.control = "cartesian_impedance";
    arm = krc.arm(config);
    REQUIRE(arm->configure());
    REQUIRE(arm->activate());
  }
  /// Along x, as the last answer adds it, after a hold of a second.
  double added_n() {
    hal::FriSix first{};
    bool started = false;
    for (int i = 0; i < 500; ++i) {
      const auto state = next(*arm);
      if (!state.may_command) continue;
      hal::CartesianCommand c;
      c.X = hal::Pose::Identity();
      REQUIRE(arm->command_cartesian(c));
      if (!started) first = krc.heard.back().wrench;
      started = true;
    }
    REQUIRE(started);
    CHECK(first == hal::FriSix{});  // a controller refuses a start with a wrench
    return static_cast<double>(krc.heard.back().wrench[0]);
  }
};

}  // namespace

TEST_CASE("nor does it sink when Cartesian impedance begins: a wrench bears what hung there",
          "[fri][faults][modes]") {
  // whatever sign the controller gives its estimate: the sag says it
  CHECK(LoadedFrame(1.0f).added_n() == Approx(-LoadedFrame::kForce_n));
  CHECK(LoadedFrame(-1.0f).added_n() == Approx(-LoadedFrame::kForce_n));
  // neither without a sag, nor where the torque pulls to the other side
  CHECK(LoadedFrame(1.0f, 0.0f).added_n() == 0.0);
  CHECK(LoadedFrame(1.0f, -0.016f).added_n() == 0.0);
}

TEST_CASE("a difference that no load explains is walked down as before", "[fri][faults]") {
  Loaded run(0.0f, 0.0f);
  run.krc.sag_rad[1] = 0.02f;
  run.start_and_hold();
  CHECK(run.sunk_rad(1) == Approx(0.02).margin(2e-3));
  CHECK(run.krc.worst_dv_rad_s < 0.05);
}

}  // namespace colift
