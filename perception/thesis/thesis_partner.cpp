#include "perception/thesis/thesis_partner.hpp"

#include <fmt/format.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/segment_differences.h>

#include <algorithm>
#include <cmath>

#include "perception/thesis/thesis_stages.hpp"

namespace colift::perception {

PclCloud thesis_cloud(const OrganisedCloud& frame, const ThesisConfig& config) {
  return voxel_grid(pass_through(points_in_depth_range(frame, config), config), config);
}

PclCloud changed_points(const PclCloud& reference, const PclCloud& current, const ThesisConfig& config) {
  if (current.size() == 0) return current;
  pcl::SegmentDifferences<pcl::PointXYZ> differences;
  differences.setInputCloud(current.get());
  differences.setTargetCloud(reference.get());
  differences.setDistanceThreshold(config.partner_difference_m *
                                   config.partner_difference_m);  // compared squared
  auto changed = std::make_shared<PclCloud::Points>();
  differences.segment(*changed);
  return PclCloud{std::move(changed)};
}

std::optional<PartnerGrasp> thesis_partner(const PclCloud& reference, const PclCloud& current,
                                           std::span<const Eigen::Vector3f> object,
                                           const ThesisConfig& config, std::string* because) {
  const auto answer = [&](std::string why) {
    if (because) *because = std::move(why);
  };
  const PclCloud solid{object};
  if (solid.size() == 0) {
    answer("no partner's grasp: there is no object to hold");
    return std::nullopt;
  }
  const PclCloud changed = changed_points(reference, current, config);
  const auto wanted = static_cast<std::size_t>(config.partner_points);
  if (changed.size() < wanted) {
    answer(fmt::format("no partner's grasp: {} points changed by more than {:.1f} cm, a grasp needs {}",
                       changed.size(), 100 * config.partner_difference_m, wanted));
    return std::nullopt;
  }

  pcl::search::KdTree<pcl::PointXYZ> tree(false);
  tree.setInputCloud(solid.get());
  std::vector<std::pair<float, std::size_t>> near;  // squared distance to the object, changed point
  near.reserve(changed.size());
  pcl::Indices index(1);
  std::vector<float> squared(1);
  for (std::size_t i = 0; i < changed.size(); ++i) {
    tree.nearestKSearch((*changed.get())[i], 1, index, squared);
    near.emplace_back(squared[0], i);
  }
  std::nth_element(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(wanted - 1), near.end());
  near.resize(wanted);
  std::sort(near.begin(), near.end());

  PartnerGrasp grasp;
  double distance = 0;
  const auto point = [&](std::size_t i) -> Vec3 {
    return (*changed.get())[i].getVector3fMap().cast<double>();
  };
  for (const auto& [d2, i] : near) {
    grasp.position += point(i);
    distance += std::sqrt(static_cast<double>(d2));
  }
  grasp.position /= static_cast<double>(wanted);
  distance /= static_cast<double>(wanted);
  if (distance > config.partner_reach_m) {
    answer(
        fmt::format("no partner's grasp: {} points changed, but the {} nearest are {:.1f} cm from the object "
                    "on average (limit {:.1f} cm)",
                    changed.size(), wanted, 100 * distance, 100 * config.partner_reach_m));
    return std::nullopt;
  }
  for (const auto& [d2, i] : near) {
    const Vec3 off = point(i) - grasp.position;
    grasp.covariance += off * off.transpose();
  }
  grasp.covariance /= static_cast<double>(wanted);
  grasp.points = wanted;
  answer(fmt::format("the {} nearest of {} changed points lie {:.1f} cm from the object on average", wanted,
                     changed.size(), 100 * distance));
  return grasp;
}

}  // namespace colift::perception
