#include "expert_pcl.hpp"

#include <pcl/ModelCoefficients.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/octree/octree_pointcloud_changedetector.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/euclidean_cluster_comparator.h>
#include <pcl/segmentation/organized_connected_component_segmentation.h>
#include <pcl/segmentation/sac_segmentation.h>
#include <pcl/segmentation/segment_differences.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

namespace colift::bench {
namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;

constexpr std::size_t kEach = 64;        // pixels of which one is drawn from
constexpr double kOnPlane_m = 0.015;     // for the ground's inliers
constexpr float kAbove_m = 0.02f;        // what stands on it
constexpr float kSameSurface_m = 0.02f;  // neighbours, times their depth
constexpr unsigned kFewest = 300;        // pixels of an object
constexpr float kVoxel_m = 0.01f;        // of the thesis

// in the camera's frame, where the comparator takes z for the distance
Cloud::Ptr organised(const hal::DepthFrame& frame) {
  const auto& k = frame.intrinsics;
  auto cloud = std::make_shared<Cloud>(static_cast<unsigned>(k.width), static_cast<unsigned>(k.height));
  cloud->is_dense = false;
  std::vector<float> x(static_cast<std::size_t>(k.width));
  for (int u = 0; u < k.width; ++u) x[static_cast<std::size_t>(u)] = static_cast<float>((u - k.cx) / k.fx);
  std::size_t i = 0;
  for (int v = 0; v < k.height; ++v) {
    const auto y = static_cast<float>((v - k.cy) / k.fy);
    for (int u = 0; u < k.width; ++u, ++i) {
      const float d = frame.depth_m[i];
      (*cloud)[i].getVector3fMap() = Eigen::Vector3f(d * x[static_cast<std::size_t>(u)], d * y, d);
    }
  }
  return cloud;
}

Cloud::Ptr cropped(const perception::OrganisedCloud& from, const hal::Aabb& box) {
  auto cloud = std::make_shared<Cloud>();
  for (std::size_t i = 0; i < from.size(); ++i)
    if (from.seen(i) && box.contains(from.point(i))) cloud->emplace_back(from.x[i], from.y[i], from.z[i]);
  return cloud;
}

Cloud::Ptr thinned(const Cloud::Ptr& cloud, float leaf_m) {
  pcl::VoxelGrid<Point> grid;
  grid.setLeafSize(leaf_m, leaf_m, leaf_m);
  grid.setInputCloud(cloud);
  auto thin = std::make_shared<Cloud>();
  grid.filter(*thin);
  return thin;
}

}  // namespace

std::optional<ExpertTarget> expert_target(const hal::DepthFrame& frame, const hal::Pose& X_WC) {
  const Cloud::Ptr cloud = organised(frame);
  auto drawn = std::make_shared<Cloud>();
  for (std::size_t i = 0; i < cloud->size(); i += kEach)
    if (std::isfinite((*cloud)[i].x)) drawn->push_back((*cloud)[i]);
  pcl::SACSegmentation<Point> sac;
  sac.setModelType(pcl::SACMODEL_PLANE);
  sac.setMethodType(pcl::SAC_RANSAC);
  sac.setOptimizeCoefficients(true);
  sac.setMaxIterations(200);
  sac.setDistanceThreshold(kOnPlane_m);
  sac.setInputCloud(drawn);
  pcl::PointIndices inliers;
  pcl::ModelCoefficients plane;
  sac.segment(inliers, plane);
  if (inliers.indices.empty()) return std::nullopt;
  Eigen::Vector4f p(plane.values[0], plane.values[1], plane.values[2], plane.values[3]);
  if (p[3] < 0) p = -p;  // the camera is above the ground

  // pixels without a point belong to no component and cost nothing
  const float nan = std::numeric_limits<float>::quiet_NaN();
  for (Point& point : *cloud)
    if (!(p.head<3>().dot(point.getVector3fMap()) + p[3] > kAbove_m)) point.x = nan;
  const auto comparator = std::make_shared<pcl::EuclideanClusterComparator<Point, pcl::Label>>();
  comparator->setInputCloud(cloud);
  comparator->setDistanceThreshold(kSameSurface_m, true);
  pcl::OrganizedConnectedComponentSegmentation<Point, pcl::Label> components(comparator);
  components.setInputCloud(cloud);
  pcl::PointCloud<pcl::Label> found;
  std::vector<pcl::PointIndices> groups;
  components.segment(found, groups);

  const pcl::PointIndices* best = nullptr;
  double largest = 0.0;
  for (const pcl::PointIndices& group : groups) {
    if (group.indices.size() < kFewest) continue;
    double area = 0.0;
    for (const int i : group.indices) {
      const double d = static_cast<double>(frame.depth_m[static_cast<std::size_t>(i)]);
      area += d * d;
    }
    if (area > largest) largest = area, best = &group;
  }
  if (best == nullptr) return std::nullopt;
  ExpertTarget target{hal::Plane{p.head<3>().cast<double>(), static_cast<double>(p[3])}.in(X_WC), {}};
  for (const int i : best->indices) target.pixels.push_back(static_cast<std::uint32_t>(i));
  std::sort(target.pixels.begin(), target.pixels.end());
  return target;
}

std::size_t octree_changes(const perception::OrganisedCloud& before, const perception::OrganisedCloud& now,
                           const hal::Aabb& box_W, double cell_m) {
  pcl::octree::OctreePointCloudChangeDetector<Point> octree(cell_m);
  octree.setInputCloud(cropped(before, box_W));
  octree.addPointsFromInputCloud();
  octree.switchBuffers();
  octree.setInputCloud(cropped(now, box_W));
  octree.addPointsFromInputCloud();
  pcl::Indices changed;
  octree.getPointIndicesFromNewVoxels(changed);
  return changed.size();
}

std::size_t cropped_differences(const perception::OrganisedCloud& before,
                                const perception::OrganisedCloud& now, const hal::Aabb& box_W,
                                double distance_m) {
  pcl::SegmentDifferences<Point> differences;
  differences.setInputCloud(thinned(cropped(now, box_W), kVoxel_m));
  differences.setTargetCloud(thinned(cropped(before, box_W), kVoxel_m));
  differences.setSearchMethod(std::make_shared<pcl::search::KdTree<Point>>());
  differences.setDistanceThreshold(distance_m * distance_m);
  Cloud changed;
  differences.segment(changed);
  return changed.size();
}

}  // namespace colift::bench
