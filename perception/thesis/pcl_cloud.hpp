#pragma once

#include <memory>
#include <span>
#include <vector>

#include "hal/types/geometry.hpp"

// PCL's own headers cost seconds per source file, so only the .cpp files of this folder see them.
namespace pcl {
struct PointXYZ;
template <typename PointT>
class PointCloud;
}  // namespace pcl

namespace colift::perception {

/// Finite points in frame W as PCL holds them. Cheap to copy: the points are shared and never change.
class PclCloud {
 public:
  using Points = pcl::PointCloud<pcl::PointXYZ>;

  PclCloud();
  explicit PclCloud(std::span<const Eigen::Vector3f> points);
  explicit PclCloud(std::shared_ptr<const Points> points) : points_(std::move(points)) {}

  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::vector<Eigen::Vector3f> to_vector() const;
  [[nodiscard]] const std::shared_ptr<const Points>& get() const { return points_; }

 private:
  std::shared_ptr<const Points> points_;
};

}  // namespace colift::perception
