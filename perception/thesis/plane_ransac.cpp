#include "perception/thesis/plane_ransac.hpp"

#include <pcl/console/print.h>
#include <pcl/point_types.h>
#include <pcl/sample_consensus/ransac.h>
#include <pcl/sample_consensus/sac_model_plane.h>

#include <pcl/sample_consensus/impl/ransac.hpp>  // see thesis_stages.cpp
#include <pcl/sample_consensus/impl/sac_model_plane.hpp>

#include <cmath>
#include <numeric>

namespace colift::perception {
namespace {

class SeededPlaneModel : public pcl::SampleConsensusModelPlane<pcl::PointXYZ> {
 public:
  SeededPlaneModel(const PointCloudConstPtr& cloud, const pcl::Indices& indices, int seed)
      : SampleConsensusModelPlane(cloud, indices) {
    rng_alg_.seed(static_cast<unsigned>(seed));
  }
};

/// What PCL would print (no sample found, no model found) is an ordinary answer here. Set once: it is one
/// level for all threads.
void silence_pcl() {
  static const bool done = [] {
    pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);
    return true;
  }();
  static_cast<void>(done);
}

}  // namespace

std::optional<PlaneFit> largest_plane(const PclCloud& cloud, const std::vector<int>& indices,
                                      const PlaneSearch& search) {
  if (indices.size() < 4) return std::nullopt;
  silence_pcl();

  const auto model = std::make_shared<SeededPlaneModel>(cloud.get(), indices, search.seed);
  pcl::RandomSampleConsensus<pcl::PointXYZ> ransac(model, search.distance_m);
  ransac.setMaxIterations(search.iterations);
  if (!ransac.computeModel()) return std::nullopt;

  pcl::Indices inliers;
  Eigen::VectorXf plane;
  ransac.getInliers(inliers);
  ransac.getModelCoefficients(plane);
  for (int refit = 0; refit < search.refits && inliers.size() >= 4; ++refit) {
    Eigen::VectorXf fitted;
    pcl::Indices fitted_inliers;
    model->optimizeModelCoefficients(inliers, plane, fitted);
    model->selectWithinDistance(fitted, search.distance_m, fitted_inliers);
    const bool settled = fitted_inliers == inliers;
    plane = fitted;
    inliers = std::move(fitted_inliers);
    if (settled) break;
  }

  PlaneFit fit;
  fit.inliers.assign(inliers.begin(), inliers.end());
  const double length = plane.head<3>().cast<double>().norm();
  if (fit.inliers.size() < 4 || !std::isfinite(length) || length == 0) return std::nullopt;
  fit.plane = {plane.head<3>().cast<double>() / length, static_cast<double>(plane[3]) / length};

  double squares = 0;
  for (const int i : fit.inliers) {
    const double h =
        fit.plane.height((*cloud.get())[static_cast<std::size_t>(i)].getVector3fMap().cast<double>());
    squares += h * h;
  }
  fit.rms_m = std::sqrt(squares / static_cast<double>(fit.inliers.size()));
  return fit;
}

std::optional<PlaneFit> largest_plane(const PclCloud& cloud, const PlaneSearch& search) {
  std::vector<int> all(cloud.size());
  std::iota(all.begin(), all.end(), 0);
  return largest_plane(cloud, all, search);
}

}  // namespace colift::perception
