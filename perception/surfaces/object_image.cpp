#include "perception/surfaces/object_image.hpp"

#include <algorithm>

namespace colift::perception {
namespace {

struct Bounds {
  int u_min, v_min, width, height;
};

int whole_cells(int pixels) {
  return (pixels + ObjectImage::kCell - 1) / ObjectImage::kCell * ObjectImage::kCell;
}

Bounds bounds_of(const std::vector<std::uint32_t>& pixels, int image_width) {
  if (pixels.empty()) return {0, 0, ObjectImage::kCell, ObjectImage::kCell};
  int u_min = image_width, u_max = 0;
  for (const std::uint32_t p : pixels) {
    const int u = static_cast<int>(p) % image_width;
    u_min = std::min(u_min, u);
    u_max = std::max(u_max, u);
  }
  // ascending order: the first pixel has the first row
  const int v_min = static_cast<int>(pixels.front()) / image_width;
  const int v_max = static_cast<int>(pixels.back()) / image_width;
  return {u_min - 1, v_min - 1, whole_cells(u_max - u_min + 3), whole_cells(v_max - v_min + 3)};
}

}  // namespace

ObjectImage::ObjectImage(const OrganisedCloud& cloud, const std::vector<std::uint32_t>& target_pixels,
                         const NoiseModel& noise_model, double unevenness_m)
    : geometry(cloud.intrinsics, cloud.X_WC, 0, 0), noise(noise_model), tolerance_m(unevenness_m) {
  const Bounds b = bounds_of(target_pixels, cloud.width());
  u0 = b.u_min, v0 = b.v_min, width = b.width, height = b.height;
  geometry = ImageGeometry(cloud.intrinsics, cloud.X_WC, u0, v0);
  const std::size_t n = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  q.assign(n, 0.0f);
  label.assign(n, kOutside);
  pixels.reserve(target_pixels.size());
  for (const std::uint32_t p : target_pixels) {
    if (!cloud.seen(p) || !(cloud.depth_m[p] > 0.0f)) continue;
    const int u = static_cast<int>(p) % cloud.width(), v = static_cast<int>(p) / cloud.width();
    const std::size_t i = at(u - u0, v - v0);
    q[i] = 1.0f / cloud.depth_m[p];
    label[i] = kFree;
    pixels.push_back(static_cast<std::uint32_t>(i));
  }
}

}  // namespace colift::perception
