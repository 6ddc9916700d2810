#include "perception/thesis/thesis_stages.hpp"

// The filters are instantiated here: PCL's libraries of them carry instances for every type of point, and a
// program that links them takes 0.1 s longer to start.
#include <pcl/common/common.h>
#include <pcl/filters/passthrough.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/filters/voxel_grid.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/extract_clusters.h>

#include <pcl/filters/impl/filter.hpp>
#include <pcl/filters/impl/filter_indices.hpp>
#include <pcl/filters/impl/passthrough.hpp>
#include <pcl/filters/impl/statistical_outlier_removal.hpp>
#include <pcl/filters/impl/voxel_grid.hpp>
#include <pcl/segmentation/impl/extract_clusters.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include "perception/thesis/plane_ransac.hpp"

namespace colift::perception {
namespace {

using Points = PclCloud::Points;
using PointsPtr = std::shared_ptr<const Points>;

/// Voxels that PCL would number for the box around the points, along each axis.
Eigen::Vector3d voxels_along(const Points& points, double leaf_m, Eigen::Vector3d* first = nullptr) {
  pcl::PointXYZ low, high;
  pcl::getMinMax3D(points, low, high);
  const Eigen::Vector3d from = (low.getVector3fMap().cast<double>() / leaf_m).array().floor();
  const Eigen::Vector3d to = (high.getVector3fMap().cast<double>() / leaf_m).array().floor();
  if (first) *first = from;
  return to - from + Eigen::Vector3d::Ones();
}

void add_voxels(const PointsPtr& points, float leaf_m, Points& out) {
  constexpr double kMostVoxels = 2.0e9;  // PCL numbers voxels with an int
  Eigen::Vector3d first;
  const Eigen::Vector3d voxels = voxels_along(*points, leaf_m, &first);
  if (voxels.prod() > kMostVoxels) {
    Eigen::Index axis = 0;
    voxels.maxCoeff(&axis);
    const double cut = first[axis] + std::floor(voxels[axis] / 2);
    auto below = std::make_shared<Points>(), above = std::make_shared<Points>();
    for (const pcl::PointXYZ& p : *points)
      (std::floor(static_cast<double>(p.data[axis]) / static_cast<double>(leaf_m)) < cut ? below : above)
          ->push_back(p);
    add_voxels(below, leaf_m, out);
    add_voxels(above, leaf_m, out);
    return;
  }
  pcl::VoxelGrid<pcl::PointXYZ> grid;
  grid.setInputCloud(points);
  grid.setLeafSize(leaf_m, leaf_m, leaf_m);
  Points part;
  grid.filter(part);
  out += part;
}

}  // namespace

PclCloud points_in_depth_range(const OrganisedCloud& frame, const ThesisConfig& config) {
  auto out = std::make_shared<Points>();
  out->reserve(frame.size());
  const auto near = static_cast<float>(config.depth_min_m), far = static_cast<float>(config.depth_max_m);
  for (std::size_t i = 0; i < frame.size(); ++i)  // a NaN fails both comparisons
    if (frame.depth_m[i] >= near && frame.depth_m[i] <= far)
      out->push_back(pcl::PointXYZ{frame.x[i], frame.y[i], frame.z[i]});
  return PclCloud{std::move(out)};
}

PclCloud pass_through(const PclCloud& cloud, const ThesisConfig& config) {
  constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
  PointsPtr in = cloud.get();
  for (int axis = 0; axis < 3; ++axis) {
    pcl::PassThrough<pcl::PointXYZ> filter;
    filter.setInputCloud(in);
    filter.setFilterFieldName(kAxes[static_cast<std::size_t>(axis)]);
    filter.setFilterLimits(static_cast<float>(config.crop_min_m[axis]),
                           static_cast<float>(config.crop_max_m[axis]));
    auto out = std::make_shared<Points>();
    filter.filter(*out);
    in = std::move(out);
  }
  return PclCloud{in};
}

PclCloud voxel_grid(const PclCloud& cloud, const ThesisConfig& config) {
  if (config.voxel_leaf_m <= 0 || cloud.size() == 0) return cloud;
  auto out = std::make_shared<Points>();
  add_voxels(cloud.get(), static_cast<float>(config.voxel_leaf_m), *out);
  return PclCloud{std::move(out)};
}

std::optional<GroundSplit> split_at_ground(const PclCloud& cloud, const Vec3& eye_W,
                                           const ThesisConfig& config) {
  const auto fit = largest_plane(
      cloud, {config.ground_distance_m, config.ground_iterations, config.seed, config.ground_refits});
  if (!fit) return std::nullopt;

  GroundSplit split;
  split.ground = {fit->plane, fit->inliers.size(), fit->rms_m};
  Plane& plane = split.ground.plane;
  if (plane.height(eye_W) < 0) plane = {-plane.normal, -plane.offset};

  // what is below the ground is a mirror image or a hole in the calibration, never the object
  auto above = std::make_shared<Points>();
  for (const pcl::PointXYZ& p : *cloud.get())
    if (plane.height(p.getVector3fMap().cast<double>()) > config.ground_distance_m) above->push_back(p);
  split.above = PclCloud{std::move(above)};
  return split;
}

PclCloud without_outliers(const PclCloud& cloud, const ThesisConfig& config) {
  // PCL 1.13 reads past its neighbour list when a cloud has no more points than neighbours are asked for
  const int neighbours = std::min(config.outlier_neighbours, static_cast<int>(cloud.size()) - 1);
  if (neighbours < 1) return cloud;
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud.get());
  filter.setMeanK(neighbours);
  filter.setStddevMulThresh(config.outlier_sigmas);
  auto out = std::make_shared<Points>();
  filter.filter(*out);
  return PclCloud{std::move(out)};
}

std::vector<PclCloud> euclidean_clusters(const PclCloud& cloud, const ThesisConfig& config) {
  if (cloud.size() == 0) return {};
  auto tree = std::make_shared<pcl::search::KdTree<pcl::PointXYZ>>();
  tree->setInputCloud(cloud.get());
  pcl::EuclideanClusterExtraction<pcl::PointXYZ> extraction;
  extraction.setClusterTolerance(config.cluster_tolerance_m);
  extraction.setMinClusterSize(config.cluster_min_points);
  extraction.setSearchMethod(tree);
  extraction.setInputCloud(cloud.get());
  std::vector<pcl::PointIndices> found;
  extraction.extract(found);

  // PCL's order among equal sizes is left open by its sort; the first point decides here
  std::sort(found.begin(), found.end(), [](const pcl::PointIndices& a, const pcl::PointIndices& b) {
    return a.indices.size() != b.indices.size() ? a.indices.size() > b.indices.size()
                                                : a.indices.front() < b.indices.front();
  });
  std::vector<PclCloud> clusters;
  for (const pcl::PointIndices& indices : found)
    clusters.emplace_back(std::make_shared<const Points>(*cloud.get(), indices.indices));
  return clusters;
}

}  // namespace colift::perception
