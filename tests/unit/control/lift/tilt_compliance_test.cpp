#include "control/lift/tilt_compliance.hpp"

#include <catch2/catch.hpp>

#include "hal/types/units.hpp"

using namespace colift;

namespace {

using control::HandLine;
using control::TiltCompliance;
using control::TiltComplianceConfig;
using hal::Vec3;

constexpr double kCycle_s = 0.005;

// the palm looks along the line of the hands; the load acts 60 mm in front of it
HandLine line() {
  return {{0.0, 0.0, 0.06}, Vec3::UnitX()};
}

hal::Pose palm() {
  hal::Pose X_WH = hal::Pose::Identity();
  X_WH.linear().col(0) = -Vec3::UnitZ();
  X_WH.linear().col(1) = Vec3::UnitY();
  X_WH.linear().col(2) = Vec3::UnitX();
  return X_WH;
}

TiltCompliance started(const HandLine& line, const TiltComplianceConfig& config = {}) {
  TiltCompliance c(config);
  c.start(line);
  return c;
}

// An object of 4 kg between a palm and a partner who hold it level, both of them springs, in the plane of the
// two; small motions. The palm's set point was turned by `wrung_rad` when the lift began.
struct Carried {
  double span_m = 0.8, cog_m = 0.4, weight_n = 40.0, wrung_rad = 0.01;
  Eigen::Vector2d palm_stiffness{4000.0, 400.0};  // up, about the pivot
  double his_stiffness = 7000.0;                  // up

  // of the object on the hand: force up, moment about the pivot; a positive angle lowers his end
  [[nodiscard]] Eigen::Vector2d on_hand(double turned_rad) const {
    const Eigen::Vector2d set(0.0, wrung_rad + turned_rad), his_arm(1.0, -span_m);
    const Eigen::Matrix2d Kp = palm_stiffness.asDiagonal();
    const Eigen::Matrix2d Kh = his_stiffness * his_arm * his_arm.transpose();
    const Eigen::Vector2d load(-weight_n, weight_n * cog_m);
    const Eigen::Vector2d moved = (Kp + Kh).ldlt().solve(Kp * set + load);
    return Kp * (moved - set);
  }
};

double share_when_settled(const Carried& object, TiltCompliance& c) {
  const hal::Pose X_WH = palm();
  double force_n = 0.0;
  for (int i = 0; i < 4000; ++i) {
    const Eigen::Vector2d bears = object.on_hand(c.turned_rad());
    force_n = bears.x();
    const Vec3 force(0.0, 0.0, force_n);
    // from the pivot, where the moment was taken, to the palm
    const Vec3 torque = Vec3(0.0, bears.y(), 0.0) - Vec3(-0.06, 0.0, 0.0).cross(force);
    c.update(kCycle_s, {force, torque}, X_WH);
  }
  return -force_n / object.weight_n;
}

TEST_CASE("the weight in the fingers turns no palm, though it bears a moment about it", "[compliance]") {
  TiltCompliance c = started(line());
  const Vec3 weight(0.0, 0.0, -30.0), at(0.06, 0.0, 0.0);
  for (int i = 0; i < 1000; ++i) c.update(kCycle_s, {weight, at.cross(weight)}, palm());
  CHECK(c.turned_rad() == Approx(0.0).margin(1e-12));
}

TEST_CASE("a moment about the pivot turns the palm about the pivot, the way it pushes", "[compliance]") {
  TiltCompliance c = started(line(), {.speed_rad_s_nm = 0.005, .max_deg = 5.0});
  for (int i = 0; i < 200; ++i) c.update(kCycle_s, {Vec3::Zero(), {0.0, 2.0, 0.0}}, palm());
  CHECK(c.turned_rad() == Approx(0.01).margin(1e-9));
  const Vec3 pivot(0.3, 0.2, 0.7);
  CHECK((c.motion(pivot) * pivot - pivot).norm() < 1e-12);
  CHECK((c.motion(pivot) * (pivot + Vec3::UnitX()) - pivot).z() < 0.0);
}

TEST_CASE("forces across the line, and hands that have no line, move nothing", "[compliance]") {
  TiltCompliance c = started(line());
  for (int i = 0; i < 200; ++i) c.update(kCycle_s, {{0.0, 9.0, 0.0}, {1.0, 0.0, 1.0}}, palm());
  CHECK(c.motion(Vec3::Ones()).isApprox(hal::Pose::Identity(), 1e-12));
  TiltCompliance without = started({});
  for (int i = 0; i < 200; ++i) without.update(kCycle_s, {{9.0, 9.0, 9.0}, {9.0, 9.0, 9.0}}, palm());
  CHECK(without.motion(Vec3::Ones()).isApprox(hal::Pose::Identity(), 1e-12));
}

TEST_CASE("the palm turns no farther than it may, and back", "[compliance]") {
  TiltCompliance c = started(line(), {.speed_rad_s_nm = 0.005, .max_deg = 2.0});
  for (int i = 0; i < 20000; ++i) c.update(kCycle_s, {Vec3::Zero(), {0.0, -3.0, 0.0}}, palm());
  CHECK(c.turned_rad() == Approx(-hal::deg_to_rad(2.0)).margin(1e-12));
  c.update(kCycle_s, {Vec3::Zero(), {0.0, 3.0, 0.0}}, palm());
  CHECK(c.turned_rad() > -hal::deg_to_rad(2.0));
}

TEST_CASE("a stiff palm shifts load to the partner; one that gives way carries by the lever rule",
          "[compliance]") {
  for (const double wrung_rad : {-0.01, 0.02}) {
    for (const double cog_m : {0.25, 0.4, 0.5}) {
      Carried object;
      object.wrung_rad = wrung_rad;
      object.cog_m = cog_m;
      const double lever = 1.0 - cog_m / object.span_m;
      TiltCompliance stiff = started(line(), {.speed_rad_s_nm = 0.0});
      TiltCompliance compliant = started(line());
      CAPTURE(wrung_rad, cog_m, lever);
      CHECK(std::abs(share_when_settled(object, stiff) - lever) > 0.03);
      CHECK(share_when_settled(object, compliant) == Approx(lever).margin(0.005));
    }
  }
}

}  // namespace
