#include "perception/ground/block_planes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace colift::perception {
namespace {

// every second row carries the same plane at half the cost
constexpr int kRowStride = 2;
constexpr int kSamples = kBlockPixels * kBlockPixels / kRowStride;

struct Moments {
  float n = 0, depth = 0;
  float x = 0, y = 0, z = 0, xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
};

// sums relative to a point of the block, so that single precision keeps tenths of a millimetre
Moments moments_of(const OrganisedCloud& cloud, int u0, int v0, const Eigen::Vector3f& origin) {
  using Lane = Eigen::Array4f;
  Lane n = Lane::Zero(), depth = n, sx = n, sy = n, sz = n, xx = n, xy = n, xz = n, yy = n, yz = n, zz = n;
  const float ox = origin.x(), oy = origin.y(), oz = origin.z();
  std::array<float, kBlockPixels> is_seen{}, d{}, x{}, y{}, z{};
  for (int row = 0; row < kBlockPixels; row += kRowStride) {
    const std::size_t first = static_cast<std::size_t>(v0 + row) * static_cast<std::size_t>(cloud.width()) +
                              static_cast<std::size_t>(u0);
    const float* px = cloud.x.data() + first;
    const float* py = cloud.y.data() + first;
    const float* pz = cloud.z.data() + first;
    const float* pd = cloud.depth_m.data() + first;
    for (std::size_t i = 0; i < kBlockPixels; ++i) {
      const bool seen = pd[i] == pd[i];
      is_seen[i] = seen ? 1.0f : 0.0f;
      d[i] = seen ? pd[i] : 0.0f;
      x[i] = seen ? px[i] - ox : 0.0f;
      y[i] = seen ? py[i] - oy : 0.0f;
      z[i] = seen ? pz[i] - oz : 0.0f;
    }
    for (std::size_t i = 0; i < kBlockPixels; i += 4) {
      const Lane lx(x.data() + i), ly(y.data() + i), lz(z.data() + i);
      n += Lane(is_seen.data() + i);
      depth += Lane(d.data() + i);
      sx += lx;
      sy += ly;
      sz += lz;
      xx += lx * lx;
      xy += lx * ly;
      xz += lx * lz;
      yy += ly * ly;
      yz += ly * lz;
      zz += lz * lz;
    }
  }
  return {n.sum(),  depth.sum(), sx.sum(), sy.sum(), sz.sum(), xx.sum(),
          xy.sum(), xz.sum(),    yy.sum(), yz.sum(), zz.sum()};
}

}  // namespace

std::vector<BlockPlane> fit_block_planes(const OrganisedCloud& cloud, const NoiseModel& noise,
                                         const BlockPlaneConfig& config) {
  const auto min_seen = static_cast<float>(config.min_seen_fraction);
  const auto max_misfit = static_cast<float>(config.max_misfit_sigma);
  const auto min_spread = static_cast<float>(config.min_spread_ratio);
  std::vector<BlockPlane> planes;
  const int columns = cloud.width() / kBlockPixels;
  const int rows = cloud.height() / kBlockPixels;
  planes.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  const Eigen::Vector3f eye = cloud.X_WC.translation().cast<float>();
  const float pixel_area = static_cast<float>(1.0 / (cloud.intrinsics.fx * cloud.intrinsics.fy));

  for (int bv = 0; bv < rows; ++bv) {
    for (int bu = 0; bu < columns; ++bu) {
      const int u0 = bu * kBlockPixels, v0 = bv * kBlockPixels;
      const std::size_t middle =
          static_cast<std::size_t>(v0 + kBlockPixels / 2) * static_cast<std::size_t>(cloud.width()) +
          static_cast<std::size_t>(u0 + kBlockPixels / 2);
      if (!cloud.seen(middle)) continue;
      const Eigen::Vector3f origin(cloud.x[middle], cloud.y[middle], cloud.z[middle]);
      const Moments m = moments_of(cloud, u0, v0, origin);
      if (m.n < min_seen * kSamples) continue;

      const Eigen::Vector3f mean(m.x / m.n, m.y / m.n, m.z / m.n);
      Eigen::Matrix3f cov;
      cov << m.xx, m.xy, m.xz, m.xy, m.yy, m.yz, m.xz, m.yz, m.zz;
      cov = cov / m.n - mean * mean.transpose();
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3f> solver;
      solver.computeDirect(cov);

      BlockPlane plane;
      plane.center = origin + mean;
      plane.normal = solver.eigenvectors().col(0);
      const Eigen::Vector3f to_eye = (eye - plane.center).normalized();
      if (plane.normal.dot(to_eye) < 0) plane.normal = -plane.normal;
      plane.depth_m = m.depth / m.n;
      plane.u = bu;
      plane.v = bv;

      // noise along the ray shows in the plane's residual by the cosine of incidence; quantisation adds its
      // own part, about 1/sqrt(12) of a step: the standard deviation of an even distribution over one. The
      // bound of the cosine keeps areas of grazing blocks finite.
      const float cosine = std::max(plane.normal.dot(to_eye), 0.05f);
      const float sigma = static_cast<float>(noise.sigma(plane.depth_m) + 0.3 * noise.step(plane.depth_m));
      const float rms = std::sqrt(std::max(solver.eigenvalues()(0), 0.0f));
      if (rms > max_misfit * sigma) continue;
      // a block whose points spread as little sideways as along the normal has no plane
      if (solver.eigenvalues()(1) < min_spread * std::max(solver.eigenvalues()(0), 1e-10f)) continue;
      plane.area_m2 = m.n * kRowStride * pixel_area * plane.depth_m * plane.depth_m / cosine;
      planes.push_back(plane);
    }
  }
  return planes;
}

}  // namespace colift::perception
