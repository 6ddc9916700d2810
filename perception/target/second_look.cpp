#include "perception/target/second_look.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "hal/types/units.hpp"

namespace colift::perception {
namespace {

// pixels whose depth changes faster across the window than that of a surface seen at the steepest angle
// allowed
std::vector<std::uint8_t> steep_pixels(const OrganisedCloud& cloud, const std::vector<std::uint8_t>& mask,
                                       const NoiseModel& noise, const SecondLookConfig& c) {
  const int w = cloud.width(), h = cloud.height(), k = c.window_px;
  const double tangent = std::tan(std::min(c.max_slope_deg, 89.9) * hal::kRadPerDeg);
  const auto slope_u = static_cast<float>(2 * k * tangent / cloud.intrinsics.fx);
  const auto slope_v = static_cast<float>(2 * k * tangent / cloud.intrinsics.fy);
  const auto noise0 = static_cast<float>(c.slope_sigma * noise.sigma0_m);
  const auto noise2 = static_cast<float>(c.slope_sigma * noise.sigma2_per_m);
  std::vector<std::uint8_t> out(mask.size(), 0);
  const float* d = cloud.depth_m.data();
  for (int v = 0; v < h; ++v) {
    const std::size_t row = static_cast<std::size_t>(v) * static_cast<std::size_t>(w);
    if (!std::memchr(mask.data() + row, 1, static_cast<std::size_t>(w))) continue;
    for (int u = 0; u < w; ++u) {
      const std::size_t i = row + static_cast<std::size_t>(u);
      if (!mask[i]) continue;
      const float z = d[i], slack = noise0 + noise2 * z * z;
      bool steep = false;  // a missing pixel compares false
      if (u >= k && u + k < w) {
        const auto s = static_cast<std::size_t>(k);
        steep |= std::abs(d[i + s] - d[i - s]) > slope_u * z + slack;
      }
      if (v >= k && v + k < h) {
        const auto s = static_cast<std::size_t>(k) * static_cast<std::size_t>(w);
        steep |= std::abs(d[i + s] - d[i - s]) > slope_v * z + slack;
      }
      out[i] = steep ? 1 : 0;
    }
  }
  return out;
}

// gives pixels of `free` to the region of a neighbour on the same surface, in at most `rounds` steps
void grow(std::vector<std::int32_t>& label, std::vector<std::uint32_t> free, const OrganisedCloud& cloud,
          const DepthJump& jump, int rounds) {
  const int w = cloud.width(), h = cloud.height();
  const auto stride = static_cast<std::size_t>(w);
  std::vector<std::pair<std::uint32_t, std::int32_t>> joined;
  for (int round = 0; round < rounds && !free.empty(); ++round) {
    joined.clear();
    for (const std::uint32_t i : free) {
      const int u = static_cast<int>(i % stride), v = static_cast<int>(i / stride);
      float nearest = std::numeric_limits<float>::infinity();
      std::int32_t best = Components::kNone;
      const auto consider = [&](std::size_t n) {
        const float away = std::abs(cloud.depth_m[n] - cloud.depth_m[i]);
        if (label[n] == Components::kNone || away >= nearest) return;
        if (!jump.same_surface(cloud.depth_m[n], cloud.depth_m[i])) return;
        nearest = away;
        best = label[n];
      };
      if (u > 0) consider(i - 1);
      if (u + 1 < w) consider(i + 1);
      if (v > 0) consider(i - stride);
      if (v + 1 < h) consider(i + stride);
      if (best != Components::kNone) joined.emplace_back(i, best);
    }
    for (const auto& [i, l] : joined) label[i] = l;
    std::erase_if(free, [&](std::uint32_t i) { return label[i] != Components::kNone; });
  }
}

Components components_of(const std::vector<std::int32_t>& label, std::size_t regions, int width, int height) {
  Components out;
  out.pixels.assign(regions, 0);
  for (int v = 0; v < height; ++v) {
    const std::int32_t* row = label.data() + static_cast<std::size_t>(v) * static_cast<std::size_t>(width);
    for (int u = 0; u < width;) {
      const std::int32_t l = row[u];
      int last = u;
      while (last + 1 < width && row[last + 1] == l) ++last;
      if (l != Components::kNone) {
        out.runs.push_back({v, u, last, l});
        out.pixels[static_cast<std::size_t>(l)] += static_cast<std::uint32_t>(last - u + 1);
      }
      u = last + 1;
    }
  }
  return out;
}

}  // namespace

SecondLook look_again(const OrganisedCloud& cloud, const std::vector<std::int32_t>& first,
                      const std::vector<Fragment>& objects, const Ground& ground, const ImageBorder& border,
                      const DepthJump& jump, const NoiseModel& noise, const FragmentConfig& fragments,
                      const SecondLookConfig& config) {
  const int w = cloud.width(), h = cloud.height();
  constexpr std::size_t kNoObject = std::numeric_limits<std::size_t>::max();
  std::int32_t last_label = Components::kNone;
  for (const Fragment& f : objects) last_label = std::max(last_label, f.labels.back());
  std::vector<std::size_t> object_of(static_cast<std::size_t>(last_label + 1), kNoObject);
  for (std::size_t k = 0; k < objects.size(); ++k)
    for (const std::int32_t l : objects[k].labels) object_of[static_cast<std::size_t>(l)] = k;
  std::vector<std::uint8_t> mask(cloud.size(), 0);
  for (std::size_t i = 0; i < mask.size(); ++i)
    mask[i] =
        first[i] >= 0 && first[i] <= last_label && object_of[static_cast<std::size_t>(first[i])] != kNoObject
            ? 1
            : 0;
  const std::vector<std::uint8_t> steep = steep_pixels(cloud, mask, noise, config);
  std::vector<std::uint32_t> ramp;
  for (std::size_t i = 0; i < mask.size(); ++i) {
    if (!steep[i]) continue;
    mask[i] = 0;
    ramp.push_back(static_cast<std::uint32_t>(i));
  }
  SecondLook out;

  // half a jump: a ramp is shared by both of its ends, and its middle belongs to neither
  const DepthJump half{0.5f * jump.base_m, 0.5f * jump.growth_per_m};
  const Components cores = connected_components(cloud.depth_m, mask, w, h, half);
  std::vector<std::int32_t> label = cores.labels(w, h);
  for (std::int32_t& l : label)  // a speckle between two ramps is no place to grow from
    if (l != Components::kNone &&
        cores.pixels[static_cast<std::size_t>(l)] < static_cast<std::uint32_t>(fragments.min_pixels))
      l = Components::kNone;
  grow(label, std::move(ramp), cloud, half, config.window_px);
  out.components = components_of(label, cores.pixels.size(), w, h);

  FragmentConfig joints = fragments;
  // what a ramp parts stays apart where both touch, and a carton before a wall is no leg of it
  joints.hole_gap_m = 0.0;
  joints.max_small_fraction = config.max_small_fraction;
  std::vector<Fragment> parts =
      join_fragments(describe_fragments(cloud, out.components, ground, border, fragments), cloud,
                     out.components, ground, noise, joints);
  std::erase_if(parts,
                [&](const Fragment& f) { return f.pixels < static_cast<std::size_t>(config.min_pixels); });
  // where each part begins tells the object that it comes from
  std::vector<std::size_t> whole_of(out.components.pixels.size(), kNoObject);
  for (const Components::Run& run : out.components.runs) {
    std::size_t& whole = whole_of[static_cast<std::size_t>(run.label)];
    if (whole == kNoObject)
      whole = object_of[static_cast<std::size_t>(first[static_cast<std::size_t>(run.row * w + run.first)])];
  }
  for (const Fragment& part : parts)
    out.whole.push_back(whole_of[static_cast<std::size_t>(part.labels.front())]);
  out.parts = std::move(parts);
  return out;
}

}  // namespace colift::perception
