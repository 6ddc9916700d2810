#include "perception/target/regions/surface_curvature.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace colift::perception {
namespace {

// half the side of a piece's grid in samples, and the number of pieces that are enough for a median
constexpr int kMinReach = 3, kMaxReach = 8, kEnoughPieces = 200;

// Samples of a piece. Where its grid is complete, the quadratic terms of a least-squares fit depend on no
// other term.
struct Lattice {
  explicit Lattice(int half_px)
      : step((std::max(kMinReach, half_px) + kMaxReach - 1) / kMaxReach),
        reach(std::max(kMinReach, half_px) / step),
        samples((2 * reach + 1) * (2 * reach + 1)) {
    const double side = 2 * reach + 1;
    for (int i = -reach; i <= reach; ++i) mean_square += i * i / side;
    for (int i = -reach; i <= reach; ++i) quartic += side * (i * i - mean_square) * (i * i - mean_square);
  }
  int step, reach, samples;
  double mean_square = 0.0;  ///< Of the steps along one axis.
  double quartic = 0.0;      ///< Sum of the squares of (step^2 - mean_square) over all samples.
};

struct Piece {
  double curvature, sigma;  // 1/m
};

class ObjectSurface {
 public:
  ObjectSurface(const OrganisedCloud& cloud, std::vector<std::uint8_t> own, const NoiseModel& noise,
                const Lattice& lattice, double max_residual)
      : cloud_(cloud), own_(std::move(own)), noise_(noise), g_(lattice), max_residual_(max_residual) {}

  // around pixel (u, v); nothing where a sample is not on the object, or where there is an edge
  [[nodiscard]] std::optional<Piece> piece(int u, int v) const {
    const int w = cloud_.width();
    double sum = 0.0, squares = 0.0, du = 0.0, dv = 0.0, twist = 0.0, across = 0.0, down = 0.0;
    for (int j = -g_.reach; j <= g_.reach; ++j) {
      for (int i = -g_.reach; i <= g_.reach; ++i) {
        const auto k = static_cast<std::size_t>((v + j * g_.step) * w + u + i * g_.step);
        if (!own_[k]) return std::nullopt;
        const double inverse = 1.0 / static_cast<double>(cloud_.depth_m[k]);
        sum += inverse;
        squares += inverse * inverse;
        du += inverse * i;
        dv += inverse * j;
        twist += inverse * i * j;
        across += inverse * (i * i - g_.mean_square);
        down += inverse * (j * j - g_.mean_square);
      }
    }
    const double linear = g_.samples * g_.mean_square, cross = linear * g_.mean_square;
    const double rest = squares - sum * sum / g_.samples - (du * du + dv * dv) / linear -
                        twist * twist / cross - (across * across + down * down) / g_.quartic;
    const double depth = static_cast<double>(cloud_.depth_m[static_cast<std::size_t>(v * w + u)]);
    const double noise = noise_.sigma(depth) / (depth * depth);
    if (rest > max_residual_ * max_residual_ * noise * noise * (g_.samples - 6)) return std::nullopt;
    // Second derivatives of the inverse depth by normalised image coordinates are curvatures, negative where
    // convex. The sum of the principal ones follows with the slope of the surface against the ray (any
    // textbook on surfaces: mean curvature of a graph).
    const double x = cloud_.intrinsics.fx / g_.step, y = cloud_.intrinsics.fy / g_.step;
    const double k_xx = -2.0 / g_.quartic * across * x * x, k_yy = -2.0 / g_.quartic * down * y * y;
    const double k_xy = -twist / cross * x * y;
    const double ray_x = (u - cloud_.intrinsics.cx) / cloud_.intrinsics.fx;
    const double ray_y = (v - cloud_.intrinsics.cy) / cloud_.intrinsics.fy;
    const double oblique = (1.0 + ray_x * ray_x + ray_y * ray_y) * g_.samples / sum;
    const double slope_x = ray_x - oblique * du / linear * x, slope_y = ray_y - oblique * dv / linear * y;
    const double xx = slope_x * slope_x, yy = slope_y * slope_y;
    const double facing = 1.0 / (1.0 + xx + yy), scale = facing * std::sqrt(facing);
    return Piece{
        scale * ((1.0 + yy) * k_xx + (1.0 + xx) * k_yy - 2.0 * slope_x * slope_y * k_xy),
        scale * 2.0 / std::sqrt(g_.quartic) * noise * std::hypot((1.0 + yy) * x * x, (1.0 + xx) * y * y)};
  }

 private:
  const OrganisedCloud& cloud_;
  std::vector<std::uint8_t> own_;  // of each pixel
  const NoiseModel& noise_;
  const Lattice& g_;
  double max_residual_;
};

}  // namespace

SurfaceCurvature surface_curvature(const OrganisedCloud& cloud, const Components& components,
                                   const Fragment& object, const NoiseModel& noise,
                                   const CurvatureConfig& c) {
  constexpr double kNearest_m = 0.1;
  const Lattice lattice(static_cast<int>(
      std::lround(c.half_width_m * cloud.intrinsics.fx / std::max(kNearest_m, object.mean_depth_m))));
  const int half = lattice.reach * lattice.step;
  const ObjectSurface surface(cloud, own_pixels(cloud, components, object), noise, lattice, c.max_residual);
  // pieces overlap by half, those of a large object less
  const double overlapping = static_cast<double>(object.pixels) / (half * half);
  const int stride = static_cast<int>(half * std::max(1.0, std::sqrt(overlapping / kEnoughPieces)));
  std::vector<double> curvature;
  double sigma = 0.0;
  const int bottom = std::min(cloud.height() - 1, object.v_max) - half;
  const int right = std::min(cloud.width() - 1, object.u_max) - half;
  for (int v = std::max(0, object.v_min) + half; v <= bottom; v += stride) {
    for (int u = std::max(0, object.u_min) + half; u <= right; u += stride) {
      const auto piece = surface.piece(u, v);
      if (!piece) continue;
      curvature.push_back(piece->curvature);
      sigma += piece->sigma;
    }
  }
  if (curvature.empty()) return {};
  const auto n = static_cast<double>(curvature.size());
  const auto convex =
      std::count_if(curvature.begin(), curvature.end(), [&](double k) { return k > c.convex_per_m; });
  const auto middle = curvature.begin() + static_cast<std::ptrdiff_t>(curvature.size() / 2);
  std::nth_element(curvature.begin(), middle, curvature.end());
  // the median of normal values spreads 1.25 times as much as their mean; of pieces that overlap half count
  return {*middle, 1.25 * sigma / n / std::sqrt(std::max(1.0, 0.5 * n)), static_cast<double>(convex) / n,
          n * stride * stride / static_cast<double>(object.pixels), static_cast<int>(curvature.size())};
}

}  // namespace colift::perception
