#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "perception/target/regions/components.hpp"
#include "perception/target/regions/fragments.hpp"

namespace colift::perception {

/// An object as the camera sees it: its points across the view, over the ground and away from the camera, and
/// its upper contour in bins across the view. Lengths in m.
class Silhouette {
 public:
  static constexpr double kBin_m = 0.03;  ///< A quarter of a head's width, half of a table leg's.

  /// A point of the object (m).
  struct Point {
    float across, height, along;  ///< Across the view, over the ground, away from the camera.
  };
  /// A part of the view: across and height from .. to.
  struct Window {
    double left, right, low, high;
  };

  Silhouette(const OrganisedCloud& cloud, const Components& components, const Fragment& object,
             const Ground& ground);

  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  /// Height of the third highest point of each bin, so that flying pixels have no say; -1000 where there is
  /// none.
  [[nodiscard]] const std::vector<float>& top() const { return top_; }
  [[nodiscard]] double across(double bin) const { return least_ + (bin + 0.5) * kBin_m; }
  [[nodiscard]] double left() const { return least_; }
  [[nodiscard]] double width() const { return points_.empty() ? 0.0 : most_ - least_; }
  /// Extent away from the camera, without the outermost twentieth of the points at either end.
  [[nodiscard]] double depth() const;
  [[nodiscard]] std::vector<Point> in(const Window& window) const;
  [[nodiscard]] Vec3 place(const Point& p) const;
  [[nodiscard]] bool contains(const Window& w, const Vec3& p_W) const {
    const double across = right_.dot(p_W - eye_), height = ground_.height(p_W);
    return across >= w.left && across <= w.right && height >= w.low && height <= w.high;
  }

 private:
  std::vector<Point> points_;
  std::vector<float> top_;
  double least_ = 1e9, most_ = -1e9;
  Vec3 eye_ = Vec3::Zero(), right_ = Vec3::UnitX(), ahead_ = Vec3::UnitY();
  Plane ground_;
};

/// How points (across, height, along) spread about their mean: standard deviations (m), ascending, and their
/// axes as columns.
struct PointSpread {
  Vec3 mean = Vec3::Zero();
  Vec3 deviation_m = Vec3::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
};
[[nodiscard]] PointSpread spread(std::span<const Silhouette::Point> points);

/// Part of a window's cells, kBin_m wide and high, in which there is one of the points.
[[nodiscard]] double fill(const std::vector<Silhouette::Point>& points, const Silhouette::Window& window);

}  // namespace colift::perception
