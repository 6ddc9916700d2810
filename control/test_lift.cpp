#include "control/test_lift.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace colift::control {
namespace {

constexpr double kGravity = 9.80665;  // m/s^2
constexpr double kSameHand_m = 0.05;
constexpr double kNearest_m = 0.02;  // the centre of gravity is not in the partner's hand

using Vec2 = Eigen::Vector2d;

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

}  // namespace

hal::Result<TestLift> understand_test_lift(const TestLiftInput& in, const TestLiftConfig& config) {
  const bool finite = in.felt.force.allFinite() && in.felt.torque.allFinite() && in.palm.allFinite() &&
                      in.grasp.allFinite() && in.partner.allFinite() && in.cog.allFinite() &&
                      in.cog_covariance.allFinite();
  if (!finite) return hal::failure(hal::ErrorCode::BadInput, "test_lift", "a number is not finite");
  const Vec2 partner = in.partner.head<2>(), span = in.grasp.head<2>() - partner;
  if (span.norm() < kSameHand_m)
    return hal::failure(hal::ErrorCode::BadInput, "test_lift",
                        fmt::format("the hands are {:.0f} mm apart", 1e3 * span.norm()));

  // what the hand does to the object, about the partner
  const hal::Vec3 force = -in.felt.force;
  const hal::Vec3 about_partner = (in.palm - in.partner).cross(force) - in.felt.torque;
  // z x (d x z) = d for level d: the level part of m (c - p)
  const Vec2 moment = Vec2(-about_partner.y(), about_partner.x()) / kGravity;
  if (force.z() < config.least_load_n || moment.norm() < 1e-3)
    return hal::failure(
        hal::ErrorCode::NotFound, "test_lift",
        fmt::format("the robot bears {:.1f} N (least {:.1f} N): the object stands on the ground", force.z(),
                    config.least_load_n));

  TestLift out;
  const Vec2 believed = in.cog.head<2>() - partner;
  double distance = 0.0;
  const Vec2 ray = moment.normalized();
  if (in.known_mass_kg && *in.known_mass_kg > 0.0) {
    distance = moment.norm() / *in.known_mass_kg;
  } else {
    const Eigen::Matrix2d covariance =
        in.cog_covariance.topLeftCorner<2, 2>() +
        std::max(1e-6, config.density_sigma_m * config.density_sigma_m) * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d information = covariance.inverse();
    distance = ray.dot(information * believed) / ray.dot(information * ray);
  }
  distance = std::max(distance, kNearest_m);
  out.mass_kg = moment.norm() / distance;
  out.cog = in.cog;
  out.cog.head<2>() = partner + distance * ray;
  out.lever_m = std::abs(cross(distance * ray, span.normalized()));
  out.share = force.z() / (out.mass_kg * kGravity);

  const std::string facts = fmt::format("{:.1f} kg, centre of gravity {:.0f} mm from where its shape has it",
                                        out.mass_kg, 1e3 * (out.cog - in.cog).norm());
  if (out.lever_m > config.max_lever_m) {
    out.next = TestLift::Next::Regrasp;
    out.because = fmt::format("{}, {:.0f} mm beside the line between both hands (limit {:.0f} mm)", facts,
                              1e3 * out.lever_m, 1e3 * config.max_lever_m);
  } else if (std::abs(out.share - in.share_predicted) > config.max_share_error) {
    out.next = TestLift::Next::OtherShare;
    out.because = fmt::format("{}; the robot bears {:.0f} % where {:.0f} % were expected", facts,
                              100 * out.share, 100 * in.share_predicted);
  } else {
    out.because = fmt::format("{}, {:.0f} mm beside the line between both hands", facts, 1e3 * out.lever_m);
  }
  return out;
}

}  // namespace colift::control
