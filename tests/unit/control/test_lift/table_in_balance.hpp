#pragma once

// A table in static balance: two hands that hold it as turning springs about the line between them, and four
// feet that may stand.

#include <cmath>
#include <numbers>

#include "control/test_lift/test_lift.hpp"
#include "hal/types/units.hpp"

namespace colift::control::test {

using hal::Vec3;

inline constexpr double kGravity = hal::kGravity_m_s2, kDegree = std::numbers::pi / 180.0;
inline const Vec3 kPartner(0.4, 0.05, 0.4);

struct Table {
  double mass_kg = 4.0;
  Vec3 cog{0.0, 0.0, 0.3};
  double grip_nm_rad = 65.0;
  Vec3 partner = kPartner;
};

inline CarriedObject seen(const Table&) {
  CarriedObject object;
  object.cog = {0.0, 0.0, 0.3};
  object.cog_covariance = 1e-4 * Eigen::Matrix3d::Identity();
  object.feet = {{-0.4, -0.3, 0.0}, {0.4, -0.3, 0.0}, {0.4, 0.3, 0.0}, {-0.4, 0.3, 0.0}};
  return object;
}

// both hands raised by `height`
inline MeasuredLift raised(const Table& table, const Vec3& grasp, double height) {
  const Vec3 u = Vec3((grasp - table.partner).x(), (grasp - table.partner).y(), 0.0).normalized();
  const Vec3 n = Vec3::UnitZ().cross(u);
  const double weight = table.mass_kg * kGravity, lever = n.dot(table.cog - table.partner);
  double turn = -weight * lever / table.grip_nm_rad, foot_n = 0.0, foot_along = 0.0;
  for (const Vec3& f : seen(table).feet) {
    const double side = n.dot(f - table.partner);
    if (height + turn * side >= 0.0) continue;
    turn = -height / side;
    foot_n = (weight * lever + table.grip_nm_rad * turn) / side;
    foot_along = u.dot(f - table.partner);
  }
  MeasuredLift test;
  test.palm = test.grasp = grasp;
  test.partner = table.partner;
  const double robot_n =
      (weight * u.dot(table.cog - table.partner) - foot_n * foot_along) / u.dot(grasp - table.partner);
  test.measured = {-robot_n * Vec3::UnitZ(), table.grip_nm_rad * turn * u};
  test.X_WTnow_WTref.linear() = Eigen::AngleAxisd(turn, u).toRotationMatrix();
  test.X_WTnow_WTref.translation() =
      table.partner - test.X_WTnow_WTref.linear() * table.partner + height * Vec3::UnitZ();
  return test;
}

inline MeasuredLift test_lift(const Table& table, const Vec3& grasp,
                              const control::TestLiftConfig& config = {}) {
  MeasuredLift test;
  for (double height = 0.0005; height <= config.height_m; height += 0.0005) {
    test = raised(table, grasp, height);
    if (raise_on(hanging(seen(table), table.partner, grasp, test.X_WTnow_WTref), config) ==
        control::Raise::Enough)
      break;
  }
  return test;
}

inline double tilt_deg(const Table& table, const Vec3& grasp) {
  return hanging(seen(table), table.partner, grasp, raised(table, grasp, 0.1).X_WTnow_WTref).tilt_rad /
         kDegree;
}

}  // namespace colift::control::test
