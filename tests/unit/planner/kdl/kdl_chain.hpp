#pragma once

#include <kdl/chain.hpp>
#include <kdl/frames.hpp>
#include <kdl/jntarray.hpp>

#include "hal/robot_model/robot_model.hpp"

namespace colift::test {

/// The LWR 4+ as a KDL chain, from the modified Denavit-Hartenberg table of public descriptions and not from
/// our URDF.
inline KDL::Chain lwr_chain() {
  constexpr double kRight = 1.57079632679489661923;
  const double alpha[] = {0, kRight, -kRight, -kRight, kRight, kRight, -kRight};
  const double d[] = {0.3105, 0, 0.4, 0, 0.39, 0, 0.078};
  KDL::Chain chain;
  for (int i = 0; i < hal::kArmJoints; ++i) {
    // the fixed part of a row comes before its joint; the translation along z commutes with the turn about z
    chain.addSegment(
        KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame::DH_Craig1989(0, alpha[i], d[i], 0)));
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::RotZ)));
  }
  return chain;
}

inline KDL::JntArray to_kdl(const hal::JointVector& q_rad) {
  KDL::JntArray q(hal::kArmJoints);
  for (unsigned i = 0; i < hal::kArmJoints; ++i) q(i) = q_rad[static_cast<int>(i)];
  return q;
}

inline KDL::Frame to_kdl(const hal::Pose& X) {
  const auto& R = X.matrix();
  return KDL::Frame(
      KDL::Rotation(R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2)),
      KDL::Vector(R(0, 3), R(1, 3), R(2, 3)));
}

inline hal::Pose from_kdl(const KDL::Frame& frame) {
  hal::Pose X = hal::Pose::Identity();
  for (int i = 0; i < 3; ++i) {
    X.translation()[i] = frame.p(i);
    for (int j = 0; j < 3; ++j) X.linear()(i, j) = frame.M(i, j);
  }
  return X;
}

}  // namespace colift::test
