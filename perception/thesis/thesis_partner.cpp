#include "perception/thesis/thesis_partner.hpp"

#include <fmt/format.h>
#include <pcl/point_types.h>
#include <pcl/search/kdtree.h>
#include <pcl/segmentation/segment_differences.h>

#include <pcl/segmentation/impl/segment_differences.hpp>  // see thesis_stages.cpp

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>

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

ReferenceCloud::ReferenceCloud(const OrganisedCloud& before, std::span<const Eigen::Vector3f> object,
                               const std::optional<Ground>& ground, const ThesisConfig& config) {
  if (config.partner_reference == "scene") {
    before_ = thesis_cloud(before, config);
    return;
  }
  before_ = PclCloud{object};
  if (ground) ground_ = ground->plane;
}

PclCloud ReferenceCloud::changed(const PclCloud& current, const ThesisConfig& config) const {
  if (!ground_) return changed_points(before_, current, config);
  auto above = std::make_shared<PclCloud::Points>();
  for (const pcl::PointXYZ& p : *current.get())
    if (ground_->height(p.getVector3fMap().cast<double>()) > config.ground_distance_m) above->push_back(p);
  return changed_points(before_, PclCloud{std::move(above)}, config);
}

std::optional<PartnerGrasp> thesis_grasp(const PclCloud& changed, std::span<const Eigen::Vector3f> object,
                                         const ThesisConfig& config, std::string* reason) {
  const auto answer = [&](std::string why) {
    if (reason) *reason = std::move(why);
  };
  const PclCloud solid{object};
  if (solid.size() == 0) {
    answer("no partner's grasp: there is no object to hold");
    return std::nullopt;
  }
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

std::vector<Eigen::Vector3f> thesis_person(const PclCloud& changed, const PartnerGrasp& grasp,
                                           const ThesisConfig& config) {
  using Cell = std::array<int, 3>;
  const auto cell_m = static_cast<float>(config.person_cell_m);
  const auto few = static_cast<std::size_t>(config.person_min_points);
  std::map<Cell, std::vector<Eigen::Vector3f>> cells;
  for (const Eigen::Vector3f& p : changed.to_vector()) {
    const Eigen::Vector3f at = (p / cell_m).array().floor();
    cells[{static_cast<int>(at.x()), static_cast<int>(at.y()), static_cast<int>(at.z())}].push_back(p);
  }
  const double reach = cell_m + 2.0 * std::sqrt(std::max(0.0, grasp.covariance.trace()));
  const auto at_grasp = [&](const std::vector<Eigen::Vector3f>& points) {
    return std::any_of(points.begin(), points.end(), [&](const Eigen::Vector3f& p) {
      return (p.cast<double>() - grasp.position).norm() < reach;
    });
  };
  std::vector<Cell> open;
  for (const auto& [cell, points] : cells)
    if (points.size() >= few && at_grasp(points)) open.push_back(cell);
  std::set<Cell> person(open.begin(), open.end());
  std::vector<Eigen::Vector3f> out;
  while (!open.empty()) {
    const Cell c = open.back();
    open.pop_back();
    const auto& points = cells.at(c);
    out.insert(out.end(), points.begin(), points.end());
    for (int n = 0; n < 27; ++n) {
      const Cell next{c[0] + n % 3 - 1, c[1] + n / 3 % 3 - 1, c[2] + n / 9 - 1};
      const auto there = cells.find(next);
      if (there == cells.end() || there->second.size() < few || !person.insert(next).second) continue;
      open.push_back(next);
    }
  }
  return out;
}

std::optional<PartnerGrasp> thesis_partner(const PclCloud& reference, const PclCloud& current,
                                           std::span<const Eigen::Vector3f> object,
                                           const ThesisConfig& config, std::string* reason) {
  return thesis_grasp(changed_points(reference, current, config), object, config, reason);
}

}  // namespace colift::perception
