#include "tools/visualization/scene/solid_scene.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::picture {
namespace {

// Columns: right, down and ahead of the image in W.
Eigen::Matrix3d axes_of(const SolidView& view) {
  const Vec3 ahead = (view.target - view.eye).normalized();
  Vec3 right = ahead.cross(Vec3::UnitZ());
  right = right.norm() > 1e-6 ? right.normalized() : Vec3::UnitY();
  Eigen::Matrix3d axes;
  axes << right, ahead.cross(right), ahead;
  return axes;
}

// Points that stand for the solid's extent.
std::vector<Vec3> extent(const Solid& solid) {
  std::vector<Vec3> points;
  const double round = solid.kind == Solid::Kind::Box ? 0.0 : solid.size.x();
  Vec3 half = 0.5 * solid.size;
  if (solid.kind == Solid::Kind::Cylinder) half = {round, round, 0.5 * solid.size.y()};
  if (solid.kind == Solid::Kind::Capsule) half = {round, round, 0.5 * solid.size.y() + round};
  if (solid.kind == Solid::Kind::Sphere) half = Vec3::Constant(round);
  for (int corner = 0; corner < 8; ++corner)
    points.push_back(solid.X_WS * Vec3((corner & 1 ? 1 : -1) * half.x(), (corner & 2 ? 1 : -1) * half.y(),
                                       (corner & 4 ? 1 : -1) * half.z()));
  return points;
}

}  // namespace

Colour colour_of(SolidRole role) {
  switch (role) {
    case SolidRole::Ground:
      return rgb(0xEEF1F3);
    case SolidRole::Target:
      return rgb(0xE3B25A);
    case SolidRole::Partner:
      return rgb(0x5E93C4);
    case SolidRole::Robot:
      return rgb(0xE8792B);
    case SolidRole::Hand:
      return rgb(0x59626C);
    case SolidRole::Clutter:
      return rgb(0xA9B4BE);
    case SolidRole::Wall:
      return rgb(0xD5DADF);
  }
  return rgb(0x808080);
}

std::vector<Solid> robot_solids(const hal::RobotModel& model, const hal::JointVector& q_rad,
                                const hal::HandPosture& hand) {
  std::vector<Pose> X_WL;
  hal::link_poses(model, q_rad, hand, X_WL);
  std::vector<Solid> solids;
  for (std::size_t link = 0; link < model.links.size(); ++link) {
    const bool in_hand = model.in_hand(static_cast<int>(link));
    for (const hal::LinkShape& shape : model.links[link].shapes) {
      Solid solid;
      using Kind = hal::LinkShape::Kind;
      solid.kind = shape.kind == Kind::Box        ? Solid::Kind::Box
                   : shape.kind == Kind::Cylinder ? Solid::Kind::Cylinder
                                                  : Solid::Kind::Sphere;
      solid.X_WS = X_WL[link] * shape.X_LS;
      solid.size = shape.size;
      solid.role = in_hand ? SolidRole::Hand : SolidRole::Robot;
      solids.push_back(solid);
    }
  }
  return solids;
}

std::optional<Px> SolidView::at(const Vec3& p_W) const {
  const Vec3 p = axes_of(*this).transpose() * (p_W - eye);
  const Px middle(0.5 * width, 0.5 * height);
  if (height_m) return middle + p.head<2>() * (height / *height_m);
  if (p.z() < 1e-6) return std::nullopt;
  const double focal = 0.5 * height / std::tan(0.5 * hal::deg_to_rad(angle_deg));
  return middle + focal / p.z() * p.head<2>();
}

SolidView view_of(const SolidScene& scene, const Vec3& from, int width, int height) {
  constexpr double kMargin = 0.06;
  SolidView view;
  view.width = width;
  view.height = height;
  std::vector<Vec3> points;
  Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
  for (const Solid& solid : scene.solids) {
    if (solid.role == SolidRole::Ground || solid.role == SolidRole::Wall || solid.kind == Solid::Kind::Ground)
      continue;
    for (const Vec3& p : extent(solid)) {
      if (!p.allFinite()) continue;
      points.push_back(p);
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
  }
  const Vec3 towards_eye = from.normalized();
  if (points.empty()) {
    view.target = Vec3::Zero();
    view.eye = 3.0 * towards_eye;
    return view;
  }
  view.target = 0.5 * (low + high);
  double distance = 2.5 * (high - low).norm() + 0.5;
  for (int i = 0; i < 12; ++i) {
    view.eye = view.target + distance * towards_eye;
    Px least(1e9, 1e9), most(-1e9, -1e9);
    for (const Vec3& p : points) {
      const auto at = view.at(p);
      if (!at) continue;
      least = least.cwiseMin(*at);
      most = most.cwiseMax(*at);
    }
    const double focal = 0.5 * height / std::tan(0.5 * hal::deg_to_rad(view.angle_deg));
    const Px off = 0.5 * (least + most) - Px(0.5 * width, 0.5 * height);
    const Eigen::Matrix3d axes = axes_of(view);
    view.target += distance / focal * (off.x() * axes.col(0) + off.y() * axes.col(1));
    const Px size = most - least;
    distance *= std::max(size.x() / ((1 - 2 * kMargin) * width), size.y() / ((1 - 2 * kMargin) * height));
  }
  view.eye = view.target + distance * towards_eye;
  return view;
}

}  // namespace colift::picture
