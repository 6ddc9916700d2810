#include "tools/visualization/scene/solid_scene.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"
#include "sim_hal/synthetic/scene_objects.hpp"

namespace colift::picture {
namespace {

constexpr double kParallel_m = 2000.0;  // a camera so far away sees without perspective

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

Solid solid_of(const sim_hal::Shape& shape) {
  switch (shape.label) {
    case sim_hal::Label::Ground:
      return {shape, SolidRole::Ground};
    case sim_hal::Label::Target:
      return {shape, SolidRole::Target};
    case sim_hal::Label::Partner:
      return {shape, SolidRole::Partner};
    case sim_hal::Label::Robot:
      return {shape, SolidRole::Robot};
    case sim_hal::Label::Wall:
      return {shape, SolidRole::Wall};
    case sim_hal::Label::Clutter:
    case sim_hal::Label::Nothing:
      break;
  }
  return {shape, SolidRole::Clutter};
}

std::vector<Solid> robot_solids(const hal::RobotModel& model, const hal::JointVector& q_rad,
                                const hal::HandPosture& hand) {
  std::vector<Pose> X_WL;
  hal::link_poses(model, q_rad, hand, X_WL);
  std::vector<Solid> solids;
  for (std::size_t link = 0; link < model.links.size(); ++link)
    for (const hal::LinkShape& shape : model.links[link].shapes)
      solids.push_back({sim_hal::link_shape(shape, X_WL[link]),
                        model.in_hand(static_cast<int>(link)) ? SolidRole::Hand : SolidRole::Robot});
  return solids;
}

Pose SolidView::X_WC() const {
  const Vec3 ahead = (target - eye).normalized();
  return sim_hal::look_at(height_m ? Vec3(eye - kParallel_m * ahead) : eye, target);
}

hal::CameraIntrinsics SolidView::intrinsics() const {
  const double focal = height_m ? height * ((target - eye).norm() + kParallel_m) / *height_m
                                : 0.5 * height / std::tan(0.5 * hal::deg_to_rad(angle_deg));
  return {width, height, focal, focal, 0.5 * width - 0.5, 0.5 * height - 0.5};
}

std::optional<Px> SolidView::at(const Vec3& p_W) const {
  const Vec3 p = X_WC().linear().transpose() * (p_W - eye);
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
    if (solid.role == SolidRole::Ground || solid.role == SolidRole::Wall ||
        solid.kind == Solid::Kind::HalfSpace)
      continue;
    for (const Vec3& p : sim_hal::corners(solid)) {
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
    const Eigen::Matrix3d axes = view.X_WC().linear();
    view.target += distance / focal * (off.x() * axes.col(0) + off.y() * axes.col(1));
    const Px size = most - least;
    distance *= std::max(size.x() / ((1 - 2 * kMargin) * width), size.y() / ((1 - 2 * kMargin) * height));
  }
  view.eye = view.target + distance * towards_eye;
  return view;
}

}  // namespace colift::picture
