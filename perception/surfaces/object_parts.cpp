#include "perception/surfaces/object_parts.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace colift::perception {

std::vector<Part> ObjectParts::connected(std::span<const std::uint32_t> pixels, std::size_t least) {
  std::vector<Part> parts;
  Part part;
  for (const std::uint32_t first : pixels) {
    if (number_[first] != kOpen) continue;
    part.assign(1, first);
    number_[first] = ++last_;
    for (std::size_t next = 0; next < part.size(); ++next) {
      const std::uint32_t k = part[next];
      for (const std::uint32_t o : neighbours(k))
        if (number_[o] == kOpen && no_jump(k, o)) number_[o] = last_, part.push_back(o);
    }
    if (part.size() >= least) parts.push_back(part);
  }
  return parts;
}

bool ObjectParts::inner(std::uint32_t pixel) const {
  for (const std::uint32_t o : neighbours(pixel))
    if (number_[o] != number_[pixel]) return false;
  return true;
}

Part ObjectParts::around(const Part& part, int margin) const {
  int left = std::numeric_limits<int>::max(), right = 0, top = left, bottom = 0;
  const auto place = [&](std::uint32_t k) {
    return std::pair{static_cast<int>(image_.column(k)), static_cast<int>(image_.row(k))};
  };
  for (const std::uint32_t k : part) {
    const auto [u, v] = place(k);
    left = std::min(left, u), right = std::max(right, u);
    top = std::min(top, v), bottom = std::max(bottom, v);
  }
  Part found;
  std::copy_if(image_.pixels.begin(), image_.pixels.end(), std::back_inserter(found), [&](std::uint32_t k) {
    const auto [u, v] = place(k);
    return image_.label[k] != ObjectImage::kCylinder && u >= left - margin && u <= right + margin &&
           v >= top - margin && v <= bottom + margin;
  });
  return found;
}

double ObjectParts::open_rim(const Part& part) const {
  double rim = 0, open = 0;
  for (const std::uint32_t k : part)
    for (const std::uint32_t o : neighbours(k)) {
      if (number_[o] == number_[k]) continue;
      rim += 1;
      open += image_.label[o] != ObjectImage::kOutside && no_jump(k, o);
    }
  return rim > 0 ? open / rim : 0.0;
}

// a jump of depth by so much is one of inverse depth by so much
bool ObjectParts::no_jump(std::uint32_t from, std::uint32_t to) const {
  const auto fixed = static_cast<float>(config_.jump_sigma * image_.noise.sigma2_per_m +
                                        config_.jump_steps * image_.noise.step2_per_m);
  const float q = image_.q[from];
  return std::abs(image_.q[to] - q) < fixed + static_cast<float>(config_.jump_base_m) * q * q;
}

}  // namespace colift::perception
