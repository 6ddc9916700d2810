// The picture of a scene of solids. The simulator's ray caster finds each pixel's surface, and the shadows
// from many directions of the light (SolidLights); here they become colours, with more rays where surfaces
// meet.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sim_hal/synthetic/ray_caster.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/scene/solid_light.hpp"
#include "tools/visualization/scene/solid_scene.hpp"

namespace colift::picture {
namespace {

using sim_hal::Shape;

constexpr float kGridStep = 0.5f, kGridHalfWidth = 0.003f;  // lines on the ground (m)
constexpr std::int16_t kSky = -1;

float linear_of(double srgb) {
  return static_cast<float>(srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4));
}

Vec3f linear_of(const Colour& c) {
  return {linear_of(c.r), linear_of(c.g), linear_of(c.b)};
}

std::uint8_t byte_of(float linear) {
  const float c = std::clamp(linear, 0.0f, 1.0f);
  const float s = c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1.0f / 2.4f) - 0.055f;
  return static_cast<std::uint8_t>(std::lround(255.0f * s));
}

struct Hit {
  std::int16_t shape = kSky;
  float distance = 0.0f;  // along the view (m)
  Vec3f p = Vec3f::Zero(), normal = Vec3f::Zero();
};

// Outward normal of a shape at a point of its surface (W): that of the face which the point is farthest out
// of.
Vec3f normal_at(const Shape& shape, const Vec3f& p_W) {
  const Vec3 p = shape.X_WS.inverse() * p_W.cast<double>();
  Vec3 n = Vec3::UnitZ();
  const auto radial = [&] { return Vec3(p.x(), p.y(), 0.0).normalized(); };
  const double end = std::copysign(1.0, p.z());
  switch (shape.kind) {
    case Shape::Kind::Box: {
      Eigen::Index axis = 0;
      (p.cwiseAbs() - 0.5 * shape.size).maxCoeff(&axis);
      n = std::copysign(1.0, p[axis]) * Vec3::Unit(axis);
      break;
    }
    case Shape::Kind::Cylinder:
      n = std::abs(p.z()) - 0.5 * shape.size.y() > p.head<2>().norm() - shape.size.x()
              ? Vec3(end * Vec3::UnitZ())
              : radial();
      break;
    case Shape::Kind::Capsule:
      n = (p - std::clamp(p.z(), -0.5 * shape.size.y(), 0.5 * shape.size.y()) * Vec3::UnitZ()).normalized();
      break;
    case Shape::Kind::Sphere:
      n = p.normalized();
      break;
    case Shape::Kind::HalfSpace:
      break;
  }
  return (shape.X_WS.linear() * n).cast<float>();
}

class Painter {
 public:
  Painter(const SolidScene& scene, const SolidView& view)
      : width_(view.width),
        height_(view.height),
        X_WC_(view.X_WC()),
        intrinsics_(view.intrinsics()),
        film_(view.film),
        ground_middle_(view.target.cast<float>()) {
    for (const Solid& solid : scene.solids) {
      if (!solid.X_WS.matrix().allFinite() || !solid.size.allFinite()) continue;
      world_.shapes.push_back(solid);
      colours_.push_back(linear_of(solid.colour.value_or(colour_of(solid.role))));
    }
    ahead_ = X_WC_.linear().col(2).cast<float>();
    const Vec3f towards_eye = -ahead_;
    // from high on the left of the eye, whichever way it looks
    const Vec3f left = -X_WC_.linear().col(0).cast<float>();
    key_ = (0.55f * towards_eye + 0.5f * left + 1.0f * Vec3f::UnitZ()).normalized();
    fill_ = towards_eye;
  }

  std::vector<std::uint8_t> picture() {
    const SolidLights lights(world_, key_, film_);
    const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    hits_.resize(pixels);
    light_.resize(pixels);
    const sim_hal::Rendering seen = cast(0.0, 0.0);
    std::vector<SurfacePoint> row;
    std::vector<std::size_t> pixel;
    for (int y = 0; y < height_; ++y) {
      row.clear();
      pixel.clear();
      for (int x = 0; x < width_; ++x) {
        Hit& at = hits_[index(x, y)];
        at = hit(seen, x, y);
        if (at.shape == kSky || fade(at) >= 1.0f) continue;
        row.push_back({at.p, at.normal});
        pixel.push_back(index(x, y));
      }
      const std::vector<SolidLight> lit = lights.at(row);
      for (std::size_t i = 0; i < lit.size(); ++i) light_[pixel[i]] = lit[i];
    }
    std::vector<Vec3f> colours(pixels);
    std::vector<std::pair<int, int>> edges;
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const std::size_t i = index(x, y);
        if (is_edge(x, y)) {
          edges.emplace_back(x, y);
          colours[i].setZero();
        } else {
          colours[i] = colour(hits_[i], light_[i]);
        }
      }
    smooth(edges, colours);
    std::vector<std::uint8_t> bytes;
    bytes.reserve(3 * pixels);
    for (const Vec3f& c : colours)
      for (int i = 0; i < 3; ++i) bytes.push_back(byte_of(c[i]));
    return bytes;
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  // Size of a pixel on a surface that faces the eye (m).
  [[nodiscard]] float pixel_m(const Hit& hit) const {
    return hit.distance / static_cast<float>(intrinsics_.fy);
  }

  // The scene through points of the pixels, off their centres (px).
  [[nodiscard]] sim_hal::Rendering cast(double off_x, double off_y) const {
    hal::CameraIntrinsics shifted = intrinsics_;
    shifted.cx -= off_x;
    shifted.cy -= off_y;
    return sim_hal::cast_rays(world_, shifted, X_WC_);
  }

  [[nodiscard]] Hit hit(const sim_hal::Rendering& seen, int x, int y) const {
    Hit hit;
    const std::size_t i = index(x, y);
    hit.shape = seen.shape[i];
    if (hit.shape == kSky) return hit;
    const hal::CameraIntrinsics& k = seen.intrinsics;
    const double z = seen.depth_m[i];
    hit.distance = seen.depth_m[i];
    hit.p = (X_WC_ * Vec3(z * (x - k.cx) / k.fx, z * (y - k.cy) / k.fy, z)).cast<float>();
    hit.normal = normal_at(world_.shapes[static_cast<std::size_t>(hit.shape)], hit.p);
    return hit;
  }

  [[nodiscard]] bool is_edge(int x, int y) const {
    const Hit& here = hits_[index(x, y)];
    for (const auto& [dx, dy] : std::array<std::array<int, 2>, 4>{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}}) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= width_ || v >= height_) continue;
      const Hit& there = hits_[index(u, v)];
      if (there.shape != here.shape) return true;
      if (here.shape != kSky && there.normal.dot(here.normal) < 0.85f) return true;
    }
    return false;
  }

  // Pixels where surfaces meet, as the mean over 4 x 4 points of each, in a film 2 x 2.
  void smooth(const std::vector<std::pair<int, int>>& edges, std::vector<Vec3f>& colours) const {
    const int side = film_ ? 2 : 4;
    for (int j = 0; j < side && !edges.empty(); ++j)
      for (int i = 0; i < side; ++i) {
        const sim_hal::Rendering seen = cast((i + 0.5) / side - 0.5, (j + 0.5) / side - 0.5);
        // averaged as it is seen, so that dark edges on white do not grow thin
        for (const auto& [x, y] : edges) {
          const Hit at = hit(seen, x, y);
          colours[index(x, y)] += colour(at, light_near(at, x, y)).cwiseMax(0.0f).cwiseMin(1.0f).cwiseSqrt();
        }
      }
    for (const auto& [x, y] : edges) {
      Vec3f& c = colours[index(x, y)];
      c /= static_cast<float>(side * side);
      c = c.cwiseProduct(c).eval();
    }
  }

  // Light of the neighbour that shows the same surface.
  [[nodiscard]] SolidLight light_near(const Hit& hit, int x, int y) const {
    SolidLight light = light_[index(x, y)];
    float best = -2.0f;
    for (int v = std::max(0, y - 1); v <= std::min(height_ - 1, y + 1); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(width_ - 1, x + 1); ++u) {
        const Hit& there = hits_[index(u, v)];
        if (there.shape != hit.shape || hit.shape == kSky) continue;
        const float same = there.normal.dot(hit.normal);
        if (same > best) {
          best = same;
          light = light_[index(u, v)];
        }
      }
    return light;
  }

  // The ground dissolves into the paper with the distance from what is shown.
  [[nodiscard]] float fade(const Hit& hit) const {
    if (world_.shapes[static_cast<std::size_t>(hit.shape)].kind != Shape::Kind::HalfSpace) return 0.0f;
    const float aside = (hit.p - ground_middle_).head<2>().norm();
    const float t = std::clamp((aside - 1.2f) / 2.6f, 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
  }

  [[nodiscard]] Vec3f colour(const Hit& hit, const SolidLight& light) const {
    if (hit.shape == kSky) return Vec3f::Ones();
    const auto i = static_cast<std::size_t>(hit.shape);
    Vec3f albedo = colours_[i];
    const bool ground = world_.shapes[i].kind == Shape::Kind::HalfSpace;
    const float facing = std::max(0.0f, hit.normal.dot(key_));
    if (ground) {
      albedo *= 1.0f - 0.16f * on_grid(hit);
      // unshaded ground is its own colour
      const float lit = 0.42f * light.key + 0.58f * (0.25f + 0.75f * light.sky);
      const float t = fade(hit);
      return (1 - t) * lit * albedo + t * Vec3f::Ones();
    }
    const float sky = (0.42f + 0.13f * hit.normal.z()) * (0.2f + 0.8f * light.sky);
    const float fill = 0.10f * std::max(0.0f, hit.normal.dot(fill_));
    const Vec3f half = (key_ + fill_).normalized();
    const float gloss = 0.06f * light.key * std::pow(std::max(0.0f, hit.normal.dot(half)), 24.0f);
    return (0.72f * facing * light.key + sky + fill) * albedo + gloss * Vec3f::Ones();
  }

  [[nodiscard]] float on_grid(const Hit& hit) const {
    const float slant = std::max(0.08f, std::abs(hit.normal.dot(ahead_)));
    const float pixel = pixel_m(hit) / slant;
    float most = 0;
    for (const float at : {hit.p.x(), hit.p.y()}) {
      const float off = std::abs(at - kGridStep * std::round(at / kGridStep));
      most = std::max(most, std::clamp((kGridHalfWidth + 0.5f * pixel - off) / pixel, 0.0f, 1.0f));
    }
    return most;
  }

  int width_, height_;
  hal::Pose X_WC_;
  hal::CameraIntrinsics intrinsics_;
  bool film_;
  Vec3f ground_middle_;
  sim_hal::World world_;
  std::vector<Vec3f> colours_;  // of the shapes
  Vec3f ahead_, key_, fill_;
  std::vector<Hit> hits_;
  std::vector<SolidLight> light_;
};

}  // namespace

std::vector<std::uint8_t> cast_solids(const SolidScene& scene, const SolidView& view) {
  if (view.width < 1 || view.height < 1) return {};
  return Painter(scene, view).picture();
}

Canvas draw_solids(const SolidScene& scene, const SolidView& view) {
  Canvas canvas(view.width, view.height, kPaper);
  canvas.image(0, 0, view.width, view.height, cast_solids(scene, view));
  return canvas;
}

}  // namespace colift::picture
