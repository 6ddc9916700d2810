#include "hal/drivers/recorded/virtual_camera.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "hal/drivers/recorded/pixel_grid.hpp"

namespace colift::hal {
namespace {

constexpr std::size_t kFewestPoints = 200;
constexpr int kMostColumns = 1280, kMostRows = 960;
constexpr double kWidestTangent = 2.75;  // 70 degrees off axis
constexpr double kMinVisible = 0.6;
constexpr double kMinBefore = 0.95;  // of the points, before a camera that is to see them
constexpr float kNone = std::numeric_limits<float>::infinity();

// Points before a camera: tangents of the ray and depth.
struct Rays {
  std::vector<float> a, b, z;      // x/z, y/z, z (m)
  std::vector<std::size_t> index;  // into the file
  std::size_t finite = 0;          // points in the file, before the camera or not
};

struct Viewpoint {
  Pose X_FC = Pose::Identity();
  std::string words;
  bool only_on_grid = false;  // a guess at the file's axes, believed only if the points lie on its pixel grid
};

Rays rays_from(const PointFile& file, const Pose& X_FC) {
  const Pose X_CF = X_FC.inverse();
  Rays rays;
  for (std::size_t i = 0; i < file.size(); ++i) {
    if (!file.seen(i)) continue;
    ++rays.finite;
    const Vec3 p = X_CF * Vec3(file.x[i], file.y[i], file.z[i]);
    const double a = p.x() / p.z(), b = p.y() / p.z();
    if (!(p.z() > 1e-3) || !(std::abs(a) < kWidestTangent) || !(std::abs(b) < kWidestTangent)) continue;
    rays.a.push_back(static_cast<float>(a));
    rays.b.push_back(static_cast<float>(b));
    rays.z.push_back(static_cast<float>(p.z()));
    rays.index.push_back(i);
  }
  return rays;
}

// At `eye`, towards the middle of the rays to the points, image rows level with the file's z axis.
std::optional<Pose> look_at_points(const PointFile& file, const Vec3& eye) {
  Vec3 forward = Vec3::Zero();
  for (std::size_t i = 0; i < file.size(); ++i) {
    if (!file.seen(i)) continue;
    const Vec3 ray = Vec3(file.x[i], file.y[i], file.z[i]) - eye;
    if (ray.norm() > 1e-6) forward += ray.normalized();
  }
  if (!(forward.norm() > 1e-3)) return std::nullopt;
  forward.normalize();
  // a camera that looks along the file's z axis has that frame's -y as its up, like an optical frame
  const Vec3 up = std::abs(forward.z()) < 0.95 ? Vec3(Vec3::UnitZ()) : Vec3(-Vec3::UnitY());
  const Vec3 right = forward.cross(up).normalized();
  Pose X_FC = Pose::Identity();
  X_FC.linear().col(0) = right;
  X_FC.linear().col(1) = forward.cross(right);
  X_FC.linear().col(2) = forward;
  X_FC.translation() = eye;
  return X_FC;
}

std::vector<Viewpoint> candidates(const PointFile& file) {
  std::vector<Viewpoint> out;
  const bool stated = !file.viewpoint.matrix().isIdentity(1e-9);
  const bool moved = file.viewpoint.translation().norm() > 1e-9;
  if (stated) out.push_back({file.viewpoint, "at the file's VIEWPOINT"});
  if (moved) {
    if (const auto pose = look_at_points(file, file.viewpoint.translation())) {
      out.push_back({*pose, "at the file's VIEWPOINT, turned to the middle of the points"});
    }
  }
  out.push_back({Pose::Identity(), "at the file's origin, along its z axis"});
  // a robot's body frame and a graphics frame, as a camera's points are often published in
  Pose body = Pose::Identity(), graphics = Pose::Identity();
  body.linear() << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  graphics.linear() << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  out.push_back({body, "at the file's origin, along its x axis, z up", true});
  out.push_back({graphics, "at the file's origin, along its -z axis, y up", true});
  if (const auto pose = look_at_points(file, Vec3::Zero())) {
    out.push_back({*pose, "at the file's origin, turned to the middle of the points"});
  }
  return out;
}

struct Bounds {
  double low = 0.0, high = 0.0;
  [[nodiscard]] double extent() const { return high - low; }
};

// All values but a thousandth at either end: a few stray points must not decide the size of the image.
Bounds bounds_of(std::vector<float> values) {
  const auto cut = static_cast<std::ptrdiff_t>(values.size() / 1000);
  std::nth_element(values.begin(), values.begin() + cut, values.end());
  const double low = values[static_cast<std::size_t>(cut)];
  std::nth_element(values.begin(), values.end() - 1 - cut, values.end());
  return {low, *(values.end() - 1 - cut)};
}

// Pixels per unit of tangent at which the median point has a pixel of its own.
double focal_of_density(const Rays& rays, const Bounds& a, const Bounds& b) {
  const double area = std::max(a.extent(), 1e-9) * std::max(b.extent(), 1e-9);
  const double cell = std::sqrt(area * 32.0 / static_cast<double>(rays.a.size()));
  const auto columns = static_cast<std::size_t>(a.extent() / cell) + 1,
             rows = static_cast<std::size_t>(b.extent() / cell) + 1;
  std::vector<int> count(columns * rows, 0), of_point;
  std::vector<std::size_t> cell_of;
  for (std::size_t i = 0; i < rays.a.size(); ++i) {
    const double ca = (rays.a[i] - a.low) / cell, cb = (rays.b[i] - b.low) / cell;
    if (!(ca >= 0.0 && cb >= 0.0 && ca < static_cast<double>(columns) && cb < static_cast<double>(rows)))
      continue;
    const std::size_t c = static_cast<std::size_t>(cb) * columns + static_cast<std::size_t>(ca);
    ++count[c];
    cell_of.push_back(c);
  }
  of_point.reserve(cell_of.size());
  for (const std::size_t c : cell_of) of_point.push_back(count[c]);
  const auto middle = of_point.begin() + static_cast<std::ptrdiff_t>(of_point.size() / 2);
  std::nth_element(of_point.begin(), middle, of_point.end());
  return std::sqrt(static_cast<double>(*middle)) / cell;
}

class Canvas {
 public:
  Canvas(const Rays& rays, const CameraIntrinsics& intrinsics) : rays_(rays), k_(intrinsics) {
    depth_.assign(static_cast<std::size_t>(k_.width) * static_cast<std::size_t>(k_.height), kNone);
    owner_.resize(depth_.size());
    pixel_.assign(rays.a.size(), depth_.size());
    for (std::size_t i = 0; i < rays.a.size(); ++i) {
      const double u = std::floor(k_.fx * rays.a[i] + k_.cx + 0.5),
                   v = std::floor(k_.fy * rays.b[i] + k_.cy + 0.5);
      if (!(u >= 0.0 && v >= 0.0 && u < k_.width && v < k_.height)) continue;
      const std::size_t pixel =
          static_cast<std::size_t>(v) * static_cast<std::size_t>(k_.width) + static_cast<std::size_t>(u);
      pixel_[i] = pixel;
      if (rays.z[i] < depth_[pixel]) {
        depth_[pixel] = rays.z[i];
        owner_[pixel] = i;
      }
    }
  }

  // Empties pixels that are seen through the gaps of a nearer surface: nearer neighbours on two opposite
  // sides.
  void close_gaps() {
    const std::vector<float> before = depth_;
    for (int v = 2; v < k_.height - 2; ++v) {
      for (int u = 2; u < k_.width - 2; ++u) {
        const std::size_t p = at(u, v);
        if (before[p] == kNone) continue;
        const float limit = before[p] - tolerance(before[p]);
        bool behind = false;
        for (int dv = 0; dv <= 2 && !behind; ++dv) {
          for (int du = dv == 0 ? 1 : -2; du <= 2 && !behind; ++du) {
            behind = before[at(u + du, v + dv)] < limit && before[at(u - du, v - dv)] < limit;
          }
        }
        if (behind) depth_[p] = kNone;
      }
    }
  }

  // Part of the finite points that the image shows: in a pixel of their own or at the depth of its owner.
  [[nodiscard]] double visible() const {
    std::size_t count = 0;
    for (std::size_t i = 0; i < pixel_.size(); ++i) {
      const std::size_t p = pixel_[i];
      if (p < depth_.size() && depth_[p] != kNone && rays_.z[i] - depth_[p] <= tolerance(rays_.z[i])) ++count;
    }
    return static_cast<double>(count) / static_cast<double>(rays_.finite);
  }

  // Fills single empty pixels between neighbours of one surface, all from the image as it was before.
  void fill_holes() {
    const std::vector<float> before = depth_;
    for (int v = 1; v < k_.height - 1; ++v) {
      for (int u = 1; u < k_.width - 1; ++u) {
        if (before[at(u, v)] != kNone) continue;
        for (const auto& [p, q] :
             {std::pair{at(u - 1, v), at(u + 1, v)}, std::pair{at(u, v - 1), at(u, v + 1)}}) {
          if (before[p] == kNone || before[q] == kNone ||
              std::abs(before[p] - before[q]) > tolerance(before[p]))
            continue;
          depth_[at(u, v)] = 0.5f * (before[p] + before[q]);
          owner_[at(u, v)] = owner_[p];
          break;
        }
      }
    }
  }

  // Empty pixels inside surfaces, as a part of the full ones.
  [[nodiscard]] double holes() const {
    std::size_t full = 0, empty = 0;
    for (int v = 1; v < k_.height - 1; ++v) {
      for (int u = 1; u < k_.width - 1; ++u) {
        if (depth_[at(u, v)] != kNone) {
          ++full;
          continue;
        }
        int around = 0;
        for (int dv = -1; dv <= 1; ++dv) {
          for (int du = -1; du <= 1; ++du) around += depth_[at(u + du, v + dv)] != kNone ? 1 : 0;
        }
        empty += around >= 5 ? 1 : 0;
      }
    }
    return full == 0 ? 1.0 : static_cast<double>(empty) / static_cast<double>(full);
  }

  [[nodiscard]] DepthFrame frame(const PointFile& file) const {
    DepthFrame out;
    out.intrinsics = k_;
    out.depth_m.resize(depth_.size());
    if (!file.rgb.empty()) out.rgb.resize(3 * depth_.size(), 0);
    for (std::size_t p = 0; p < depth_.size(); ++p) {
      const bool none = depth_[p] == kNone;
      out.depth_m[p] = none ? std::numeric_limits<float>::quiet_NaN() : depth_[p];
      if (none || file.rgb.empty()) continue;
      std::copy_n(file.rgb.begin() + static_cast<std::ptrdiff_t>(3 * rays_.index[owner_[p]]), 3,
                  out.rgb.begin() + static_cast<std::ptrdiff_t>(3 * p));
    }
    return out;
  }

 private:
  [[nodiscard]] std::size_t at(int u, int v) const {
    return static_cast<std::size_t>(v) * static_cast<std::size_t>(k_.width) + static_cast<std::size_t>(u);
  }
  // Depth that one surface may cover inside a pixel: noise, and a slope of 76 degrees over the pixel's width
  // (m).
  [[nodiscard]] float tolerance(float z) const {
    return 0.01f + z * (0.01f + 4.0f / static_cast<float>(k_.fx));
  }

  const Rays& rays_;
  CameraIntrinsics k_;
  std::vector<float> depth_;
  std::vector<std::size_t> owner_, pixel_;
};

CameraIntrinsics intrinsics_for(double focal, const Bounds& a, const Bounds& b) {
  // one pixel of margin, so that surfaces do not end exactly at the border
  CameraIntrinsics k;
  k.fx = k.fy = focal;
  k.width = std::min(kMostColumns, static_cast<int>(std::ceil(focal * a.extent())) + 3);
  k.height = std::min(kMostRows, static_cast<int>(std::ceil(focal * b.extent())) + 3);
  k.cx = 1.0 - focal * a.low;
  k.cy = 1.0 - focal * b.low;
  return k;
}

std::optional<VirtualView> draw(const PointFile& file, const Rays& rays, const Viewpoint& from) {
  VirtualView out;
  out.X_FC = from.X_FC;
  const Bounds a = bounds_of(rays.a), b = bounds_of(rays.b);
  double focal = focal_of_density(rays, a, b);

  // points that came from a pixel grid go back into it, each into its own pixel
  const auto columns = find_pixel_grid(rays.a, focal), rows = find_pixel_grid(rays.b, focal);
  if (columns && rows && columns->count <= kMostColumns && rows->count <= kMostRows) {
    const CameraIntrinsics k{columns->count, rows->count,     columns->focal,
                             rows->focal,    columns->centre, rows->centre};
    Canvas canvas(rays, k);
    out.visible = canvas.visible();
    out.frame = canvas.frame(file);
    out.note = fmt::format(
        "the points lie on a pixel grid of focal length {:.1f}, which was restored: {} x {} pixels, camera "
        "{}",
        k.fx, k.width, k.height, from.words);
    return out;
  }

  if (from.only_on_grid) return std::nullopt;
  focal = std::min(
      {focal, (kMostColumns - 3) / std::max(a.extent(), 1e-9), (kMostRows - 3) / std::max(b.extent(), 1e-9)});
  // coarser until surfaces are closed
  for (int round = 0;; ++round) {
    Canvas canvas(rays, intrinsics_for(focal, a, b));
    canvas.close_gaps();
    out.visible = canvas.visible();
    // twice: where points are a little sparser than pixels, the empty pixels form lines that cross
    canvas.fill_holes();
    canvas.fill_holes();
    if (canvas.holes() < 0.02 || round == 8) {
      out.frame = canvas.frame(file);
      break;
    }
    focal *= 0.88;
  }
  const CameraIntrinsics& k = out.frame.intrinsics;
  out.note =
      fmt::format("the points were drawn into a virtual camera of {} x {} pixels, focal length {:.1f}, {}",
                  k.width, k.height, k.fx, from.words);
  return out;
}

}  // namespace

Result<VirtualView> view_points(const PointFile& file, const std::string& name) {
  const auto refuse = [&](std::string detail) {
    return failure(ErrorCode::BadInput, name, std::move(detail));
  };
  std::optional<VirtualView> best;
  std::string reason;
  for (const Viewpoint& from : candidates(file)) {
    const Rays rays = rays_from(file, from.X_FC);
    if (rays.finite < kFewestPoints) {
      return refuse(fmt::format(
          "{} finite points without image order are too few to make an image; expected at least {}",
          rays.finite, kFewestPoints));
    }
    const double before = static_cast<double>(rays.a.size()) / static_cast<double>(rays.finite);
    if (before < kMinBefore) {
      if (from.only_on_grid) continue;
      reason = fmt::format(
          "only {:.0f} % of the {} points lie before a camera {}: they surround it or lie behind it",
          100.0 * before, rays.finite, from.words);
      continue;
    }
    const double wide = bounds_of(rays.a).extent(), high = bounds_of(rays.b).extent();
    if (std::min(wide, high) < 0.01 * std::max(wide, high)) {
      if (from.only_on_grid) continue;
      reason = fmt::format(
          "seen by a camera {}, the {} points form a line {:.2g} wide and {:.2g} high: they lie in one plane "
          "with it",
          from.words, rays.finite, wide, high);
      continue;
    }
    std::optional<VirtualView> view = draw(file, rays, from);
    if (!view) continue;
    if (view->visible >= kMinVisible) return std::move(*view);
    if (!best || view->visible > best->visible) {
      reason = fmt::format(
          "only {:.0f} % of the {} points can be seen by one camera {} (min {:.0f} %): the rest lies behind "
          "other points, as in a map of several views",
          100.0 * view->visible, rays.finite, from.words, 100.0 * kMinVisible);
      best = std::move(view);
    }
  }
  return refuse("the points without image order make no depth image: " + reason +
                "; expected one camera's view, from the origin or from VIEWPOINT");
}

}  // namespace colift::hal
