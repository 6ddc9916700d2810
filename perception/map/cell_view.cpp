#include "perception/map/cell_view.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

constexpr float kNearest_m = 0.05f;  // guards the projection against cells beside and behind the camera

/// How often each cell was hit, counted up to 2.
void count_hits(const CellGrid& grid, const OrganisedCloud& cloud, std::span<const std::uint32_t> not_scene,
                double max_range_m, std::vector<CellView>& view, const CellViewConfig& config) {
  std::vector<std::uint8_t> hits(view.size(), 0);
  const double far_m = cloud.intrinsics.fx * grid.cell_m / config.two_hit_pixels;
  const auto per_m = static_cast<float>(1.0 / grid.cell_m);
  const Eigen::Vector3f origin = grid.origin.cast<float>();
  const Eigen::Vector3f eye = cloud.X_WC.translation().cast<float>();
  const auto range2 = static_cast<float>(max_range_m * max_range_m);
  auto skip = not_scene.begin();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    while (skip != not_scene.end() && *skip < i) ++skip;
    if (skip != not_scene.end() && *skip == i) continue;
    if (!cloud.seen(i)) continue;
    const Eigen::Vector3f p(cloud.x[i], cloud.y[i], cloud.z[i]);
    if ((p - eye).squaredNorm() > range2) continue;
    const Eigen::Vector3f at = (p - origin) * per_m;
    if (!(at.minCoeff() >= 0.0f)) continue;
    const int x = static_cast<int>(std::min(at.x(), 1e6f)), y = static_cast<int>(std::min(at.y(), 1e6f)),
              z = static_cast<int>(std::min(at.z(), 1e6f));
    if (!grid.contains(x, y, z)) continue;
    const std::size_t cell = grid.index(x, y, z);
    if (++hits[cell] >= 2 || cloud.depth_m[i] > far_m) {
      hits[cell] = 2;
      view[cell] = CellView::Hit;
    }
  }
}

/// One row of cells along x, seen in the image.
struct RowOfCells {
  std::vector<float> u, v, depth;
  int begin = 0, end = 0;  ///< Of the cells that may be in the image.
  explicit RowOfCells(std::size_t n) : u(n), v(n), depth(n) {}

  /// The image is a convex cone, so what a row has in it is in one piece. A cell more on either side stands
  /// for rounding: whoever asks looks at the pixel.
  void clip(const hal::CameraIntrinsics& k, const Eigen::Vector3f& first_C, const Eigen::Vector3f& step_C) {
    const auto n = static_cast<double>(u.size());
    double from = 0.0, to = n;
    const auto keep = [&](const hal::Vec3& inward) {  // where inward . p >= 0
      const double here = inward.dot(first_C.cast<double>()), slope = inward.dot(step_C.cast<double>());
      if (slope > 0.0) from = std::max(from, -here / slope);
      if (slope < 0.0) to = std::min(to, -here / slope);
      if (slope == 0.0 && here < 0.0) to = -2.0;
    };
    const double left = k.cx + 0.5, top = k.cy + 0.5;
    keep({k.fx, 0.0, left});
    keep({-k.fx, 0.0, k.width - left});
    keep({0.0, k.fy, top});
    keep({0.0, -k.fy, k.height - top});
    begin = static_cast<int>(std::clamp(std::floor(from) - 1.0, 0.0, n));
    end = static_cast<int>(std::clamp(std::ceil(to) + 2.0, 0.0, n));
  }

  void project(const hal::CameraIntrinsics& k, const Eigen::Vector3f& first_C,
               const Eigen::Vector3f& step_C) {
    clip(k, first_C, step_C);
    const auto fx = static_cast<float>(k.fx), fy = static_cast<float>(k.fy);
    // half a pixel more: the cast below rounds down
    const auto cx = static_cast<float>(k.cx) + 0.5f, cy = static_cast<float>(k.cy) + 0.5f;
    const float x = first_C.x(), y = first_C.y(), z = first_C.z();
    const float dx = step_C.x(), dy = step_C.y(), dz = step_C.z();
    float *pu = u.data(), *pv = v.data(), *pd = depth.data();
    for (int i = begin; i < end; ++i) {
      const auto t = static_cast<float>(i);
      const float d = z + t * dz, inverse = 1.0f / d;
      pd[i] = d;
      pu[i] = fx * (x + t * dx) * inverse + cx;
      pv[i] = fy * (y + t * dy) * inverse + cy;
    }
  }
};

}  // namespace

void view_cells(const CellGrid& grid, const OrganisedCloud& cloud, std::span<const std::uint32_t> not_scene,
                double max_range_m, std::vector<CellView>& view, const CellViewConfig& config) {
  view.assign(static_cast<std::size_t>(grid.nx) * static_cast<std::size_t>(grid.ny) *
                  static_cast<std::size_t>(grid.nz),
              CellView::OutOfView);
  if (cloud.size() == 0) return;
  const hal::Pose X_CW = cloud.X_WC.inverse();
  const Eigen::Vector3f step = (grid.cell_m * X_CW.linear().col(0)).cast<float>();
  const auto beyond = static_cast<float>(config.free_beyond_cells) * static_cast<float>(grid.cell_m);
  const float half_cell_px = static_cast<float>(0.5 * grid.cell_m * cloud.intrinsics.fx);
  const int width = cloud.width(), height = cloud.height();
  const float right = static_cast<float>(width), low = static_cast<float>(height);
  const float* depth = cloud.depth_m.data();
  RowOfCells row(static_cast<std::size_t>(grid.nx));
  for (int iz = 0; iz < grid.nz; ++iz) {
    for (int iy = 0; iy < grid.ny; ++iy) {
      row.project(cloud.intrinsics, (X_CW * grid.middle(0, iy, iz)).cast<float>(), step);
      CellView* out = view.data() + grid.index(0, iy, iz);
      for (int ix = row.begin; ix < row.end; ++ix) {
        const auto i = static_cast<std::size_t>(ix);
        const float d = row.depth[i], u = row.u[i], v = row.v[i];
        if (!(d > kNearest_m && u >= 0.0f && v >= 0.0f && u < right && v < low)) continue;
        const int pu = static_cast<int>(u), pv = static_cast<int>(v);
        const float measured = depth[pv * width + pu];
        if (measured != measured) continue;
        if (measured <= d + beyond) {
          out[ix] = CellView::Behind;
          continue;
        }
        // rays through the middles of its four sides have to go on too, where they measured anything
        const int h = static_cast<int>(half_cell_px / d);
        const float* const at = depth + pv * width;
        bool through = true;
        if (h > 0) {
          through = !(at[std::max(pu - h, 0)] <= d + beyond) &&
                    !(at[std::min(pu + h, width - 1)] <= d + beyond) &&
                    !(depth[std::max(pv - h, 0) * width + pu] <= d + beyond) &&
                    !(depth[std::min(pv + h, height - 1) * width + pu] <= d + beyond);
        }
        out[ix] = through ? CellView::Through : CellView::Behind;
      }
    }
  }
  count_hits(grid, cloud, not_scene, max_range_m, view, config);
}

}  // namespace colift::perception
