#include "control/certificate/certificate.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "control/config/config.hpp"
#include "hal/types/units.hpp"

using namespace colift;
using namespace colift::control;
using hal::Vec3;
using Of = Certificate::Breach::Of;

namespace {

constexpr double kHigh_m = 0.5;

/// Hands at both ends of a board of 0.8 m along x; the centre of gravity beside its middle.
planner::UncertainScene board(const Vec3& cog_off = Vec3::Zero(), double cog_sigma_m = 0.0) {
  planner::UncertainScene s;
  s.cog = Vec3(0.0, 0.0, kHigh_m) + cog_off;
  s.cog_covariance = cog_sigma_m * cog_sigma_m * Eigen::Matrix3d::Identity();
  s.partner = Vec3(0.4, 0.0, kHigh_m);
  return s;
}

planner::GraspCandidate far_end() {
  planner::GraspCandidate c;
  c.position = Vec3(-0.4, 0.0, kHigh_m);
  c.approach = Vec3::UnitX();
  c.closing = Vec3::UnitZ();
  c.width = 0.03;
  return c;
}

LiftForecast forecast(const planner::UncertainScene& scene, std::optional<double> mass_kg,
                      double share = 0.5) {
  planner::DecisionConfig config;
  config.grip_torque_nm = 0.0;
  return forecast_lift(scene, far_end(), share, planner::HandModel{}, config, mass_kg);
}

CertificateConfig ordinary() {
  CertificateConfig c;
  c.share_below = c.share_above = c.load_below = c.load_above = 2.0;
  c.mass_sigma = 0.1;
  c.lead_m = 0.01;
  c.turning = 0.5;
  c.tilt_factor = 2.0;
  c.slip_base_m = 0.001;
  c.slip_factor = 3.0;
  return c;
}

std::vector<Of> broken(const Certificate& c) {
  std::vector<Of> out;
  for (const Certificate::Breach& b : c.breaches) out.push_back(b.of);
  return out;
}

}  // namespace

TEST_CASE("a lift without any doubt has a share without an interval and no torque about the hands",
          "[certificate]") {
  const LiftForecast f = forecast(board(), 4.0);
  CHECK(f.share_sigma == Approx(0.0).margin(1e-12));
  CHECK(f.turning_nm == Approx(0.0).margin(1e-12));
  CHECK(f.weight_n == Approx(4.0 * hal::kGravity_m_s2));
  const Certificate c = certify(f, ordinary(), {});
  CHECK(c.share.low == Approx(0.5));
  CHECK(c.share.high == Approx(0.5));
  CHECK(f.span_m == Approx((planner::load_point(far_end()) - board().partner).head<2>().norm()));
  CHECK(c.tilt_deg == Approx(2.0 * hal::rad_to_deg(std::atan(0.01 / f.span_m))));
  CHECK(c.breaches.empty());
}

TEST_CASE(
    "what is not known of the centre of gravity along the hands is doubt of the share, across them of the "
    "tilt",
    "[certificate]") {
  const double across_m = 0.03;
  planner::UncertainScene along = board();
  along.cog_covariance(0, 0) = 0.04 * 0.04;
  const LiftForecast a = forecast(along, 4.0);
  // the lever rule: 40 mm of the hands' distance, which ends where the load hangs in the hand
  const double span_m = (planner::load_point(far_end()) - along.partner).head<2>().norm();
  CHECK(a.share_sigma == Approx(0.04 / span_m).epsilon(1e-3));
  CHECK(a.turning_nm == Approx(0.0).margin(1e-9));
  const LiftForecast b = forecast(board(Vec3(0.0, across_m, 0.0), 0.0), 4.0);
  CHECK(b.turning_nm == Approx(4.0 * hal::kGravity_m_s2 * across_m));
  const LiftForecast both = forecast(board(Vec3(0.0, across_m, 0.0), across_m), 4.0);
  CHECK(both.turning_nm == Approx(std::sqrt(2.0) * b.turning_nm).epsilon(1e-3));
}

TEST_CASE("a load is not known where the mass is not, and that is said", "[certificate]") {
  const Certificate c = certify(forecast(board(), {}), ordinary(), {});
  CHECK_FALSE(c.load_n);
  CHECK_FALSE(c.partner_load_n);
  CHECK(c.text.find("load not known") != std::string::npos);
}

TEST_CASE("what the robot may bear less than expected, the partner may bear more", "[certificate]") {
  const double mass_kg = 6.0, weight_n = mass_kg * hal::kGravity_m_s2;
  CertificateConfig config = ordinary();
  config.mass_sigma = 0.0;
  const Certificate c = certify(forecast(board(Vec3::Zero(), 0.05), mass_kg), config, {});
  REQUIRE((c.load_n && c.partner_load_n));
  CHECK(c.load_n->low + c.partner_load_n->high == Approx(weight_n));
  CHECK(c.load_n->high + c.partner_load_n->low == Approx(weight_n));
  CHECK(c.load_n->low == Approx(weight_n * c.share.low));
}

TEST_CASE("a bound beyond its limit is a breach with its number", "[certificate]") {
  CertificateLimits limits;
  limits.max_tilt_deg = 1.0;
  limits.max_slip_m = 1e-4;
  limits.max_load_n = 10.0;
  limits.partner_load_n = 12.0;
  const Certificate c = certify(forecast(board(), 4.0), ordinary(), limits);
  CHECK(broken(c) == std::vector<Of>{Of::Tilt, Of::Slip, Of::Load, Of::PartnerLoad});
  CHECK(c.breach_text.find(" deg, 1.0 are allowed") != std::string::npos);
  CHECK(c.breach_text.find("12 are allowed") != std::string::npos);
  limits.partner_load_n.reset();
  CHECK(broken(certify(forecast(board(), 4.0), ordinary(), limits)).size() == 3);
}

TEST_CASE("a truth at its bound scores the factor that made the bound", "[certificate]") {
  const CertificateConfig config = ordinary();
  for (const double off_m : {0.0, 0.02, 0.1})
    for (const double mass_kg : {2.0, 8.0}) {
      const LiftForecast f = forecast(board(Vec3(0.0, off_m, 0.0), 0.03), mass_kg, 0.45);
      const Certificate c = certify(f, config, {});
      const CertificateScore s =
          certificate_score(f, c.share.high, c.load_n->low, c.tilt_deg, c.slip_m, config, {});
      CHECK(s.share == Approx(config.share_above));
      CHECK(s.load == Approx(-config.load_below));
      CHECK(s.tilt == Approx(config.tilt_factor));
      CHECK(s.slip == Approx(config.slip_factor));
    }
}

TEST_CASE("the limits are those of the task", "[certificate]") {
  Config config;
  config.task.max_tilt_deg = 3.0;
  config.task.max_load_n = 42.0;
  config.decision.partner_load_n = std::numeric_limits<double>::infinity();
  const CertificateLimits limits = certificate_limits(config);
  CHECK(limits.max_tilt_deg == 3.0);
  CHECK(limits.max_load_n == 42.0);
  CHECK_FALSE(limits.partner_load_n);
}
