#include "control/test_lift/cog_belief.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/types/units.hpp"
#include "planner/grasp/share_choice.hpp"

namespace colift::control {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kNearest_m = 0.02;      // the centre of gravity is not in the partner's hand
constexpr double kFootHeight_m = 0.001;  // feet that differ by less stand together: the camera's resolution
constexpr double kSureTurn_rad = hal::deg_to_rad(0.3);  // below it the camera's noise is the turn

double cross(const Vec2& a, const Vec2& b) {
  return a.x() * b.y() - a.y() * b.x();
}

Vec2 level(const hal::Vec3& p) {
  return p.head<2>();
}

Vec2 along_hands(const hal::Vec3& partner, const hal::Vec3& grasp) {
  return level(grasp - partner).normalized();
}

// one test lift, made ready for many places
struct Reading {
  Vec2 partner = Vec2::Zero();
  Vec2 measured = Vec2::Zero();  // q (kg m)
  std::optional<Vec2> foot;      // from the partner; set where one stands
};

// Several feet that stand act as one between them, nearer to the lower.
Vec2 standing_foot(const CarriedObject& object, const hal::Vec3& partner, const hal::Pose& moved) {
  double lowest = INFINITY;
  std::vector<double> rise;
  for (const hal::Vec3& f : object.feet) {
    rise.push_back((moved * f - f).z());
    lowest = std::min(lowest, rise.back());
  }
  Vec2 sum = Vec2::Zero();
  double weights = 0.0;
  for (std::size_t i = 0; i < rise.size(); ++i) {
    const double weight = std::exp(-(rise[i] - lowest) / kFootHeight_m);
    sum += weight * level(object.feet[i]);
    weights += weight;
  }
  return sum / weights - level(partner);
}

// mass that a place asks for, and how far the place is from all that fits the test (m); none: impossible
struct Fit {
  double mass_kg = 0.0, off_m = 0.0;
};
std::optional<Fit> fit(const Reading& test, const Vec2& arm) {
  const Vec2 ray = test.measured.normalized();
  const double along = ray.dot(arm);
  if (test.foot) {
    const double span = cross(arm, *test.foot), side = cross(test.measured, *test.foot);
    if (span * side <= 0.0) return std::nullopt;  // beyond the foot: it would tip over it
    if (cross(test.measured, arm) * side >= 0.0) return Fit{side / span, 0.0};
    // on the wrong side of the felt direction, as far as errors go
  }
  if (along < kNearest_m) return std::nullopt;
  return Fit{test.measured.norm() / along, std::abs(cross(ray, arm))};
}

bool inside(const std::vector<hal::Vec3>& corners, const Vec2& p) {
  bool left = true, right = true;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec2 a = level(corners[i]), b = level(corners[(i + 1) % corners.size()]);
    const double side = cross(b - a, p - a);
    left = left && side >= 0.0;
    right = right && side <= 0.0;
  }
  return left || right;
}

// torque about the line between the hands against the turn about it, over all tests
double grip_of(const CarriedObject& object, std::span<const MeasuredLift> tests,
               const CogBeliefConfig& config) {
  double product = config.grip_nm_rad * kSureTurn_rad * kSureTurn_rad, square = kSureTurn_rad * kSureTurn_rad;
  for (const MeasuredLift& test : tests) {
    const Vec2 axis = along_hands(test.partner, test.grasp);
    const double turn = std::abs(hanging(object, test.partner, test.grasp, test.X_WTnow_WTref).turn_rad);
    const double torque = hal::kGravity_m_s2 * std::abs(cross(measured_moment(test), axis));
    product += torque * turn;
    square += turn * turn;
  }
  return product / square;
}

}  // namespace

Hanging hanging(const CarriedObject& object, const hal::Vec3& partner, const hal::Vec3& grasp,
                const hal::Pose& moved) {
  const Eigen::AngleAxisd turn(moved.linear());
  const hal::Vec3 up = moved.linear().col(2);
  Hanging out;
  out.turn_rad = turn.angle() * level(turn.axis()).dot(along_hands(partner, grasp));
  out.tilt_rad = std::atan2(level(up).norm(), up.z());
  out.min_rise_m = INFINITY;
  for (const hal::Vec3& f : object.feet) out.min_rise_m = std::min(out.min_rise_m, (moved * f - f).z());
  return out;
}

Vec2 measured_moment(const MeasuredLift& test) {
  // what the hand does to the object, about the partner; z x (d x z) = d for level d
  const hal::Vec3 force = -test.measured.force;
  const hal::Vec3 about = (test.palm - test.partner).cross(force) - test.measured.torque;
  return Vec2(-about.y(), about.x()) / hal::kGravity_m_s2;
}

Vec2 CogBelief::mean() const {
  Vec2 sum = Vec2::Zero();
  for (const Case& c : cases) sum += c.weight * c.cog;
  return sum;
}

Eigen::Matrix2d CogBelief::covariance() const {
  const Vec2 middle = mean();
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const Case& c : cases) sum += c.weight * (c.cog - middle) * (c.cog - middle).transpose();
  return sum;
}

double CogBelief::mass_kg() const {
  double sum = 0.0;
  for (const Case& c : cases) sum += c.weight * std::log(c.mass_kg);
  return std::exp(sum);
}

hal::Result<CogBelief> weigh_cog(const CarriedObject& object, std::span<const MeasuredLift> tests,
                                 const CogBeliefConfig& config) {
  if (object.feet.size() < 3 || tests.empty())
    return hal::failure(
        hal::ErrorCode::BadInput, "test_lift",
        fmt::format("{} test lifts of an object with {} feet", tests.size(), object.feet.size()));
  std::vector<Reading> readings;
  for (const MeasuredLift& test : tests) {
    Reading reading{level(test.partner), measured_moment(test), {}};
    const Hanging seen = hanging(object, test.partner, test.grasp, test.X_WTnow_WTref);
    if (seen.min_rise_m < config.clear_m) {
      if (std::abs(seen.turn_rad) < kSureTurn_rad) continue;  // it stands as it stood
      reading.foot = standing_foot(object, test.partner, test.X_WTnow_WTref);
    }
    readings.push_back(reading);
  }
  if (readings.empty())
    return hal::failure(hal::ErrorCode::NotFound, "test_lift", "the object stands as it stood");
  const Eigen::Matrix2d covariance =
      object.cog_covariance.topLeftCorner<2, 2>() +
      std::max(1e-6, config.density_sigma_m * config.density_sigma_m) * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d information = covariance.inverse();

  Vec2 low = level(object.feet.front()), high = low;
  for (const hal::Vec3& f : object.feet) low = low.cwiseMin(level(f)), high = high.cwiseMax(level(f));
  CogBelief belief;
  std::vector<double> chance;  // logarithms
  for (double x = low.x(); x <= high.x(); x += config.step_m) {
    for (double y = low.y(); y <= high.y(); y += config.step_m) {
      const Vec2 place(x, y);
      if (!inside(object.feet, place)) continue;
      const Vec2 off = place - level(object.cog);
      double log_chance = -0.5 * off.dot(information * off), log_mass = 0.0;
      std::vector<double> masses;
      bool possible = true;
      for (const Reading& reading : readings) {
        const auto fits = fit(reading, place - reading.partner);
        possible = fits && fits->mass_kg > config.min_mass_kg && fits->mass_kg < config.max_mass_kg;
        if (!possible) break;
        const double sigma =
            std::hypot(config.place_m, config.partner_nm / (fits->mass_kg * hal::kGravity_m_s2));
        log_chance -= 0.5 * fits->off_m * fits->off_m / (sigma * sigma);
        masses.push_back(std::log(fits->mass_kg));
        log_mass += masses.back();
      }
      if (!possible) continue;
      log_mass = object.known_mass_kg ? std::log(*object.known_mass_kg)
                                      : log_mass / static_cast<double>(masses.size());
      for (const double m : masses) {
        const double d = (m - log_mass) / config.mass_sigma;
        log_chance -= 0.5 * d * d;
      }
      belief.cases.push_back({place, std::exp(log_mass), 0.0});
      chance.push_back(log_chance);
    }
  }
  if (belief.cases.empty())
    return hal::failure(hal::ErrorCode::NotFound, "test_lift",
                        "no centre of gravity over the object's base fits the measured wrench and tilt");
  const double best = *std::max_element(chance.begin(), chance.end());
  double sum = 0.0;
  for (std::size_t i = 0; i < chance.size(); ++i) sum += belief.cases[i].weight = std::exp(chance[i] - best);
  for (CogBelief::Case& c : belief.cases) c.weight /= sum;
  belief.grip_nm_rad = grip_of(object, tests, config);
  return belief;
}

double lever_share(const Vec2& cog, const hal::Vec3& partner, const hal::Vec3& grasp) {
  return planner::lever_share({cog.x(), cog.y(), 0.0}, partner, grasp, hal::Vec3::UnitZ())
      .value_or(std::numeric_limits<double>::quiet_NaN());
}

double chance_level(const CogBelief::Case& one, double grip_nm_rad, const hal::Vec3& partner,
                    const hal::Vec3& grasp, double max_turn_rad, double grip_sigma) {
  const Vec2 axis = along_hands(partner, grasp);
  const double torque = one.mass_kg * hal::kGravity_m_s2 * std::abs(cross(axis, one.cog - level(partner)));
  const double spare = std::log(grip_nm_rad * max_turn_rad / std::max(torque, 1e-9));
  return 0.5 * std::erfc(-spare / (std::sqrt(2.0) * std::max(grip_sigma, 1e-3)));
}

double chance_level(const CogBelief& belief, const hal::Vec3& partner, const hal::Vec3& grasp,
                    double max_turn_rad, double grip_sigma) {
  double chance = 0.0;
  for (const CogBelief::Case& c : belief.cases)
    chance += c.weight * chance_level(c, belief.grip_nm_rad, partner, grasp, max_turn_rad, grip_sigma);
  return chance;
}

}  // namespace colift::control
