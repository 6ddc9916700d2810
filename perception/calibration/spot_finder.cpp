#include "perception/calibration/spot_finder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "hal/types/symmetric.hpp"

namespace colift::perception {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Kept = std::vector<const hal::InfraredFrame*>;
using Found = tl::expected<Spot, SpotRefusal>;

tl::unexpected<SpotRefusal> refuse(const char* kind, std::string reason) {
  return tl::unexpected<SpotRefusal>(SpotRefusal{kind, std::move(reason)});
}

bool fits(const hal::InfraredFrame& f, int width, int height) {
  return f.width == width && f.height == height && width > 8 && height > 8 &&
         f.brightness.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

/// What two stacks of images differ in.
struct Difference {
  int width = 0, height = 0;
  std::vector<float> mean;    ///< Mean with emitter minus mean without.
  std::vector<float> steady;  ///< Darkest with minus brightest without.
  std::vector<std::uint8_t> saturated;
  double sigma = 0.0;  ///< Of the mean difference.
};

Difference subtract(const Kept& off, const Kept& on, const SpotConfig& config) {
  const int saturation = config.saturation;
  Difference d;
  d.width = on.front()->width;
  d.height = on.front()->height;
  const std::size_t n = on.front()->brightness.size();
  std::vector<float> sum(n, 0.0f);
  std::vector<std::uint16_t> darkest(n, 0xffff), brightest(n, 0);
  d.saturated.assign(n, 0);
  const auto on_part = 1.0f / static_cast<float>(on.size()), off_part = 1.0f / static_cast<float>(off.size());
  for (const auto* f : on)
    for (std::size_t i = 0; i < n; ++i) {
      sum[i] += on_part * static_cast<float>(f->brightness[i]);
      darkest[i] = std::min(darkest[i], f->brightness[i]);
      if (f->brightness[i] >= saturation) d.saturated[i] = 1;
    }
  for (const auto* f : off)
    for (std::size_t i = 0; i < n; ++i) {
      sum[i] -= off_part * static_cast<float>(f->brightness[i]);
      brightest[i] = std::max(brightest[i], f->brightness[i]);
    }
  d.mean = std::move(sum);
  d.steady.resize(n);
  for (std::size_t i = 0; i < n; ++i)
    d.steady[i] = static_cast<float>(darkest[i]) - static_cast<float>(brightest[i]);
  // median of absolute differences: a spot and a person are few pixels of many
  std::vector<float> some;
  for (std::size_t i = 0; i < n; i += 7) some.push_back(std::abs(d.mean[i]));
  std::nth_element(some.begin(), some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2), some.end());
  d.sigma = std::max(config.min_noise, 1.4826 * static_cast<double>(some[some.size() / 2]));
  return d;
}

struct Blob {
  std::vector<int> pixels;
  double light = 0.0, peak = 0.0;
  bool steady = false, at_border = false;
};

std::vector<Blob> find_blobs(const Difference& d, float threshold, double steady_fraction) {
  std::vector<Blob> out;
  std::vector<char> seen(d.mean.size(), 0);
  for (std::size_t start = 0; start < d.mean.size(); ++start) {
    if (seen[start] || !(d.mean[start] > threshold)) continue;
    Blob blob;
    std::vector<int> front{static_cast<int>(start)};
    seen[start] = 1;
    std::size_t peak = start;
    while (!front.empty()) {
      const int at = front.back();
      front.pop_back();
      blob.pixels.push_back(at);
      const auto i = static_cast<std::size_t>(at);
      blob.light += static_cast<double>(d.mean[i]);
      if (d.mean[i] > d.mean[peak]) peak = i;
      const int u = at % d.width, v = at / d.width;
      blob.at_border |= u == 0 || v == 0 || u == d.width - 1 || v == d.height - 1;
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du) {
          const int x = u + du, y = v + dv;
          if (x < 0 || y < 0 || x >= d.width || y >= d.height) continue;
          const auto j = static_cast<std::size_t>(y * d.width + x);
          if (seen[j] || !(d.mean[j] > threshold)) continue;
          seen[j] = 1;
          front.push_back(static_cast<int>(j));
        }
    }
    blob.peak = static_cast<double>(d.mean[peak]);
    blob.steady = static_cast<double>(d.steady[peak]) >= steady_fraction * blob.peak;
    out.push_back(std::move(blob));
  }
  return out;
}

/// Pixels of a blob's bounding box and a little more.
struct Window {
  int u0, v0, u1, v1;
};
Window around(const Blob& blob, int width, int height, int margin) {
  Window w{width, height, 0, 0};
  for (const int at : blob.pixels) {
    w.u0 = std::min(w.u0, at % width), w.u1 = std::max(w.u1, at % width);
    w.v0 = std::min(w.v0, at / width), w.v1 = std::max(w.v1, at / width);
  }
  return {std::max(0, w.u0 - margin), std::max(0, w.v0 - margin), std::min(width - 1, w.u1 + margin),
          std::min(height - 1, w.v1 + margin)};
}

/// Centre of light in a window.
Vector2d centre_of_light(const std::vector<float>& light, int width, const Window& w, double* sum_out) {
  double sum = 0.0, u_sum = 0.0, v_sum = 0.0;
  for (int v = w.v0; v <= w.v1; ++v)
    for (int u = w.u0; u <= w.u1; ++u) {
      const auto l = static_cast<double>(light[static_cast<std::size_t>(v * width + u)]);
      sum += l, u_sum += l * u, v_sum += l * v;
    }
  if (sum_out) *sum_out = sum;
  return {u_sum / sum, v_sum / sum};
}

/// Peak of the Gaussian through the flanks: the logarithm of its light is a parabola.
std::optional<Vector2d> fit_flanks(const Difference& d, const Window& w, double least) {
  using Mat6 = Eigen::Matrix<double, 6, 6>;
  using Vec6 = Eigen::Matrix<double, 6, 1>;
  const double u_mid = 0.5 * (w.u0 + w.u1), v_mid = 0.5 * (w.v0 + w.v1);
  Mat6 H = Mat6::Zero();
  Vec6 g = Vec6::Zero();
  int count = 0;
  for (int v = w.v0; v <= w.v1; ++v)
    for (int u = w.u0; u <= w.u1; ++u) {
      const auto i = static_cast<std::size_t>(v * d.width + u);
      const auto l = static_cast<double>(d.mean[i]);
      if (d.saturated[i] || l < least) continue;
      const double x = u - u_mid, y = v - v_mid;
      Vec6 row;
      row << 1.0, x, y, x * x, x * y, y * y;
      H += l * l * row * row.transpose();
      g += l * l * std::log(l) * row;
      ++count;
    }
  if (count < 10) return std::nullopt;
  const Vec6 c = hal::solve_symmetric<double, 6>(H, g);
  const double det = 4.0 * c[3] * c[5] - c[4] * c[4];
  if (!(c[3] < 0.0) || !(c[5] < 0.0) || !(det > 0.0)) return std::nullopt;
  const Vector2d peak(u_mid + (c[4] * c[2] - 2.0 * c[5] * c[1]) / det,
                      v_mid + (c[4] * c[1] - 2.0 * c[3] * c[2]) / det);
  const bool inside = peak.x() >= w.u0 && peak.x() <= w.u1 && peak.y() >= w.v0 && peak.y() <= w.v1;
  return inside ? std::optional(peak) : std::nullopt;
}

/// How far the spot goes from its mean place in single pairs of images (px).
double motion(const Kept& off, const Kept& on, const Window& w, const Vector2d& mean) {
  const std::size_t pairs = std::min(off.size(), on.size());
  if (pairs < 2) return 0.0;
  std::vector<float> light(on.front()->brightness.size(), 0.0f);
  std::vector<Vector2d> places;
  Vector2d middle = Vector2d::Zero();
  for (std::size_t k = 0; k < pairs; ++k) {
    const int width = on[k]->width;
    for (int v = w.v0; v <= w.v1; ++v)
      for (int u = w.u0; u <= w.u1; ++u) {
        const auto i = static_cast<std::size_t>(v * width + u);
        light[i] = static_cast<float>(on[k]->brightness[i]) - static_cast<float>(off[k]->brightness[i]);
      }
    double sum = 0.0;
    const Vector2d at = centre_of_light(light, width, w, &sum);
    places.push_back(sum > 0.0 ? at : mean);
    middle += places.back() / static_cast<double>(pairs);
  }
  double farthest = 0.0;
  for (const Vector2d& p : places) farthest = std::max(farthest, (p - middle).norm());
  return farthest;
}

Found locate(const Difference& d, const Kept& off, const Kept& on, const Blob& blob,
             const SpotConfig& config) {
  const Window w = around(blob, d.width, d.height, config.window_px);
  Spot spot;
  spot.peak = blob.peak;
  spot.area_px = static_cast<int>(blob.pixels.size());
  for (const int at : blob.pixels) spot.saturated |= d.saturated[static_cast<std::size_t>(at)] != 0;
  double sum = 0.0;
  spot.pixel = centre_of_light(d.mean, d.width, w, &sum);
  if (!(sum > 0.0) || !spot.pixel.allFinite()) return refuse("faint", "the spot holds no light");
  double uu = 0.0, vv = 0.0, uv = 0.0;
  for (int v = w.v0; v <= w.v1; ++v)
    for (int u = w.u0; u <= w.u1; ++u) {
      const double x = u - spot.pixel.x(), y = v - spot.pixel.y();
      uu += x * x, vv += y * y, uv += x * y;
    }
  const double each = d.sigma * d.sigma / (sum * sum);
  spot.covariance << each * uu, each * uv, each * uv, each * vv;
  double floor_px = config.min_sigma_px;
  if (spot.saturated) {
    // a cut-off core pulls the centre of light to its own middle
    if (const auto peak = fit_flanks(d, w, 3.0 * d.sigma)) {
      spot.pixel = *peak;
      floor_px = config.min_fitted_sigma_px;
    } else {
      floor_px = 2.0 * config.min_fitted_sigma_px;
    }
  }
  spot.covariance += floor_px * floor_px * Matrix2d::Identity();

  spot.moved_px = motion(off, on, w, spot.pixel);
  // single pairs are noisier than the mean of all
  const double noise_px = std::sqrt(each * std::max(uu, vv) * static_cast<double>(on.size()));
  if (spot.moved_px > config.move_px + 4.0 * noise_px)
    return refuse("unsteady",
                  fmt::format("the spot moves by {:.2f} px between images (at most {:.2f}): the arm "
                              "is not still",
                              spot.moved_px, config.move_px));
  return spot;
}

Found find(const Kept& off, const Kept& on, const SpotConfig& config) {
  if (off.empty() || on.empty())
    return refuse("images", fmt::format("{} images without and {} with the emitter; one of each is needed",
                                        off.size(), on.size()));
  const Difference d = subtract(off, on, config);
  const double least = config.sigmas * d.sigma;
  // the peak of what is steady: a person who walks by is brighter, but not in every image
  double peak = 0.0, any = 0.0;
  for (std::size_t i = 0; i < d.mean.size(); ++i) {
    const auto m = static_cast<double>(d.mean[i]);
    any = std::max(any, m);
    if (static_cast<double>(d.steady[i]) >= config.steady_fraction * m) peak = std::max(peak, m);
  }
  if (peak < least) {
    if (any >= 2.0 * least)
      return refuse("moving", fmt::format("something moves in the picture (by {:.0f}), and no spot is in all "
                                          "images ({:.0f}, noise {:.1f})",
                                          any, peak, d.sigma));
    return refuse(
        "dark", fmt::format("nothing is brighter with the emitter on: {:.1f}, noise {:.1f}", peak, d.sigma));
  }
  const double threshold = std::max(least, config.peak_fraction * peak);
  const auto blobs = find_blobs(d, static_cast<float>(threshold), config.steady_fraction);
  const Blob *best = nullptr, *second = nullptr, *large = nullptr;
  int small = 0, moving = 0;
  for (const Blob& blob : blobs) {
    const auto area = static_cast<int>(blob.pixels.size());
    if (!blob.steady) {
      ++moving;
    } else if (area < config.min_px) {
      ++small;
    } else if (area > config.max_px) {
      if (!large || blob.light > large->light) large = &blob;
    } else if (!best || blob.light > best->light) {
      second = best;
      best = &blob;
    } else if (!second || blob.light > second->light) {
      second = &blob;
    }
  }
  if (!best) {
    if (large)
      return refuse("large", fmt::format("what is brighter has {} px (at most {}): light from elsewhere",
                                         large->pixels.size(), config.max_px));
    if (moving > 0) return refuse("moving", "something moves in the picture, and no spot is in all images");
    return refuse("faint", fmt::format("{} bright places, none of {} px", small, config.min_px));
  }
  if (second && second->light > config.rival_fraction * best->light)
    return refuse("rival",
                  fmt::format("two spots are alike (light {:.0f} and {:.0f}): one may be a reflection",
                              best->light, second->light));
  if (best->at_border) return refuse("border", "the spot touches the border of the image");
  return locate(d, off, on, *best, config);
}

}  // namespace

Found find_spot(std::span<const hal::InfraredFrame> off, std::span<const hal::InfraredFrame> on,
                const SpotConfig& config) {
  Kept dark, lit;
  for (const auto& f : off) dark.push_back(&f);
  for (const auto& f : on) lit.push_back(&f);
  const auto& first = !on.empty() ? on.front() : hal::InfraredFrame{};
  for (const Kept* all : {&dark, &lit})
    for (const auto* f : *all)
      if (!fits(*f, first.width, first.height))
        return refuse("images",
                      fmt::format("an image of {} x {} with {} pixels among those of {} x {}", f->width,
                                  f->height, f->brightness.size(), first.width, first.height));
  return find(dark, lit, config);
}

Found find_blinking_spot(std::span<const hal::InfraredFrame> frames, const SpotConfig& config) {
  if (frames.size() < 4)
    return refuse("images",
                  fmt::format("{} images are too few to find out which show the emitter", frames.size()));
  const int width = frames.front().width, height = frames.front().height;
  for (const auto& f : frames)
    if (!fits(f, width, height))
      return refuse("images", fmt::format("an image of {} x {} with {} pixels among those of {} x {}",
                                          f.width, f.height, f.brightness.size(), width, height));
  // where brightness changes most, over 3 x 3 pixels, so that noise does not
  const std::size_t n = frames.front().brightness.size();
  std::vector<std::uint16_t> low(n, 0xffff), high(n, 0);
  for (const auto& f : frames)
    for (std::size_t i = 0; i < n; ++i) {
      low[i] = std::min(low[i], f.brightness[i]);
      high[i] = std::max(high[i], f.brightness[i]);
    }
  struct Place {
    int change, u, v;
  };
  std::vector<Place> places;
  constexpr int kBlock = 8;  // pixels; one place each, so that one bright spot does not take all places
  for (int v0 = 1; v0 + kBlock < height; v0 += kBlock)
    for (int u0 = 1; u0 + kBlock < width; u0 += kBlock) {
      Place best{-1, 0, 0};
      for (int v = v0; v < v0 + kBlock; ++v)
        for (int u = u0; u < u0 + kBlock; ++u) {
          int change = 0;
          for (int dv = -1; dv <= 1; ++dv)
            for (int du = -1; du <= 1; ++du) {
              const auto i = static_cast<std::size_t>((v + dv) * width + u + du);
              change += high[i] - low[i];
            }
          if (change > best.change) best = {change, u, v};
        }
      places.push_back(best);
    }
  std::stable_sort(places.begin(), places.end(),
                   [](const Place& a, const Place& b) { return a.change > b.change; });
  const auto most_places = static_cast<std::size_t>(config.blink_places);
  if (places.size() > most_places) places.resize(most_places);

  std::optional<SpotRefusal> first;
  for (const Place& place : places) {
    std::vector<int> light;
    for (const auto& f : frames) {
      int sum = 0;
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du)
          sum += f.brightness[static_cast<std::size_t>((place.v + dv) * width + place.u + du)];
      light.push_back(sum);
    }
    const auto [least, most] = std::minmax_element(light.begin(), light.end());
    const int range = *most - *least;
    Kept off, on;
    for (std::size_t k = 0; k < frames.size(); ++k) {
      if (4 * (light[k] - *least) > 3 * range) on.push_back(&frames[k]);
      if (4 * (light[k] - *least) < range) off.push_back(&frames[k]);
    }
    if (on.size() < 2 || off.size() < 2) continue;
    auto spot = find(off, on, config);
    const Eigen::Vector2d here(place.u, place.v);
    if (spot && (spot->pixel - here).norm() < 12.0) return spot;
    if (!spot && !first) first = spot.error();
  }
  if (first) return tl::unexpected(*first);
  return refuse("dark", "nothing blinks in the picture");
}

std::optional<double> depth_near(const hal::DepthFrame& depth, const Eigen::Vector2d& pixel) {
  constexpr double kInner_px = 5.0, kOuter_px = 12.0, kDeep_m = 0.04;
  constexpr std::size_t kMin = 8;
  const int width = depth.intrinsics.width, height = depth.intrinsics.height;
  if (!pixel.allFinite() || width <= 0 || height <= 0 ||
      depth.depth_m.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
    return std::nullopt;
  const double u0 = pixel.x() - hal::kInfraredColumns, v0 = pixel.y() - hal::kInfraredRows;
  if (!(std::abs(u0) < 1e5) || !(std::abs(v0) < 1e5)) return std::nullopt;
  std::vector<float> ring;
  const int reach = static_cast<int>(kOuter_px) + 1;
  for (int v = static_cast<int>(v0) - reach; v <= static_cast<int>(v0) + reach; ++v)
    for (int u = static_cast<int>(u0) - reach; u <= static_cast<int>(u0) + reach; ++u) {
      if (u < 0 || v < 0 || u >= width || v >= height) continue;
      const double r = std::hypot(u - u0, v - v0);
      const float z = depth.depth_m[static_cast<std::size_t>(v * width + u)];
      if (r >= kInner_px && r <= kOuter_px && z > 0.0f) ring.push_back(z);
    }
  if (ring.size() < kMin) return std::nullopt;
  std::sort(ring.begin(), ring.end());
  // fingers and floor are in the ring too; the quarter points tell whether the palm fills it
  if (static_cast<double>(ring[3 * ring.size() / 4] - ring[ring.size() / 4]) > kDeep_m) return std::nullopt;
  return static_cast<double>(ring[ring.size() / 2]);
}

}  // namespace colift::perception
