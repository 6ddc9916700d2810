// What hangs on the flange beyond the controller's load data: exact without noise, within its own standard
// deviation with noise, and "not observable" where poses are too much alike.
#include "hal/robot_model/load_estimate.hpp"

#include <catch2/catch.hpp>
#include <random>
#include <vector>

using namespace colift::hal;

namespace {

const ArmDynamics& arm() {
  static const ArmDynamics dynamics(built_in_robot(), ArmDynamics::Load::Hand);
  return dynamics;
}

JointVector bent() {
  JointVector q;
  q << 0.1, 0.7, -0.2, 1.4, 0.1, -0.9, 0.3;
  return q;
}

/// Ten poses about bent(), by `turn_rad` in A4 to A7, with a point mass at `p` on the flange.
std::vector<LoadSample> poses(double turn_rad, double mass_kg, const Vec3& p, double noise_nm = 0.0,
                              unsigned seed = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<LoadSample> all;
  for (int i = 0; i < 10; ++i) {
    LoadSample s;
    s.q_rad = bent();
    for (int j = 3; j < 7; ++j) s.q_rad[j] += turn_rad * (((i + 1) >> (j - 3) & 1) != 0 ? 1.0 : -1.0);
    s.tau_external_nm = -9.81 * mass_kg * arm().jacobian(s.q_rad, p).row(2).transpose();
    for (int j = 0; j < 7; ++j) s.tau_external_nm[j] += noise_nm * normal(random);
    all.push_back(s);
  }
  return all;
}

}  // namespace

TEST_CASE("without noise mass and moment come out exactly", "[load]") {
  for (const double mass : {0.2, 1.5, -0.4}) {
    const Vec3 p(0.03, -0.02, 0.12);
    const auto e = estimate_load_error(arm(), poses(0.3, mass, p));
    REQUIRE(e);
    CHECK(e->more.mass_kg == Approx(mass).epsilon(1e-9));
    CHECK((e->more.moment_kgm - mass * p).norm() < 1e-9);
    CHECK(e->residual_nm < 1e-9);
    CHECK(e->wrong());
    CHECK_FALSE(e->unexplained());
  }
}

TEST_CASE("with noise the error keeps to its standard deviation", "[load]") {
  int beyond = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    const auto e = estimate_load_error(arm(), poses(0.3, 0.2, {0, 0, 0.05}, 0.2, seed));
    REQUIRE(e);
    beyond += std::abs(e->more.mass_kg - 0.2) > 2.0 * e->sigma.mass_kg ? 1 : 0;
  }
  CHECK(beyond < 20);  // 5 % are expected
  CHECK(beyond > 1);
}

TEST_CASE("a load that is as the controller knows it is not called wrong", "[load]") {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    const auto e = estimate_load_error(arm(), poses(0.3, 0.0, Vec3::Zero(), 0.1, seed));
    REQUIRE(e);
    CHECK_FALSE(e->wrong());
  }
}

TEST_CASE("poses too much alike are not observable", "[load]") {
  for (const double turn : {0.0, 0.002}) {
    const auto e = estimate_load_error(arm(), poses(turn, 0.2, Vec3::Zero()));
    REQUIRE_FALSE(e);
    CHECK(e.error().code == ErrorCode::NotReady);
    CHECK(e.error().text().find("not observable") != std::string::npos);
  }
  CHECK_FALSE(estimate_load_error(arm(), {}));
}

TEST_CASE("an offset of one sensor is no load", "[load]") {
  auto samples = poses(0.3, 0.0, Vec3::Zero());
  for (auto& s : samples) s.tau_external_nm[2] += 5.0;
  const auto e = estimate_load_error(arm(), samples);
  REQUIRE(e);
  CHECK(e->unexplained());
  CHECK(e->residual_joint == 2);
  CHECK(describe(*e, hand_load(built_in_robot())).find("at A3") != std::string::npos);
}

TEST_CASE("the model's hand is what the load data should have", "[load]") {
  const FlangeLoad hand = hand_load(built_in_robot());
  // the difference that the hand makes to gravity is what this load makes
  const ArmDynamics bare(built_in_robot(), ArmDynamics::Load::Bare);
  std::vector<LoadSample> all = poses(0.3, 0.0, Vec3::Zero());
  for (auto& s : all) s.tau_external_nm = bare.gravity_nm(s.q_rad) - arm().gravity_nm(s.q_rad);
  const auto e = estimate_load_error(bare, all);
  REQUIRE(e);
  CHECK(hand.mass_kg == Approx(e->more.mass_kg).epsilon(1e-3));
  CHECK((hand.moment_kgm - e->more.moment_kgm).norm() < 1e-3);
}
