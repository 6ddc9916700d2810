// The picture of a scene of solids. First every pixel's nearest surface; then how much of the key light and
// of the sky reaches it, by a few rays per pixel whose pattern repeats every 4 x 4 pixels, averaged over just
// such a neighbourhood on the same surface, which leaves no grain; then colour, with more rays where surfaces
// meet.

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/types/units.hpp"
#include "tools/visualization/palette.hpp"
#include "tools/visualization/scene/solid_rays.hpp"
#include "tools/visualization/scene/solid_scene.hpp"

namespace colift::picture {
namespace {

constexpr int kTile = 16;
constexpr int kKeyRays = 8, kSkyRays = 8, kPattern = 4;
constexpr float kKeySpread = 0.11f;  // half angle of the key light (rad): a large window, soft shadows
constexpr float kSkyReach = 0.7f;    // farther solids do not darken the sky (m)
constexpr float kLift = 1e-4f;       // rays start this far off the surface (m)
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

struct Ray {
  Vec3f from, along;
};

// Rays of the pixels of a view.
class Eye {
 public:
  explicit Eye(const SolidView& view) {
    const Vec3 ahead = (view.target - view.eye).normalized();
    Vec3 right = ahead.cross(Vec3::UnitZ());
    right = right.norm() > 1e-6 ? right.normalized() : Vec3::UnitY();
    ahead_ = ahead.cast<float>();
    right_ = right.cast<float>();
    down_ = ahead.cross(right).cast<float>();
    eye_ = view.eye.cast<float>();
    middle_ = {0.5f * static_cast<float>(view.width), 0.5f * static_cast<float>(view.height)};
    parallel_ = view.height_m.has_value();
    step_ = parallel_ ? static_cast<float>(*view.height_m / view.height)
                      : static_cast<float>(2 * std::tan(0.5 * hal::deg_to_rad(view.angle_deg)) / view.height);
  }

  [[nodiscard]] Ray ray(float x, float y) const {
    const Vec3f aside = step_ * ((x - middle_.x()) * right_ + (y - middle_.y()) * down_);
    if (parallel_) return {eye_ + aside - kBack * ahead_, ahead_};
    return {eye_, (ahead_ + aside).normalized()};
  }
  [[nodiscard]] Bundle tile(int x, int y) const {
    const float half = 0.5f * kTile;
    const Ray middle = ray(static_cast<float>(x) + half, static_cast<float>(y) + half);
    const float wide = 1.5f * half * step_;
    return {middle.from, middle.along, parallel_ ? wide : 0.0f, parallel_ ? 0.0f : wide};
  }
  // Size of a pixel on a surface that faces the eye at this distance (m).
  [[nodiscard]] float pixel_m(float distance) const { return parallel_ ? step_ : step_ * distance; }

 private:
  static constexpr float kBack = 20.0f;  // parallel rays start far behind the eye's plane (m)
  Vec3f eye_, ahead_, right_, down_;
  Eigen::Vector2f middle_;
  bool parallel_ = false;
  float step_ = 0.0f;
};

struct Hit {
  std::int16_t solid = kSky;
  float distance = 0.0f;
  Vec3f p = Vec3f::Zero(), normal = Vec3f::Zero();
};

struct Light {
  float key = 1.0f, sky = 1.0f;
};

// Points of unit discs and directions about +z, one set for each pixel of the 4 x 4 pattern.
struct Pattern {
  std::array<std::array<Eigen::Vector2f, kKeyRays>, kPattern * kPattern> key;
  std::array<std::array<Vec3f, kSkyRays>, kPattern * kPattern> sky;

  Pattern() {
    // a sunflower's seeds, dealt so that each set covers the disc
    constexpr std::size_t kSets = kPattern * kPattern;
    const auto seed = [](std::size_t k, std::size_t of) {
      constexpr double kGoldenAngle = 2.399963229728653;
      const double r = std::sqrt((static_cast<double>(k) + 0.5) / static_cast<double>(of));
      const double angle = kGoldenAngle * static_cast<double>(k);
      return Eigen::Vector2d(r * std::cos(angle), r * std::sin(angle));
    };
    for (std::size_t set = 0; set < kSets; ++set) {
      const std::size_t turn = (set * 7) % kSets;
      for (std::size_t i = 0; i < kKeyRays; ++i)
        key[set][i] = seed(i * kSets + turn, kKeyRays * kSets).cast<float>();
      for (std::size_t i = 0; i < kSkyRays; ++i) {
        const Eigen::Vector2d d = seed(i * kSets + turn, kSkyRays * kSets);
        sky[set][i] =
            Eigen::Vector3d(d.x(), d.y(), std::sqrt(std::max(0.0, 1 - d.squaredNorm()))).cast<float>();
      }
    }
  }
};

class Caster {
 public:
  Caster(const SolidScene& scene, const SolidView& view)
      : eye_(view), width_(view.width), height_(view.height), ground_middle_(view.target.cast<float>()) {
    for (const Solid& solid : scene.solids) {
      if (!solid.X_WS.matrix().allFinite() || !solid.size.allFinite()) continue;
      solids_.push_back(ray_solid(solid));
      colours_.push_back(linear_of(solid.colour.value_or(colour_of(solid.role))));
    }
    const Vec3f towards_eye = eye_.ray(middle_x(), middle_y()).along * -1.0f;
    // from high on the left of the eye, whichever way it looks
    Vec3f left = towards_eye.cross(Vec3f::UnitZ());
    left = left.norm() > 1e-4f ? left.normalized() : Vec3f::UnitX();
    key_ = (0.55f * towards_eye + 0.5f * left + 1.0f * Vec3f::UnitZ()).normalized();
    fill_ = towards_eye;
    const Vec3f helper = std::abs(key_.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX();
    key_u_ = helper.cross(key_).normalized();
    key_v_ = key_.cross(key_u_);
  }

  std::vector<std::uint8_t> picture() {
    const auto pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
    hits_.resize(pixels);
    light_.resize(pixels);
    std::vector<std::uint8_t> bytes(3 * pixels);
    for (int y = 0; y < height_; y += kTile)
      for (int x = 0; x < width_; x += kTile) cast_tile(x, y);
    std::vector<Light> smooth(pixels);
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) smooth[index(x, y)] = smoothed(x, y);
    light_.swap(smooth);
    std::vector<std::size_t> near;
    for (int ty = 0; ty < height_; ty += kTile)
      for (int tx = 0; tx < width_; tx += kTile) {
        in_bundle(eye_.tile(tx, ty), near);
        for (int y = ty; y < std::min(ty + kTile, height_); ++y)
          for (int x = tx; x < std::min(tx + kTile, width_); ++x) {
            const Vec3f c =
                is_edge(x, y) ? edge_colour(x, y, near) : colour(hits_[index(x, y)], light_[index(x, y)]);
            for (int i = 0; i < 3; ++i) bytes[3 * index(x, y) + static_cast<std::size_t>(i)] = byte_of(c[i]);
          }
      }
    return bytes;
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
  }
  [[nodiscard]] float middle_x() const { return 0.5f * static_cast<float>(width_); }
  [[nodiscard]] float middle_y() const { return 0.5f * static_cast<float>(height_); }

  void in_bundle(const Bundle& bundle, std::vector<std::size_t>& out) const {
    out.clear();
    for (std::size_t i = 0; i < solids_.size(); ++i)
      if (may_meet(bundle, solids_[i])) out.push_back(i);
  }

  [[nodiscard]] Hit nearest(const Ray& ray, const std::vector<std::size_t>& among) const {
    Hit hit;
    hit.distance = std::numeric_limits<float>::infinity();
    for (const std::size_t i : among) {
      Vec3f normal;
      const float t = cast(solids_[i], ray.from, ray.along, hit.distance, &normal);
      if (t >= hit.distance) continue;
      hit.distance = t;
      hit.solid = static_cast<std::int16_t>(i);
      hit.normal = normal;
    }
    if (hit.solid != kSky) hit.p = ray.from + hit.distance * ray.along;
    return hit;
  }

  [[nodiscard]] bool blocked(const Vec3f& from, const Vec3f& along, float before,
                             const std::vector<std::size_t>& among) const {
    return std::any_of(among.begin(), among.end(), [&](std::size_t i) {
      return solids_[i].kind != Solid::Kind::Ground &&
             cast(solids_[i], from, along, before, nullptr) < before;
    });
  }

  void cast_tile(int tx, int ty) {
    std::vector<std::size_t> seen, to_key, to_sky;
    in_bundle(eye_.tile(tx, ty), seen);
    Vec3f low = Vec3f::Constant(1e9f), high = Vec3f::Constant(-1e9f);
    for (int y = ty; y < std::min(ty + kTile, height_); ++y)
      for (int x = tx; x < std::min(tx + kTile, width_); ++x) {
        Hit& hit = hits_[index(x, y)];
        hit = nearest(eye_.ray(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f), seen);
        if (hit.solid == kSky || faded(hit)) continue;
        low = low.cwiseMin(hit.p);
        high = high.cwiseMax(hit.p);
      }
    if (low.x() > high.x()) return;
    const Vec3f middle = 0.5f * (low + high);
    const float radius = 0.5f * (high - low).norm() + kLift;
    in_bundle({middle, key_, radius, kKeySpread}, to_key);
    in_bundle({middle, Vec3f::UnitZ(), radius + kSkyReach, 0.0f, 0.0f}, to_sky);
    for (int y = ty; y < std::min(ty + kTile, height_); ++y)
      for (int x = tx; x < std::min(tx + kTile, width_); ++x) {
        const Hit& hit = hits_[index(x, y)];
        if (hit.solid != kSky && !faded(hit)) light_[index(x, y)] = light_at(hit, x, y, to_key, to_sky);
      }
  }

  [[nodiscard]] Light light_at(const Hit& hit, int x, int y, const std::vector<std::size_t>& to_key,
                               const std::vector<std::size_t>& to_sky) const {
    const auto set = static_cast<std::size_t>((y % kPattern) * kPattern + x % kPattern);
    const Vec3f from = hit.p + kLift * hit.normal;
    Light light;
    if (!to_key.empty()) {
      int dark = 0;
      for (const Eigen::Vector2f& d : pattern_.key[set]) {
        const Vec3f along = (key_ + kKeySpread * (d.x() * key_u_ + d.y() * key_v_)).normalized();
        dark += along.dot(hit.normal) <= 0 || blocked(from, along, 30.0f, to_key);
      }
      light.key = 1.0f - static_cast<float>(dark) / kKeyRays;
    }
    if (!to_sky.empty()) {
      const Vec3f helper = std::abs(hit.normal.z()) < 0.9f ? Vec3f::UnitZ() : Vec3f::UnitX();
      const Vec3f u = helper.cross(hit.normal).normalized(), v = hit.normal.cross(u);
      int dark = 0;
      for (const Vec3f& d : pattern_.sky[set]) {
        const Vec3f along = d.x() * u + d.y() * v + d.z() * hit.normal;
        dark += along.z() < 0 ? near_ground(from, along) : blocked(from, along, kSkyReach, to_sky);
      }
      light.sky = 1.0f - static_cast<float>(dark) / kSkyRays;
    }
    return light;
  }

  // What looks down at the ground close by is in its shade a little.
  [[nodiscard]] static bool near_ground(const Vec3f& from, const Vec3f& along) {
    return from.z() < -along.z() * 0.25f;
  }

  [[nodiscard]] Light smoothed(int x, int y) const {
    const Hit& here = hits_[index(x, y)];
    if (here.solid == kSky) return {};
    Light sum{0, 0};
    int count = 0;
    const float off = 2.0f * eye_.pixel_m(here.distance) + 0.002f;
    for (int v = std::max(0, y - 1); v <= std::min(height_ - 1, y + 2); ++v)
      for (int u = std::max(0, x - 1); u <= std::min(width_ - 1, x + 2); ++u) {
        const Hit& there = hits_[index(u, v)];
        if (there.solid == kSky || there.normal.dot(here.normal) < 0.9f ||
            std::abs(here.normal.dot(there.p - here.p)) > off)
          continue;
        sum.key += light_[index(u, v)].key;
        sum.sky += light_[index(u, v)].sky;
        ++count;
      }
    const float n = static_cast<float>(std::max(1, count));
    return count ? Light{sum.key / n, sum.sky / n} : light_[index(x, y)];
  }

  [[nodiscard]] bool is_edge(int x, int y) const {
    const Hit& here = hits_[index(x, y)];
    for (const auto& [dx, dy] : std::array<std::array<int, 2>, 4>{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}}) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= width_ || v >= height_) continue;
      const Hit& there = hits_[index(u, v)];
      if (there.solid != here.solid) return true;
      if (here.solid != kSky && there.normal.dot(here.normal) < 0.85f) return true;
    }
    return false;
  }

  [[nodiscard]] Vec3f edge_colour(int x, int y, const std::vector<std::size_t>& among) const {
    constexpr int kSide = 4;
    Vec3f sum = Vec3f::Zero();
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        const float fx = (static_cast<float>(i) + 0.5f) / kSide, fy = (static_cast<float>(j) + 0.5f) / kSide;
        const Hit hit = nearest(eye_.ray(static_cast<float>(x) + fx, static_cast<float>(y) + fy), among);
        // light of the neighbour that sees the same surface
        Light light = light_[index(x, y)];
        float best = -2.0f;
        for (int v = std::max(0, y - 1); v <= std::min(height_ - 1, y + 1); ++v)
          for (int u = std::max(0, x - 1); u <= std::min(width_ - 1, x + 1); ++u) {
            const Hit& there = hits_[index(u, v)];
            if (there.solid != hit.solid || hit.solid == kSky) continue;
            const float same = there.normal.dot(hit.normal);
            if (same > best) {
              best = same;
              light = light_[index(u, v)];
            }
          }
        // averaged as it is seen, so that dark edges on white do not grow thin
        sum += colour(hit, light).cwiseMax(0.0f).cwiseMin(1.0f).cwiseSqrt();
      }
    sum /= kSide * kSide;
    return sum.cwiseProduct(sum);
  }

  // The ground dissolves into the paper with the distance from what is shown.
  [[nodiscard]] float fade(const Hit& hit) const {
    if (solids_[static_cast<std::size_t>(hit.solid)].kind != Solid::Kind::Ground) return 0.0f;
    const float aside = (hit.p - ground_middle_).head<2>().norm();
    const float t = std::clamp((aside - 1.2f) / 2.6f, 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
  }
  [[nodiscard]] bool faded(const Hit& hit) const { return fade(hit) >= 1.0f; }

  [[nodiscard]] Vec3f colour(const Hit& hit, const Light& light) const {
    if (hit.solid == kSky) return Vec3f::Ones();
    const auto i = static_cast<std::size_t>(hit.solid);
    Vec3f albedo = colours_[i];
    const bool ground = solids_[i].kind == Solid::Kind::Ground;
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
    const float slant = std::max(0.08f, std::abs(hit.normal.dot(eye_.ray(middle_x(), middle_y()).along)));
    const float pixel = eye_.pixel_m(hit.distance) / slant;
    float most = 0;
    for (const float at : {hit.p.x(), hit.p.y()}) {
      const float off = std::abs(at - kGridStep * std::round(at / kGridStep));
      most = std::max(most, std::clamp((kGridHalfWidth + 0.5f * pixel - off) / pixel, 0.0f, 1.0f));
    }
    return most;
  }

  Eye eye_;
  int width_, height_;
  Vec3f ground_middle_;
  std::vector<RaySolid> solids_;
  std::vector<Vec3f> colours_;
  Vec3f key_, key_u_, key_v_, fill_;
  Pattern pattern_;
  std::vector<Hit> hits_;
  std::vector<Light> light_;
};

}  // namespace

std::vector<std::uint8_t> cast_solids(const SolidScene& scene, const SolidView& view) {
  if (view.width < 1 || view.height < 1) return {};
  return Caster(scene, view).picture();
}

Canvas draw_solids(const SolidScene& scene, const SolidView& view) {
  Canvas canvas(view.width, view.height, kPaper);
  canvas.image(0, 0, view.width, view.height, cast_solids(scene, view));
  return canvas;
}

}  // namespace colift::picture
