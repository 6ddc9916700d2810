#include "perception/target/regions/thickness.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace colift::perception {

double median_thickness(const OrganisedCloud& cloud, const Components& components, const Fragment& object) {
  const int width = cloud.width(), height = cloud.height();
  const std::vector<std::uint8_t> own = own_pixels(cloud, components, object);
  const auto at = [&](int u, int v) { return static_cast<std::size_t>(v * width + u); };
  std::vector<int> along_row(cloud.size(), 0);
  for (int v = 0; v < height; ++v) {
    for (int u = 0; u < width;) {
      int end = u;
      while (end < width && own[at(end, v)]) ++end;
      std::fill(along_row.begin() + static_cast<std::ptrdiff_t>(at(u, v)),
                along_row.begin() + static_cast<std::ptrdiff_t>(at(u, v)) + (end - u), end - u);
      u = std::max(end, u + 1);
    }
  }
  std::vector<float> thickness;
  thickness.reserve(object.pixels);
  for (int u = 0; u < width; ++u) {
    for (int v = 0; v < height;) {
      int end = v;
      while (end < height && own[at(u, end)]) ++end;
      for (int k = v; k < end; ++k) {
        const double across = along_row[at(u, k)] / cloud.intrinsics.fx;
        const double down = (end - v) / cloud.intrinsics.fy;
        thickness.push_back(cloud.depth_m[at(u, k)] * static_cast<float>(std::min(across, down)));
      }
      v = std::max(end, v + 1);
    }
  }
  if (thickness.empty()) return 0.0;
  const auto middle = thickness.begin() + static_cast<std::ptrdiff_t>(thickness.size() / 2);
  std::nth_element(thickness.begin(), middle, thickness.end());
  return static_cast<double>(*middle);
}

}  // namespace colift::perception
