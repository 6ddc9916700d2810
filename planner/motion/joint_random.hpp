#pragma once

#include <cstdint>
#include <random>

#include "planner/motion/free_space.hpp"

namespace colift::planner {

/// Random joint positions that are the same on every machine: the engine is fixed by the standard, the
/// distributions are ours.
class JointRandom {
 public:
  explicit JointRandom(std::uint64_t seed) : engine_(seed) {}

  /// In [0, 1), 53 bits.
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }

  hal::JointVector in(const JointBox& box) {
    hal::JointVector q;
    for (int i = 0; i < hal::kArmJoints; ++i) q[i] = between(box.lower_rad[i], box.upper_rad[i]);
    return q;
  }
  /// Within `reach_rad` of a position in every joint, and in the box.
  hal::JointVector near(const hal::JointVector& q_rad, double reach_rad, const JointBox& box) {
    const auto reach = hal::JointVector::Constant(reach_rad);
    return in({(q_rad - reach).cwiseMax(box.lower_rad), (q_rad + reach).cwiseMin(box.upper_rad)});
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace colift::planner
