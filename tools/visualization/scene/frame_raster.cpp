#include "tools/visualization/scene/frame_raster.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "perception/noise_model.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/scene/frame_light.hpp"

namespace colift::picture {
namespace {

struct Rgb {
  float r = 0, g = 0, b = 0;
  Rgb() = default;
  Rgb(float red, float green, float blue) : r(red), g(green), b(blue) {}
  explicit Rgb(const Colour& c)
      : r(static_cast<float>(c.r)), g(static_cast<float>(c.g)), b(static_cast<float>(c.b)) {}
  [[nodiscard]] Rgb mixed(const Rgb& o, float t) const {
    return {r + t * (o.r - r), g + t * (o.g - g), b + t * (o.b - b)};
  }
  [[nodiscard]] Rgb times(float t) const { return {r * t, g * t, b * t}; }
};

using Mask = std::vector<std::uint8_t>;

Mask ground_mask(const perception::OrganisedCloud& cloud, const hal::Plane& plane) {
  const perception::NoiseModel noise;
  Mask mask(cloud.size(), 0);
  for (std::size_t i = 0; i < mask.size(); ++i)
    if (cloud.seen(i))
      mask[i] = std::abs(plane.height(cloud.point(i))) <
                0.008 + 3.0 * noise.sigma(static_cast<double>(cloud.depth_m[i]));
  return mask;
}

Mask pixel_mask(std::size_t size, const std::vector<std::uint32_t>& pixels) {
  Mask mask(size, 0);
  for (const std::uint32_t i : pixels)
    if (i < size) mask[i] = 1;
  return mask;
}

// Mean over 3 x 3, so that an outline drawn at one half does not show every stair.
std::vector<float> softened(const Mask& mask, int width, int height) {
  std::vector<float> soft(mask.size(), 0.0f);
  for (int v = 0; v < height; ++v)
    for (int u = 0; u < width; ++u) {
      int sum = 0;
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du) {
          const int x = std::clamp(u + du, 0, width - 1), y = std::clamp(v + dv, 0, height - 1);
          sum += mask[static_cast<std::size_t>(y * width + x)];
        }
      soft[static_cast<std::size_t>(v * width + u)] = static_cast<float>(sum) / 9.0f;
    }
  return soft;
}

// Where an output pixel falls between the four frame pixels around it.
struct Spot {
  std::size_t i00, i10, i01, i11;
  float s, t;

  template <class T>
  [[nodiscard]] float of(const std::vector<T>& values) const {
    const auto f = [&](std::size_t i) { return static_cast<float>(values[i]); };
    return (1 - t) * ((1 - s) * f(i00) + s * f(i10)) + t * ((1 - s) * f(i01) + s * f(i11));
  }
  [[nodiscard]] Rgb of(const std::vector<Rgb>& c) const {
    return c[i00].mixed(c[i10], s).mixed(c[i01].mixed(c[i11], s), t);
  }
};

Spot spot(double u, double v, int width, int height) {
  const double cu = std::clamp(u, 0.0, width - 1.0), cv = std::clamp(v, 0.0, height - 1.0);
  const int x = std::min(static_cast<int>(cu), std::max(0, width - 2));
  const int y = std::min(static_cast<int>(cv), std::max(0, height - 2));
  const std::size_t i = static_cast<std::size_t>(y * width + x), right = width > 1 ? 1 : 0;
  const std::size_t down = height > 1 ? static_cast<std::size_t>(width) : 0;
  return {i, i + right, i + down, i + down + right, static_cast<float>(cu - x), static_cast<float>(cv - y)};
}

// The lines of a grid on the ground, drawn exactly where the rays of the pixels meet the plane.
class Grid {
 public:
  Grid(const perception::OrganisedCloud& cloud, const hal::Plane& plane_W) : k_(cloud.intrinsics) {
    const hal::Plane plane = plane_W.in(cloud.X_WC.inverse());
    normal_ = plane.normal;
    offset_ = plane.offset;
    step_ = grid_step_m(plane.offset);
    // along the camera's view, so that lines run to one vanishing point in the middle of the image
    const hal::Vec3 ahead = hal::Vec3::UnitZ() - normal_.z() * normal_;
    e1_ = ahead.norm() > 0.05 ? ahead.normalized() : hal::tangents(normal_).first;
    e2_ = normal_.cross(e1_);
  }

  // How much of the pixel at (u, v) a line covers, 0 to 1; `pitch` is the size of an output pixel in frame
  // pixels.
  [[nodiscard]] float cover(double u, double v, double pitch) const {
    const auto here = on_plane(u, v), right = on_plane(u + pitch, v), down = on_plane(u, v + pitch);
    if (!std::isfinite(here[0]) || !std::isfinite(right[0]) || !std::isfinite(down[0])) return 0.0f;
    float cover = 0.0f;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double across = std::hypot(right[axis] - here[axis], down[axis] - here[axis]);
      const double spacing_px = step_ / std::max(1e-9, across);
      const double off_px =
          std::abs(here[axis] - step_ * std::round(here[axis] / step_)) / std::max(1e-9, across);
      const double fade = std::clamp((spacing_px - 5.0) / 10.0, 0.0, 1.0);
      cover = std::max(cover, static_cast<float>(fade * std::clamp(1.5 - off_px, 0.0, 1.0)));
    }
    return cover;
  }

 private:
  [[nodiscard]] std::array<double, 2> on_plane(double u, double v) const {
    const hal::Vec3 ray((u - k_.cx) / k_.fx, (v - k_.cy) / k_.fy, 1.0);
    const double t = -offset_ / normal_.dot(ray);
    if (!(t > 0.0)) return {std::nan(""), std::nan("")};
    return {t * ray.dot(e1_), t * ray.dot(e2_)};
  }

  hal::CameraIntrinsics k_;
  hal::Vec3 normal_, e1_, e2_;
  double offset_ = 0.0, step_ = 0.25;
};

// Colours of the frame's own pixels.
std::vector<Rgb> tinted(const ScenePicture& what, const Mask& ground, const Mask& target,
                        const Mask& changed) {
  const perception::OrganisedCloud& cloud = *what.cloud;
  const std::vector<float> light = light_of(cloud);
  const bool coloured = what.rgb && what.rgb->size() == 3 * cloud.size();
  const Rgb missing(kMissing), neutral(0.86f, 0.87f, 0.89f);
  std::vector<Rgb> colours(cloud.size(), missing);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    if (!(light[i] == light[i])) continue;
    Rgb albedo = neutral;
    float shade = light[i];
    if (coloured) {
      const std::uint8_t* c = what.rgb->data() + 3 * i;
      const Rgb seen(c[0] / 255.0f, c[1] / 255.0f, c[2] / 255.0f);
      const float grey = 0.3f * seen.r + 0.59f * seen.g + 0.11f * seen.b;
      albedo = seen.mixed({grey, grey, grey}, 0.3f).mixed(neutral, 0.22f);
      shade = 0.45f + 0.65f * shade;  // the photograph has its own light
    }
    const float strength = coloured ? 0.45f : 0.7f;
    if (changed[i])
      albedo = albedo.mixed(Rgb(rgb(0x7DB8E8)), strength + 0.15f);
    else if (target[i])
      albedo = albedo.mixed(Rgb(kTarget), strength);
    else if (ground[i])
      albedo = albedo.mixed(Rgb(kGround), strength);
    colours[i] = albedo.times(shade);
  }
  return colours;
}

// How much of an output pixel the outline of a mask covers, 0 to 1.
float outline_cover(const std::vector<float>& soft, double u, double v, double pitch, double half_width_px,
                    int width, int height) {
  const Spot at = spot(u, v, width, height);
  const float low = std::min({soft[at.i00], soft[at.i10], soft[at.i01], soft[at.i11]});
  const float high = std::max({soft[at.i00], soft[at.i10], soft[at.i01], soft[at.i11]});
  if (low > 0.95f || high < 0.05f) return 0.0f;
  const float here = at.of(soft);
  const double dx = spot(u + pitch, v, width, height).of(soft) - spot(u - pitch, v, width, height).of(soft);
  const double dy = spot(u, v + pitch, width, height).of(soft) - spot(u, v - pitch, width, height).of(soft);
  const double slope = std::max(0.02, 0.5 * std::hypot(dx, dy));
  return static_cast<float>(std::clamp(half_width_px + 0.5 - std::abs(here - 0.5) / slope, 0.0, 1.0));
}

}  // namespace

double grid_step_m(double camera_height_m) {
  if (camera_height_m < 0.15) return 0.02;
  if (camera_height_m < 0.45) return 0.05;
  if (camera_height_m < 0.6) return 0.10;
  return camera_height_m < 2.5 ? 0.25 : 0.5;
}

std::vector<std::uint8_t> target_mask(const perception::OrganisedCloud& cloud,
                                      const perception::Target& target) {
  if (!target.pixels.empty()) return pixel_mask(cloud.size(), target.pixels);
  // the thesis method's points are the centres of voxels: each covers the pixels of about 1 cm, if they are
  // as near
  constexpr double kReach_m = 0.006, kDepth_m = 0.03;
  std::vector<std::uint8_t> mask(cloud.size(), 0);
  for (const Eigen::Vector3f& p : target.points) {
    const auto at = cloud.project(p.cast<double>());
    if (!(at.depth_m > 0.05) || !cloud.contains(at.u, at.v)) continue;
    const int radius =
        std::clamp(static_cast<int>(std::lround(kReach_m * cloud.intrinsics.fx / at.depth_m)), 0, 8);
    const int u0 = static_cast<int>(std::lround(at.u)), v0 = static_cast<int>(std::lround(at.v));
    for (int v = std::max(0, v0 - radius); v <= std::min(cloud.height() - 1, v0 + radius); ++v)
      for (int u = std::max(0, u0 - radius); u <= std::min(cloud.width() - 1, u0 + radius); ++u) {
        const auto i = static_cast<std::size_t>(v * cloud.width() + u);
        if (cloud.seen(i) && std::abs(static_cast<double>(cloud.depth_m[i]) - at.depth_m) < kDepth_m)
          mask[i] = 1;
      }
  }
  return mask;
}

std::vector<std::uint8_t> frame_raster(const ScenePicture& what, int scale) {
  const perception::OrganisedCloud& cloud = *what.cloud;
  const int width = cloud.width(), height = cloud.height();
  const auto* ground = what.scene && what.scene->ground ? &what.scene->ground->plane : nullptr;
  const auto* object = what.scene && what.scene->target ? &*what.scene->target : nullptr;
  const Mask none(cloud.size(), 0);
  const Mask on_ground = ground ? ground_mask(cloud, *ground) : none;
  const Mask on_target = object ? target_mask(cloud, *object) : none;
  const Mask changed = pixel_mask(cloud.size(), what.partner_pixels);
  Mask plain_ground = on_ground;
  for (std::size_t i = 0; i < plain_ground.size(); ++i)
    if (on_target[i] || changed[i]) plain_ground[i] = 0;

  const std::vector<Rgb> colours = tinted(what, on_ground, on_target, changed);
  const std::vector<float> target_soft = softened(on_target, width, height);
  const std::vector<float> changed_soft = softened(changed, width, height);
  const std::optional<Grid> grid = ground ? std::optional<Grid>(Grid(cloud, *ground)) : std::nullopt;
  const Rgb white(kWhite), rim(kTargetRim), touched(rgb(0x0B4F86));
  const double pitch = 1.0 / scale;

  std::vector<std::uint8_t> out(3 * cloud.size() * static_cast<std::size_t>(scale * scale));
  std::size_t to = 0;
  for (int y = 0; y < scale * height; ++y)
    for (int x = 0; x < scale * width; ++x) {
      const double u = (x + 0.5) * pitch - 0.5, v = (y + 0.5) * pitch - 0.5;
      const Spot at = spot(u, v, width, height);
      Rgb c = at.of(colours);
      const float ground_here = grid ? at.of(plain_ground) : 0.0f;
      if (ground_here > 0.3f) c = c.mixed(white, 0.55f * ground_here * grid->cover(u, v, pitch));
      if (object) c = c.mixed(rim, 0.9f * outline_cover(target_soft, u, v, pitch, 1.1, width, height));
      if (!what.partner_pixels.empty())
        c = c.mixed(touched, 0.8f * outline_cover(changed_soft, u, v, pitch, 0.8, width, height));
      for (const float channel : {c.r, c.g, c.b})
        out[to++] = static_cast<std::uint8_t>(std::lround(255.0f * std::clamp(channel, 0.0f, 1.0f)));
    }
  return out;
}

}  // namespace colift::picture
