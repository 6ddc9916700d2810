#include "perception/target/regions/fragment_gaps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace colift::perception {

FragmentGaps::FragmentGaps(const OrganisedCloud& cloud, const Components& components,
                           const std::vector<std::int32_t>& slot, std::size_t n)
    : n_(n), square_(n * n, std::numeric_limits<float>::infinity()), behind_(square_) {
  // the image is walked row by row; what each column saw last is kept beside it
  const std::size_t w = static_cast<std::size_t>(cloud.width());
  std::vector<std::int32_t> slot_above(w, -1), row_above(w, 0);
  int row = -1;
  std::int32_t last_slot = -1;
  std::size_t last = 0;
  for (const Components::Run& run : components.runs) {
    const std::int32_t s = slot[static_cast<std::size_t>(run.label)];
    if (s < 0) continue;
    const std::size_t line = static_cast<std::size_t>(run.row) * w;
    if (run.row != row) last_slot = -1;
    row = run.row;
    if (last_slot >= 0 && last_slot != s)
      near(cloud, s, line + static_cast<std::size_t>(run.first), last_slot, last);
    last_slot = s;
    last = line + static_cast<std::size_t>(run.last);
    for (std::size_t u = static_cast<std::size_t>(run.first); u <= static_cast<std::size_t>(run.last); ++u) {
      if (slot_above[u] != s) {
        if (slot_above[u] >= 0)
          near(cloud, s, line + u, slot_above[u], static_cast<std::size_t>(row_above[u]) * w + u);
        slot_above[u] = s;
      }
      row_above[u] = run.row;
    }
  }
}

double FragmentGaps::between(std::size_t a, std::size_t b) const {
  return std::sqrt(square_[a * n_ + b]);
}

double FragmentGaps::behind(std::size_t a, std::size_t b) const {
  return std::sqrt(behind_[a * n_ + b]);
}

void FragmentGaps::join(std::size_t a, std::size_t b) {
  for (std::size_t k = 0; k < n_; ++k) {
    const float d = std::min(square_[a * n_ + k], square_[b * n_ + k]);
    square_[a * n_ + k] = square_[k * n_ + a] = d;
    behind_[a * n_ + k] = std::min(behind_[a * n_ + k], behind_[b * n_ + k]);
    behind_[k * n_ + a] = std::min(behind_[k * n_ + a], behind_[k * n_ + b]);
  }
}

// two pixels that follow one another, and the fragments that they belong to
void FragmentGaps::near(const OrganisedCloud& cloud, std::int32_t slot_a, std::size_t a, std::int32_t slot_b,
                        std::size_t b) {
  const float dx = cloud.x[a] - cloud.x[b], dy = cloud.y[a] - cloud.y[b], dz = cloud.z[a] - cloud.z[b];
  const float d = dx * dx + dy * dy + dz * dz;
  const std::size_t i = static_cast<std::size_t>(slot_a), k = static_cast<std::size_t>(slot_b);
  if (d < square_[i * n_ + k]) square_[i * n_ + k] = square_[k * n_ + i] = d;
  float& further = cloud.depth_m[a] > cloud.depth_m[b] ? behind_[i * n_ + k] : behind_[k * n_ + i];
  further = std::min(further, d);
}

}  // namespace colift::perception
