#include "hal/drivers/kuka_fri/cart_set_point.hpp"

#include <algorithm>

namespace colift::hal {
namespace {

constexpr double kStart_m = 0.002,
                 kStart_rad = 0.01;  // a first command this near to the measured pose is there
constexpr double kOrthogonal = 1e-3;
constexpr double kFar_m = 10.0;

/// Rotation vector of R (rad).
Vec3 rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

Vec3 shorter(const Vec3& v, double by) {
  const double length = v.norm();
  return length <= by ? Vec3::Zero() : Vec3(v * ((length - by) / length));
}

}  // namespace

SixVector from_wire_order(const FriSix& v) {
  SixVector x;
  for (int i = 0; i < 6; ++i) x[i] = static_cast<double>(v[static_cast<std::size_t>(i < 3 ? i : 8 - i)]);
  return x;
}

FriSix to_wire_order(const SixVector& v) {
  FriSix x{};
  for (int i = 0; i < 6; ++i) x[static_cast<std::size_t>(i)] = static_cast<float>(v[i < 3 ? i : 8 - i]);
  return x;
}

Pose from_wire_frame(const FriFrame& f) {
  Pose p = Pose::Identity();
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      p(row, column) = static_cast<double>(f[static_cast<std::size_t>(4 * row + column)]);
  return p;
}

FriFrame to_wire_frame(const Pose& p) {
  FriFrame f{};
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      f[static_cast<std::size_t>(4 * row + column)] = static_cast<float>(p(row, column));
  return f;
}

void CartSetPoint::mirror(const FriFrame& measured) {
  wire_ = measured;
  X_ = from_wire_frame(measured);
  by_.setZero();
  turn_.setZero();
  first_ = false;
}

void CartSetPoint::expect_first(const FriFrame& measured) {
  first_X_ = from_wire_frame(measured);
  first_ = true;
}

FriLimit CartSetPoint::command(const Pose& X, int steps, double period_s, double safety_limits) {
  using What = FriLimit::What;
  if (!X.matrix().allFinite()) return {What::NotFinite, 0, 0.0, 0.0};
  const Eigen::Matrix3d R = X.linear();
  const double skew = (R.transpose() * R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
  if (skew > kOrthogonal || R.determinant() < 0.0) return {What::Frame, 0, skew, kOrthogonal};
  for (int i = 0; i < 3; ++i)
    if (std::abs(X.translation()[i]) > kFar_m)
      return {What::Position, static_cast<std::uint8_t>(i), X.translation()[i], kFar_m};

  const Vec3 by = X.translation() - X_.translation();
  const Vec3 turn = rotation_vector(R * X_.linear().transpose());
  const double part = safety_limits > 0.0 ? safety_limits : 1.0;
  const double most_m = limits_.velocity_m_s * part * period_s;
  const double most_rad = limits_.velocity_rad_s * part * period_s;
  if (first_) {
    const double off_m = std::min((X.translation() - first_X_.translation()).norm(), by.norm());
    const double off_rad = std::min(rotation_vector(R * first_X_.linear().transpose()).norm(), turn.norm());
    if (off_m > kStart_m) return {What::Start, 0, off_m, kStart_m};
    if (off_rad > kStart_rad) return {What::Start, 3, off_rad, kStart_rad};
  } else {
    if (by.norm() > steps * most_m * 1.0001) return {What::Speed, 0, by.norm(), steps * most_m};
    if (turn.norm() > steps * most_rad * 1.0001) return {What::Speed, 3, turn.norm(), steps * most_rad};
  }
  first_ = false;
  by_ = by;
  turn_ = turn;
  X_ = X;
  wire_ = to_wire_frame(X);
  return {};
}

void CartSetPoint::repeat() {
  by_.setZero();
  turn_.setZero();
}

void CartSetPoint::brake(double period_s) {
  first_ = false;
  if (at_rest()) return;
  by_ = shorter(by_, limits_.acceleration_m_s2 * period_s * period_s);
  turn_ = shorter(turn_, limits_.acceleration_rad_s2 * period_s * period_s);
  X_.translation() += by_;
  if (const double angle = turn_.norm(); angle > 0.0)
    X_.linear() = Eigen::AngleAxisd(angle, turn_.normalized()).toRotationMatrix() * X_.linear();
  wire_ = to_wire_frame(X_);
}

}  // namespace colift::hal
