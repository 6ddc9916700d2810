#include "perception/thesis/pcl_cloud.hpp"

#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

namespace colift::perception {

PclCloud::PclCloud() : points_(std::make_shared<const Points>()) {}

PclCloud::PclCloud(std::span<const Eigen::Vector3f> points) {
  auto cloud = std::make_shared<Points>();
  cloud->reserve(points.size());
  for (const Eigen::Vector3f& p : points)
    if (p.allFinite()) cloud->push_back(pcl::PointXYZ{p.x(), p.y(), p.z()});
  points_ = std::move(cloud);
}

std::size_t PclCloud::size() const {
  return points_->size();
}

std::vector<Eigen::Vector3f> PclCloud::to_vector() const {
  std::vector<Eigen::Vector3f> out;
  out.reserve(points_->size());
  for (const pcl::PointXYZ& p : *points_) out.emplace_back(p.x, p.y, p.z);
  return out;
}

}  // namespace colift::perception
