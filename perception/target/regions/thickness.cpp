#include "perception/target/regions/thickness.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace colift::perception {
namespace {

constexpr int kBridged_px = 3;  // as wide as the holes that sensors leave in a surface

struct PixelThickness {
  std::size_t pixel;
  float thickness_m;
};

// Calls each(first, end) with the runs of own pixels among n that are `stride` apart in the image; places of
// the run are first <= k < end.
template <class Each>
void for_each_run(const OrganisedCloud& cloud, const std::vector<std::uint8_t>& own, const DepthJump* jump,
                  std::size_t at, std::size_t stride, int n, Each each) {
  int first = -1, last = -1;
  const auto close = [&] {
    if (first >= 0) each(first, last + 1);
    first = -1;
  };
  for (int k = 0; k < n; ++k) {
    const std::size_t i = at + static_cast<std::size_t>(k) * stride;
    if (!own[i]) {
      const bool bridged = jump && !cloud.seen(i) && k - last <= kBridged_px;
      if (!bridged) close();
      continue;
    }
    const std::size_t before = at + static_cast<std::size_t>(std::max(last, 0)) * stride;
    if (first >= 0 && jump && !jump->same_surface(cloud.depth_m[before], cloud.depth_m[i])) close();
    if (first < 0) first = k;
    last = k;
  }
  close();
}

// at each pixel of the object
std::vector<PixelThickness> thicknesses(const OrganisedCloud& cloud, const Components& components,
                                        const Fragment& object, const DepthJump* jump) {
  const auto width = static_cast<std::size_t>(cloud.width());
  const std::vector<std::uint8_t> own = own_pixels(cloud, components, object);
  std::vector<int> along_row(cloud.size(), 0);
  for (int v = object.v_min; v <= object.v_max; ++v) {
    const std::size_t row = static_cast<std::size_t>(v) * width;
    for_each_run(cloud, own, jump, row, 1, cloud.width(), [&](int first, int end) {
      std::fill(along_row.begin() + static_cast<std::ptrdiff_t>(row) + first,
                along_row.begin() + static_cast<std::ptrdiff_t>(row) + end, end - first);
    });
  }
  std::vector<PixelThickness> all;
  all.reserve(object.pixels);
  for (int u = object.u_min; u <= object.u_max; ++u)
    for_each_run(cloud, own, jump, static_cast<std::size_t>(u), width, cloud.height(),
                 [&](int first, int end) {
                   const double down = (end - first) / cloud.intrinsics.fy;
                   for (int k = first; k < end; ++k) {
                     const std::size_t i = static_cast<std::size_t>(k) * width + static_cast<std::size_t>(u);
                     if (!own[i]) continue;  // bridged
                     const double across = along_row[i] / cloud.intrinsics.fx;
                     all.push_back({i, cloud.depth_m[i] * static_cast<float>(std::min(across, down))});
                   }
                 });
  return all;
}

double median_of(std::vector<PixelThickness>& all) {
  if (all.empty()) return 0.0;
  const auto middle = all.begin() + static_cast<std::ptrdiff_t>(all.size() / 2);
  std::nth_element(all.begin(), middle, all.end(), [](const PixelThickness& a, const PixelThickness& b) {
    return a.thickness_m < b.thickness_m;
  });
  return static_cast<double>(middle->thickness_m);
}

}  // namespace

double median_thickness(const OrganisedCloud& cloud, const Components& components, const Fragment& object) {
  std::vector<PixelThickness> all = thicknesses(cloud, components, object, nullptr);
  return median_of(all);
}

double median_thickness(const OrganisedCloud& cloud, const Components& components, const Fragment& object,
                        const DepthJump& jump, const Silhouette& silhouette,
                        const Silhouette::Window& window) {
  std::vector<PixelThickness> all = thicknesses(cloud, components, object, &jump);
  std::erase_if(all,
                [&](const PixelThickness& t) { return !silhouette.contains(window, cloud.point(t.pixel)); });
  return median_of(all);
}

}  // namespace colift::perception
