#include "perception/noise_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/types/symmetric.hpp"

namespace colift::perception {
namespace {

constexpr int kSide = 16;
constexpr double kMinSeen = 0.95;  // of a block's pixels
constexpr double kNotFlat = 6.0;   // times the median residual of its depth: an edge, a thing
constexpr double kMinStep = 1e-6;  // 1/m; depths closer together than this are one level
constexpr std::size_t kMinBlocks = 200, kMinPerBin = 20;
constexpr double kBin = 1.15;     // ratio of the ends of a bin of depth
constexpr double kMinSpan = 1.5;  // ratio of farthest to nearest depth that tells both numbers apart
constexpr double kMinFlat = 0.7, kMaxMisfit = 0.35;

// root mean square of what a plane leaves of a block's depths, and their mean
std::optional<std::pair<double, double>> residual_of(const hal::DepthFrame& f, int u0, int v0) {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  double square = 0.0, depth = 0.0;
  int n = 0;
  for (int v = 0; v < kSide; ++v) {
    for (int u = 0; u < kSide; ++u) {
      const auto z = static_cast<double>(
          f.depth_m[static_cast<std::size_t>(v0 + v) * static_cast<std::size_t>(f.intrinsics.width) +
                    static_cast<std::size_t>(u0 + u)]);
      if (!(z > 0.0)) continue;
      const Eigen::Vector3d x(1.0, u - 7.5, v - 7.5);
      A += x * x.transpose();
      b += x / z;
      square += 1.0 / (z * z);
      depth += z;
      ++n;
    }
  }
  if (n < static_cast<int>(kMinSeen * kSide * kSide)) return std::nullopt;
  const Eigen::Vector3d fit = hal::solve_symmetric<double, 3>(A, b);
  const double rest = std::max(0.0, square - fit.dot(b)) / (n - 3);
  depth /= n;
  return std::pair(depth, std::sqrt(rest) * depth * depth);
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Bin {
  double depth_m, sigma_m;
  std::size_t blocks;
};

}  // namespace

void NoiseFit::add(const hal::DepthFrame& frame) {
  const int w = frame.intrinsics.width, h = frame.intrinsics.height;
  if (w < kSide || h < kSide ||
      frame.depth_m.size() != static_cast<std::size_t>(w) * static_cast<std::size_t>(h))
    return;
  ++frames_;
  std::vector<float> levels;
  for (int v = 0; v + kSide <= h; v += kSide) {
    for (int u = 0; u + kSide <= w; u += kSide) {
      const auto found = residual_of(frame, u, v);
      if (!found) continue;
      ++with_depth_;
      blocks_.push_back({static_cast<float>(found->first), static_cast<float>(found->second)});
      levels.clear();
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x) {
          const float z = frame.depth_m[static_cast<std::size_t>(v + y) * static_cast<std::size_t>(w) +
                                        static_cast<std::size_t>(u + x)];
          if (z > 0.0f) levels.push_back(z);
        }
      std::sort(levels.begin(), levels.end());
      float smallest = 1e9f;
      for (std::size_t i = 1; i < levels.size(); ++i)
        if (levels[i] - levels[i - 1] > static_cast<float>(kMinStep))
          smallest = std::min(smallest, levels[i] - levels[i - 1]);
      if (smallest < 1e9f) steps_.push_back(smallest / static_cast<float>(found->first * found->first));
    }
  }
}

hal::Result<MeasuredNoise> NoiseFit::result() const {
  const auto refuse = [&](const std::string& why) {
    return hal::failure(hal::ErrorCode::BadInput, "noise", why);
  };
  if (blocks_.size() < kMinBlocks)
    return refuse(
        fmt::format("{} frames show {} blocks of 16 x 16 pixels with depth, {} are needed: point the camera "
                    "at an empty floor or a wall",
                    frames_, blocks_.size(), kMinBlocks));
  std::vector<Block> sorted = blocks_;
  std::sort(sorted.begin(), sorted.end(),
            [](const Block& a, const Block& b) { return a.depth_m < b.depth_m; });
  std::vector<Bin> bins;
  std::size_t flat = 0;
  for (std::size_t begin = 0; begin < sorted.size();) {
    std::size_t end = begin;
    std::vector<double> residuals, depths;
    while (end < sorted.size() && sorted[end].depth_m <= kBin * sorted[begin].depth_m) {
      residuals.push_back(sorted[end].residual_m);
      depths.push_back(sorted[end].depth_m);
      ++end;
    }
    if (residuals.size() >= kMinPerBin) {
      // edges and things are few beside an empty floor, and far off: the median of what is not
      const double limit = kNotFlat * median(residuals);
      std::erase_if(residuals, [&](double r) { return r > limit; });
      flat += residuals.size();
      bins.push_back({median(depths), median(residuals), residuals.size()});
    }
    begin = end;
  }
  if (bins.empty()) return refuse("the blocks with depth are at too many distances, too few at each");

  MeasuredNoise out;
  out.frames = frames_;
  out.blocks = flat;
  out.nearest_m = bins.front().depth_m;
  out.farthest_m = bins.back().depth_m;
  out.flat_fraction = static_cast<double>(flat) / static_cast<double>(with_depth_);
  // relative least squares: sigma / measured is 1; each bin counts once, however many blocks it has
  Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
  Eigen::Vector2d b = Eigen::Vector2d::Zero();
  for (const Bin& bin : bins) {
    const Eigen::Vector2d x(1.0 / bin.sigma_m, bin.depth_m * bin.depth_m / bin.sigma_m);
    A += x * x.transpose();
    b += x;
  }
  const bool spans = out.farthest_m > kMinSpan * out.nearest_m;
  Eigen::Vector2d s(0.0, -1.0);
  if (spans) s = hal::solve_small_symmetric(A, b);
  if (!spans || !(s[0] >= 0.0) || !(s[1] >= 0.0)) {
    // one number at a time, as far as it is positive
    s = {0.0, b[1] / A(1, 1)};
    if (!spans)
      out.doubts.push_back(
          fmt::format("all depths lie between {:.2f} and {:.2f} m: sigma0_m is set to 0, measure also "
                      "nearer or farther",
                      out.nearest_m, out.farthest_m));
  }
  out.model.sigma0_m = s[0];
  out.model.sigma2_per_m = s[1];
  std::vector<double> steps(steps_.begin(), steps_.end());
  out.model.step2_per_m = steps.empty() ? 0.0 : median(steps);
  double square = 0.0;
  for (const Bin& bin : bins) {
    const double off = bin.sigma_m / std::max(1e-9, out.model.sigma(bin.depth_m)) - 1.0;
    square += off * off;
  }
  out.misfit = std::sqrt(square / static_cast<double>(bins.size()));
  if (out.flat_fraction < kMinFlat)
    out.doubts.push_back(fmt::format("only {:.0f} % of the image is flat: take things out of the view",
                                     100 * out.flat_fraction));
  if (out.misfit > kMaxMisfit)
    out.doubts.push_back(
        fmt::format("the noise does not grow with the square of the distance, the model is off by "
                    "{:.0f} %",
                    100 * out.misfit));
  return out;
}

}  // namespace colift::perception
