#include "planner/motion/collision/carried_target.hpp"

#include <algorithm>
#include <array>

#include "planner/motion/collision/collision_scene.hpp"

namespace colift::planner {
namespace {

using Eigen::Vector3f;

constexpr int kAtOnce = 64;  // cells of one batch; no result depends on it

}  // namespace

CarriedTarget::CarriedTarget(const CollisionScene& scene)
    : scene_(scene), cover_m_(0.8661f * scene.carried_cell_m) {
  touching_.reserve(scene.carried_W.size());
  for (const Vector3f& p : scene.carried_W) touching_.push_back(!scene.obstacles.clear(p, cover_m_));
}

void CarriedTarget::set_origin(const hal::Pose& X_WH) {
  X_WH_before_ = X_WH.cast<float>();
}

float CarriedTarget::depth_m(const Eigen::Isometry3f& X_WH) const {
  const Eigen::Isometry3f X = X_WH * X_WH_before_.inverse();
  const Vector3f up = scene_.ground.normal.cast<float>();
  const auto offset = static_cast<float>(scene_.ground.offset);
  const std::int16_t enough = scene_.obstacles.enough(cover_m_);
  const auto& cells = scene_.carried_W;
  // what counts as only risen: this far down, or a cell's edge aside, at most
  const auto may_fall_m = static_cast<float>(scene_.config.max_carried_fall_m);
  float worst = 0.0f;
  std::array<float, kAtOnce> x, y, z;
  std::array<std::int16_t, kAtOnce> squared;
  for (std::size_t first = 0; first < cells.size(); first += kAtOnce) {
    const int n = static_cast<int>(std::min<std::size_t>(kAtOnce, cells.size() - first));
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Vector3f p = X * cells[first + at];
      x[at] = p.x();
      y[at] = p.y();
      z[at] = p.z();
    }
    scene_.obstacles.look_up(x.data(), y.data(), z.data(), n, squared.data());
    for (int i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const Vector3f p(x[at], y[at], z[at]);
      const Vector3f moved = p - cells[first + at];
      const float risen = up.dot(moved);
      if (risen < -may_fall_m && up.dot(p) + offset < cover_m_) worst = std::max(worst, -risen);
      if (squared[at] >= enough || scene_.obstacles.clear(p, cover_m_)) continue;
      const bool only_risen = risen >= -may_fall_m && (moved - risen * up).norm() <= scene_.carried_cell_m;
      if (touching_[first + at] && only_risen) continue;
      worst = std::max(worst, cover_m_ - scene_.obstacles.distance(p));
    }
  }
  return worst;
}

}  // namespace colift::planner
