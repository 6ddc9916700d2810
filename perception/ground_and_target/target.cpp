#include "perception/ground_and_target/target.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>

#include "perception/ground_and_target/image_border.hpp"

namespace colift::perception {
namespace {

// fractions of a side that the view cuts, from which on the result mentions them
constexpr double kReportedTopCut = 0.1, kReportedSideCut = 0.02;

DepthJump jump_of(const NoiseModel& noise, const TargetConfig& c) {
  return {static_cast<float>(c.jump_base_m + c.jump_sigma * noise.sigma0_m),
          static_cast<float>(c.jump_sigma * noise.sigma2_per_m + c.jump_steps * noise.step2_per_m)};
}

// pixels that stand above the ground by more than its noise; missing pixels compare false
std::vector<std::uint8_t> raised_pixels(const OrganisedCloud& cloud, const Ground& ground,
                                        const NoiseModel& noise, const TargetConfig& c) {
  const Eigen::Vector3f n = ground.plane.normal.cast<float>();
  const float offset = static_cast<float>(ground.plane.offset);
  const float eye_height = static_cast<float>(std::max(1e-3, ground.plane.height(cloud.X_WC.translation())));
  // a floor that is uneven, or looks so through its lens, asks for more room
  const float base = static_cast<float>(std::max(c.clearance_m, c.clearance_rms * ground.rms_m));
  const float k0 = static_cast<float>(c.clearance_sigma * noise.sigma0_m);
  const float k2 = static_cast<float>(c.clearance_sigma * noise.sigma2_per_m);
  std::vector<std::uint8_t> mask(cloud.size());
  const Eigen::Index w = cloud.width();
  Eigen::ArrayXf above(w);
  using Row = Eigen::Map<const Eigen::ArrayXf>;
  for (std::size_t row = 0; row < cloud.size(); row += static_cast<std::size_t>(w)) {
    const Row d(cloud.depth_m.data() + row, w), x(cloud.x.data() + row, w), y(cloud.y.data() + row, w),
        z(cloud.z.data() + row, w);
    // depth noise enters the height by the slope of the ray, at most one
    above = (n.x() * x + n.y() * y + n.z() * z + offset) -
            (base + (k0 + k2 * d * d) * (eye_height / d).min(1.0f));
    std::uint8_t* out = mask.data() + row;
    const float* a = above.data();
    for (Eigen::Index u = 0; u < w; ++u) out[u] = a[u] > 0.0f ? 1 : 0;
  }
  return mask;
}

// 1 where pixels a[i] and b[i] are both in the mask and on one surface
void link(const float* a, const float* b, const std::uint8_t* in_a, const std::uint8_t* in_b,
          const DepthJump& jump, int count, std::uint8_t* out) {
  const float base = jump.base_m, growth = jump.growth_per_m;
  for (int i = 0; i < count; ++i) {
    const float near = a[i] < b[i] ? a[i] : b[i];
    const std::uint8_t same = std::abs(a[i] - b[i]) <= base + growth * near * near ? 1 : 0;
    out[i] = static_cast<std::uint8_t>(same & in_a[i] & in_b[i]);
  }
}

// takes away pixels with few neighbours at their own depth: flying pixels between an edge and its background,
// speckle
void clear_flying_pixels(const OrganisedCloud& cloud, const DepthJump& jump, int min_neighbours,
                         std::vector<std::uint8_t>& mask) {
  const int w = cloud.width(), h = cloud.height();
  const std::size_t stride = static_cast<std::size_t>(w);
  // Links between a row and the one below, one column of margin on both sides: straight down, down right,
  // down left. Each serves both of its rows; `above` is the row before.
  using Row = std::vector<std::uint8_t>;
  Row down(stride + 2), right_down(stride + 2), left_down(stride + 2), beside(stride + 2);
  Row down_above = down, right_down_above = down, left_down_above = down;
  Row before(stride);
  for (int v = 0; v < h; ++v) {
    const float* d = cloud.depth_m.data() + static_cast<std::size_t>(v) * stride;
    std::uint8_t* m = mask.data() + static_cast<std::size_t>(v) * stride;
    if (!std::memchr(m, 1, stride)) {
      for (Row* row : {&down_above, &right_down_above, &left_down_above})
        std::fill(row->begin(), row->end(), std::uint8_t{0});
      continue;
    }
    std::copy_n(m, w, before.begin());
    const std::uint8_t* b = before.data();
    link(d, d + 1, b, b + 1, jump, w - 1, beside.data() + 1);
    if (v + 1 < h) {
      const std::uint8_t* next = m + stride;
      link(d, d + stride, b, next, jump, w, down.data() + 1);
      link(d, d + stride + 1, b, next + 1, jump, w - 1, right_down.data() + 1);
      link(d + 1, d + stride, b + 1, next, jump, w - 1, left_down.data() + 2);
    } else {
      for (Row* row : {&down, &right_down, &left_down}) std::fill(row->begin(), row->end(), std::uint8_t{0});
    }
    const std::uint8_t *s = beside.data(), *n = down.data(), *se = right_down.data(), *sw = left_down.data(),
                       *na = down_above.data(), *nw = right_down_above.data(), *ne = left_down_above.data();
    for (int u = 0; u < w; ++u) {
      const int neighbours =
          s[u] + s[u + 1] + n[u + 1] + se[u + 1] + sw[u + 1] + na[u + 1] + nw[u] + ne[u + 2];
      m[u] = static_cast<std::uint8_t>(b[u] & (neighbours >= min_neighbours ? 1 : 0));
    }
    down.swap(down_above);
    right_down.swap(right_down_above);
    left_down.swap(left_down_above);
  }
}

struct Cut {
  double fraction = 0.0;
  const char* side = "";
};

// the side of the view that takes the largest part of the object's extent along it
Cut lateral_cut(const Fragment& f) {
  const double rows = f.v_max - f.v_min + 1, columns = f.u_max - f.u_min + 1;
  Cut cut{f.cut_left / (2 * rows), "left"};
  if (f.cut_right / (2 * rows) > cut.fraction) cut = {f.cut_right / (2 * rows), "right"};
  if (f.cut_bottom / (2 * columns) > cut.fraction) cut = {f.cut_bottom / (2 * columns), "bottom"};
  return cut;
}

// part of its upper side that the view cuts; its footprint may still be whole
double top_cut(const Fragment& f) {
  return f.cut_top / (2.0 * (f.u_max - f.u_min + 1));
}

// what speaks against a fragment as target; nothing for a free-standing object
std::optional<RejectedObject> objection(const Fragment& f, const TargetConfig& c) {
  using Kind = RejectedObject::Kind;
  const auto reject = [&](Kind kind, std::string why) {
    return RejectedObject{kind, f.box.center(), f.pixels, std::move(why)};
  };
  if (f.area_m2 < c.min_area_m2 || f.pixels < static_cast<std::size_t>(c.min_pixels))
    return reject(Kind::Small,
                  fmt::format("it shows {:.0f} cm2 in {} pixels, {:.0f} cm2 and {} pixels are needed",
                              1e4 * f.area_m2, f.pixels, 1e4 * c.min_area_m2, c.min_pixels));
  if (f.max_height_m - std::max(0.0, f.min_height_m) < c.min_thickness_m &&
      f.min_height_m < 2 * c.min_thickness_m)
    return reject(Kind::Flat, fmt::format("it rises {:.0f} mm over the ground, {:.0f} are needed",
                                          1e3 * f.max_height_m, 1e3 * c.min_thickness_m));
  if (f.mean_depth_m > c.max_range_m)
    return reject(Kind::Far,
                  fmt::format("it is {:.1f} m away, the limit is {:.1f} m", f.mean_depth_m, c.max_range_m));
  // wider than high is a desk with things on it, not a person
  if (f.max_height_m > c.max_height_m && footprint_span(f) < f.max_height_m)
    return reject(
        Kind::Person,
        fmt::format("it is {:.2f} m tall, a person or furniture that is not carried (limit {:.2f} m)",
                    f.max_height_m, c.max_height_m));
  const Cut cut = lateral_cut(f);
  if (cut.fraction + c.top_cut_weight * top_cut(f) > c.max_cut)
    return reject(
        Kind::Cut,
        fmt::format(
            "its {1} side leaves the view by {0:.0f} %, so it is not known to stand free (limit {2:.0f} %)",
            100 * cut.fraction, cut.side, 100 * c.max_cut));
  if (top_cut(f) > c.max_person_top_cut && f.max_height_m > footprint_span(f))
    return reject(Kind::Person, fmt::format("it leaves the view at the top, {:.2f} m above the ground and "
                                            "taller than wide: a person or furniture that is not carried",
                                            f.max_height_m));
  return std::nullopt;
}

// visible area, less where the view cuts it: half an object in view is a worse bet than a smaller whole one
double rank(const Fragment& f) {
  return f.area_m2 * (1.0 - lateral_cut(f).fraction);
}

Target make_target(const Fragment& f, const OrganisedCloud& cloud, const Components& components,
                   const Ground& ground, const std::vector<std::uint8_t>& on_wall, const DepthJump& jump,
                   const TargetConfig& c) {
  Target t;
  t.pixels.reserve(f.pixels);
  std::vector<std::uint8_t> own_label(components.pixels.size(), 0);
  for (const std::int32_t l : f.labels) own_label[static_cast<std::size_t>(l)] = 1;
  for (const Components::Run& run : components.runs) {
    if (!own_label[static_cast<std::size_t>(run.label)]) continue;
    const std::uint32_t row = static_cast<std::uint32_t>(run.row) * static_cast<std::uint32_t>(cloud.width());
    const std::size_t begin = t.pixels.size();
    t.pixels.resize(begin + static_cast<std::size_t>(run.last - run.first + 1));
    std::iota(t.pixels.begin() + static_cast<std::ptrdiff_t>(begin), t.pixels.end(),
              row + static_cast<std::uint32_t>(run.first));
  }
  const std::vector<std::uint32_t> inside =
      enclosed_pixels(cloud, ground, t.pixels, on_wall, jump, c.min_neighbours, c.enclosed);
  const auto own = static_cast<std::ptrdiff_t>(t.pixels.size());
  t.pixels.insert(t.pixels.end(), inside.begin(), inside.end());
  std::inplace_merge(t.pixels.begin(), t.pixels.begin() + own, t.pixels.end());

  t.points.resize(t.pixels.size());
  const float *x = cloud.x.data(), *y = cloud.y.data(), *z = cloud.z.data();
  Eigen::AlignedBox3f box;
  for (std::size_t k = 0; k < t.pixels.size(); ++k) {
    const std::uint32_t i = t.pixels[k];
    t.points[k] = {x[i], y[i], z[i]};
    box.extend(t.points[k]);
  }
  t.aabb = Aabb(box.min().cast<double>(), box.max().cast<double>());
  t.obb = box_on_plane(t.points, ground.plane, c.box);
  t.shape = t.obb;
  t.cog = t.obb.center;
  return t;
}

double distance(const Fragment& f, const OrganisedCloud& cloud, const Components& components, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const Components::Run& run : components.runs) {
    if (!std::binary_search(f.labels.begin(), f.labels.end(), run.label)) continue;
    const std::size_t row = static_cast<std::size_t>(run.row) * static_cast<std::size_t>(cloud.width());
    for (int u = run.first; u <= run.last; ++u)
      best = std::min(best, (cloud.point(row + static_cast<std::size_t>(u)) - p).squaredNorm());
  }
  return std::sqrt(best);
}

}  // namespace

TargetResult find_target(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                         const Ground& ground, const NoiseModel& noise, const TargetConfig& c,
                         const std::optional<Vec3>& at_W) {
  const ImageBorder border = find_image_border(cloud);
  const DepthJump jump = jump_of(noise, c);
  std::vector<std::uint8_t> mask = raised_pixels(cloud, ground, noise, c);
  const std::vector<Wall> walls = find_walls(cloud, blocks, ground, border, noise, c.walls);
  std::vector<std::uint8_t> on_wall = mask;
  const std::size_t wall_pixels = clear_walls(cloud, walls, noise, c.walls, mask);
  std::transform(on_wall.begin(), on_wall.end(), mask.begin(), on_wall.begin(), std::minus<>());
  clear_flying_pixels(cloud, jump, c.min_neighbours, mask);
  const Components components =
      connected_components(cloud.depth_m, mask, cloud.width(), cloud.height(), jump);
  const std::vector<Fragment> objects =
      join_fragments(describe_fragments(cloud, components, ground, border, c.fragments), cloud, components,
                     noise, c.fragments);

  TargetResult result;
  if (!walls.empty()) {
    result.rejected.push_back({RejectedObject::Kind::Wall, walls.front().plane.foot(cloud.X_WC.translation()),
                               wall_pixels,
                               fmt::format("{} upright plane(s) wider than {:.1f} m are walls", walls.size(),
                                           c.walls.min_width_m)});
  }
  const Fragment* chosen = nullptr;
  const Fragment* second = nullptr;
  if (at_W) {
    double best = std::numeric_limits<double>::infinity();
    for (const Fragment& f : objects) {
      const double d = distance(f, cloud, components, *at_W);
      if (d < best) std::tie(best, chosen) = std::pair(d, &f);
    }
    if (chosen)
      result.reason = fmt::format("the object {:.0f} mm from the given point", 1000 * best);
    else
      result.reason = "there is no object on the ground";
  } else {
    for (const Fragment& f : objects) {
      if (auto no = objection(f, c)) {
        result.rejected.push_back(std::move(*no));
        continue;
      }
      if (!chosen || rank(f) > rank(*chosen)) {
        second = chosen;
        chosen = &f;
      } else if (!second || rank(f) > rank(*second)) {
        second = &f;
      }
    }
    for (const Fragment& f : objects) {
      if (&f == chosen || objection(f, c)) continue;
      result.rejected.push_back({RejectedObject::Kind::Lesser, f.box.center(), f.pixels,
                                 fmt::format("it shows {:.0f} cm2, less than the target", 1e4 * rank(f))});
    }
    if (chosen) {
      result.reason =
          fmt::format("the largest free-standing object: {:.0f} cm2 visible at {:.2f} m, {:.2f} m high",
                      1e4 * chosen->area_m2, chosen->mean_depth_m, chosen->max_height_m);
      if (second) result.reason += fmt::format("; the next one shows {:.0f} cm2", 1e4 * rank(*second));
      const double top = top_cut(*chosen);
      if (top > kReportedTopCut)
        result.reason +=
            fmt::format("; the view cuts {:.0f} % of its upper side, so its height is not known", 100 * top);
      const Cut cut = lateral_cut(*chosen);
      if (cut.fraction > kReportedSideCut)
        result.reason +=
            fmt::format("; {:.0f} % of its {} side touch the rim of the view", 100 * cut.fraction, cut.side);
    } else if (result.rejected.empty()) {
      result.reason = "no target: there is no object on the ground";
    } else {
      std::stable_sort(result.rejected.begin(), result.rejected.end(),
                       [](const auto& a, const auto& b) { return a.pixels > b.pixels; });
      result.reason = fmt::format("no target: none of {} objects is free-standing; the largest: {}",
                                  result.rejected.size(), result.rejected.front().reason);
    }
  }
  std::stable_sort(result.rejected.begin(), result.rejected.end(),
                   [](const auto& a, const auto& b) { return a.pixels > b.pixels; });
  if (chosen) {
    result.target = make_target(*chosen, cloud, components, ground, on_wall, jump, c);
    result.target->reason = result.reason;
  }
  return result;
}

}  // namespace colift::perception
