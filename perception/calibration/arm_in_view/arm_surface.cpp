#include "perception/calibration/arm_in_view/arm_surface.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {

using hal::Vec3;

ArmSurface::ArmSurface(const hal::RobotModel& robot, const hal::JointVector& q_rad,
                       const hal::HandPosture& hand) {
  std::vector<hal::Pose> X_BL;
  hal::link_poses(robot, q_rad, hand, X_BL);
  int hand_body = -1;
  for (std::size_t i = 0; i < robot.links.size(); ++i) {
    if (robot.links[i].shapes.empty()) continue;
    const bool in_hand = robot.in_hand(static_cast<int>(i));
    const int body = in_hand && hand_body >= 0 ? hand_body : bodies_++;
    if (in_hand) hand_body = body;
    for (const hal::LinkShape& s : robot.links[i].shapes) {
      Vec3 half = 0.5 * s.size;
      double radius_m = half.norm();
      if (s.kind == hal::LinkShape::Kind::Sphere) {
        half.x() = radius_m = s.size.x();
      } else if (s.kind == hal::LinkShape::Kind::Cylinder) {
        half = {s.size.x(), 0.5 * s.size.y(), 0.0};
        radius_m = half.norm();
      }
      const hal::Pose X_BS = X_BL[i] * s.X_LS;
      solids_.push_back({s.kind, X_BS.inverse(), half, X_BS.translation(), radius_m, body});
    }
  }
}

double ArmSurface::distance_to(const Solid& s, const Vec3& p_B, Vec3& normal_B) {
  const Vec3 p = s.X_SB * p_B;
  Vec3 n = Vec3::UnitZ();
  double d = 0.0;
  switch (s.kind) {
    case hal::LinkShape::Kind::Sphere: {
      const double r = p.norm();
      d = r - s.half.x();
      if (r > 1e-9) n = p / r;
      break;
    }
    case hal::LinkShape::Kind::Cylinder: {
      const double r = std::hypot(p.x(), p.y());
      const double a = r - s.half.x(), b = std::abs(p.z()) - s.half.y();
      const Vec3 radial = r > 1e-9 ? Vec3(p.x() / r, p.y() / r, 0.0) : Vec3(Vec3::UnitX());
      const Vec3 axial(0.0, 0.0, p.z() < 0 ? -1.0 : 1.0);
      if (a > 0 && b > 0) {
        d = std::hypot(a, b);
        n = (a * radial + b * axial) / d;
      } else {
        d = std::max(a, b);
        n = a > b ? radial : axial;
      }
      break;
    }
    case hal::LinkShape::Kind::Box: {
      const Vec3 q = p.cwiseAbs() - s.half;
      const Vec3 sign(p.x() < 0 ? -1.0 : 1.0, p.y() < 0 ? -1.0 : 1.0, p.z() < 0 ? -1.0 : 1.0);
      const Vec3 out = q.cwiseMax(0.0);
      if (out.norm() > 1e-9) {
        d = out.norm();
        n = out.cwiseProduct(sign) / d;
      } else {
        int axis = 0;
        d = q.maxCoeff(&axis);
        n = Vec3::Unit(axis) * sign[axis];
      }
      break;
    }
  }
  normal_B = s.X_SB.linear().transpose() * n;
  return d;
}

ArmSurface::Nearest ArmSurface::nearest(const Vec3& p_B) const {
  Nearest best;
  Vec3 n;
  for (const Solid& s : solids_) {
    // the surface is no nearer than that of the sphere around it
    const double reach = best.distance_m + s.radius_m + 1e-9;
    if (reach < 0 || (p_B - s.middle_B).squaredNorm() > reach * reach) continue;
    const double d = distance_to(s, p_B, n);
    if (d < best.distance_m) best = {d, n, s.body};
  }
  return best;
}

hal::Aabb ArmSurface::around(double padding_m) const {
  hal::Aabb box;
  for (const Solid& s : solids_) box.extend(s.middle_B);
  box.min() -= Vec3::Constant(padding_m);
  box.max() += Vec3::Constant(padding_m);
  return box;
}

}  // namespace colift::perception
