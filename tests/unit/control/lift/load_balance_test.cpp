#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "control/lift/load_balance.hpp"
#include "hal/types/units.hpp"

using namespace colift;
using control::balance_load;
using control::CarriedSample;
using control::KnownBefore;
using control::LoadConfig;

namespace {

constexpr double kMass_kg = 4.0;

// a bar of 0.8 m along x: the partner at its left end, the robot at 0.7 m
KnownBefore bar(double cog_m = 0.4) {
  KnownBefore known;
  known.partner = {0.0, 0.0, 0.5};
  known.grasp = {0.7, 0.0, 0.5};
  known.cog = {cog_m, 0.02, 0.5};
  known.cog_covariance = 1e-6 * Eigen::Matrix3d::Identity();
  known.partner_covariance = 1e-6 * Eigen::Matrix3d::Identity();
  return known;
}

// what the robot feels of it: the palm 6 cm behind the point where the load hangs, the bar raised and tilted
CarriedSample sample(const hal::Vec3& true_cog, double tilt_rad = 0.0, double palm_x = 0.76) {
  CarriedSample s;
  s.X_WTnow_WTref = hal::Pose(Eigen::AngleAxisd(tilt_rad, hal::Vec3::UnitY()));
  s.X_WTnow_WTref.translation().z() = 0.05;
  const hal::Vec3 partner = s.X_WTnow_WTref * hal::Vec3(0.0, 0.0, 0.5);
  const hal::Vec3 cog = s.X_WTnow_WTref * true_cog;
  s.palm = s.X_WTnow_WTref * hal::Vec3(palm_x, 0.0, 0.5);
  const double weight = kMass_kg * hal::kGravity_m_s2;
  // the robot bears half of it, and the palm a torque for the rest of the balance
  const hal::Vec3 force(0.0, 0.0, 0.5 * weight);
  const hal::Vec3 about_partner =
      (s.palm - partner).cross(force) + (cog - partner).cross(hal::Vec3(0.0, 0.0, -weight));
  s.wrench = {-force, about_partner};
  return s;
}

}  // namespace

TEST_CASE("the mass follows from the moment about the partner's hand, wherever the palm is", "[load]") {
  for (const double palm_x : {0.70, 0.76, 0.82}) {
    const std::vector<CarriedSample> held(30, sample({0.4, 0.02, 0.5}, 0.02, palm_x));
    const auto load = balance_load(held, bar(), LoadConfig{});
    REQUIRE(load);
    CHECK(load->mass_kg == Approx(kMass_kg).epsilon(1e-6));
    CHECK(load->share_robot == Approx(0.5).epsilon(1e-6));
    CHECK(load->source == control::MassSource::Shape);
    CHECK(load->mass_95.low < kMass_kg);
    CHECK(load->mass_95.high > kMass_kg);
  }
}

TEST_CASE("density that is not uniform goes into the mass, and the interval is as wide as that", "[load]") {
  const std::vector<CarriedSample> held(10, sample({0.43, 0.02, 0.5}));
  KnownBefore vague = bar(0.4);
  vague.cog_covariance(0, 0) = 0.016 * 0.016;
  const auto load = balance_load(held, vague, LoadConfig{});
  REQUIRE(load);
  CHECK(load->mass_kg == Approx(kMass_kg * 0.43 / 0.40).epsilon(1e-6));
  CHECK(load->cog_sigma_m == Approx(0.016).epsilon(0.01));
  CHECK(load->mass_95.low < kMass_kg);
  const auto sure = balance_load(held, bar(0.4), LoadConfig{});
  REQUIRE(sure);
  CHECK(sure->mass_95.low > kMass_kg);
}

TEST_CASE("who is told the mass measures share and centre of gravity", "[load]") {
  const std::vector<CarriedSample> held(10, sample({0.46, 0.02, 0.5}));
  KnownBefore told = bar(0.4);
  told.mass_kg = kMass_kg;
  const auto load = balance_load(held, told, LoadConfig{});
  REQUIRE(load);
  CHECK(load->source == control::MassSource::Told);
  CHECK(load->share_robot == Approx(0.5).epsilon(1e-6));
  CHECK(load->cog.x() == Approx(0.46).epsilon(1e-6));
  CHECK(load->share_95.low < 0.5);
  CHECK(load->share_95.high - load->share_95.low < 0.06);
}

TEST_CASE("what is not observable is not known", "[load]") {
  const std::vector<CarriedSample> held(10, sample({0.05, 0.0, 0.5}));
  CHECK(balance_load(held, bar(0.002), LoadConfig{}).error().code == hal::ErrorCode::NotFound);
  KnownBefore vague = bar();
  vague.cog_covariance = 0.04 * Eigen::Matrix3d::Identity();
  CHECK(balance_load(held, vague, LoadConfig{}).error().code == hal::ErrorCode::NotFound);
  // pressed down instead of borne
  CarriedSample pushed = sample({0.4, 0.02, 0.5});
  pushed.wrench.force *= -1.0;
  pushed.wrench.torque *= -1.0;
  CHECK(balance_load(std::vector{pushed}, bar(), LoadConfig{}).error().code == hal::ErrorCode::NotFound);
}

TEST_CASE("more than the whole weight is no share: the scene's centre of gravity is wrong", "[load]") {
  const std::vector<CarriedSample> held(30, sample({0.4, 0.02, 0.5}));
  const auto load = balance_load(held, bar(0.9), LoadConfig{});
  REQUIRE_FALSE(load);
  CHECK_THAT(load.error().detail, Catch::Contains("the centre of gravity is not where the scene shows it"));
  KnownBefore told = bar(0.9);
  told.mass_kg = kMass_kg;
  CHECK(balance_load(held, told, LoadConfig{}));
}

TEST_CASE("bad samples are refused", "[load]") {
  CHECK(balance_load({}, bar(), LoadConfig{}).error().code == hal::ErrorCode::BadInput);
  CarriedSample broken = sample({0.4, 0.02, 0.5});
  broken.wrench.torque.y() = std::numeric_limits<double>::quiet_NaN();
  CHECK(balance_load(std::vector{broken}, bar(), LoadConfig{}).error().code == hal::ErrorCode::BadInput);
  KnownBefore same = bar();
  same.grasp = same.partner;
  CHECK(balance_load(std::vector{sample({0.4, 0.02, 0.5})}, same, LoadConfig{}).error().code ==
        hal::ErrorCode::BadInput);
}
