#include "sim_hal/mujoco/sim_helpers.hpp"

#include <algorithm>

namespace colift::sim_hal {
namespace {

constexpr double kTick_s = 0.001, kTakes_s = 0.4;
constexpr double kStiffness_n_m = 1500.0, kDamping_ns_m = 80.0, kStrength_n = 250.0;
constexpr double kBeside_m = 0.15;  // from the palm
constexpr double kPull_m_s = 0.1;

}  // namespace

void SimHelpers::take(const Pose& X_WT, const Vec3& palm_W) {
  hands_.clear();
  pull_W_.setZero();
  for (const Vec3& beside :
       {Vec3(kBeside_m, 0, 0), Vec3(-kBeside_m, 0, 0), Vec3(0, kBeside_m, 0), Vec3(0, -kBeside_m, 0)}) {
    const Vec3 at_W = palm_W + beside;
    hands_.push_back({X_WT.inverse() * at_W, at_W, beside});
  }
}

std::array<SimHelpers::Hand, SimHelpers::kHands> SimHelpers::tick(const Pose& X_WT, const Vec3& v_W,
                                                                  const Vec3& w_W, const Vec3& robot_force_W,
                                                                  const Vec3& robot_torque_W) {
  std::array<Hand, kHands> out;
  const double left_m = pull_W_.norm();
  const Vec3 pulled_W =
      left_m > 0.0 ? Vec3(pull_W_ * std::min(1.0, kPull_m_s * kTick_s / left_m)) : Vec3::Zero();
  pull_W_ -= pulled_W;
  for (std::size_t i = 0; i < hands_.size(); ++i) {
    Place& hand = hands_[i];
    hand.start_W += pulled_W;
    // two of the four hands have a lever for a torque about a horizontal axis, all four about the vertical
    const Vec3 turns =
        Vec3(robot_torque_W.x(), robot_torque_W.y(), 0.5 * robot_torque_W.z()).cross(hand.arm_W) /
        (2.0 * kBeside_m * kBeside_m);
    hand.borne_W += kTick_s / kTakes_s * (robot_force_W / kHands + turns);
    const Vec3 at_W = X_WT * hand.at_T;
    const Vec3 v_at_W = v_W + w_W.cross(at_W - X_WT.translation());
    Vec3 force_W = kStiffness_n_m * (hand.start_W - at_W) + hand.borne_W - kDamping_ns_m * v_at_W;
    if (const double n = force_W.norm(); n > kStrength_n) force_W *= kStrength_n / n;
    out[i] = {at_W, force_W};
  }
  return out;
}

}  // namespace colift::sim_hal
