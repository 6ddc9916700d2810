#include "hal/drivers/recorded/pixel_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace colift::hal {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

struct Sum {
  double coherence = 0.0;  // 1 when all points are on the grid, about 1/sqrt(n) when none is
  double phase = 0.0;      // of the grid, in pixels
};

Sum add_up(const std::vector<double>& tangents, double focal) {
  double re = 0.0, im = 0.0;
  for (const double a : tangents) {
    const double angle = kTurn * focal * a;
    re += std::cos(angle);
    im += std::sin(angle);
  }
  return {std::hypot(re, im) / static_cast<double>(tangents.size()), -std::atan2(im, re) / kTurn};
}

}  // namespace

std::optional<PixelGrid> find_pixel_grid(const std::vector<float>& tangents, double focal_estimate) {
  constexpr std::size_t kSamples = 1000;
  constexpr double kMinCoherence = 0.5;
  if (tangents.size() < 100) return std::nullopt;
  const auto [least, most] = std::minmax_element(tangents.begin(), tangents.end());
  const double low = *least, extent = double{*most} - low;
  if (!(extent > 1e-6) || !(focal_estimate > 0.0)) return std::nullopt;
  std::vector<double> sample;
  for (std::size_t i = 0; i < tangents.size(); i += tangents.size() / kSamples + 1)
    sample.push_back(tangents[i] - low);

  // the peak is 1 / extent wide: four steps across it cannot miss it
  const double step = 0.25 / extent;
  const double first = 0.8 * focal_estimate, last = 1.6 * focal_estimate;
  if ((last - first) / step > 1e5) return std::nullopt;
  double focal = first;
  Sum best;
  for (double f = first; f <= last; f += step) {
    const Sum sum = add_up(sample, f);
    if (sum.coherence > best.coherence) {
      best = sum;
      focal = f;
    }
  }
  if (best.coherence < kMinCoherence) return std::nullopt;
  for (double width = step / 2; width > step / 1000; width /= 2) {
    for (const double f : {focal - width, focal + width}) {
      const Sum sum = add_up(sample, f);
      if (sum.coherence > best.coherence) {
        best = sum;
        focal = f;
      }
    }
  }

  // all points name their pixel now; least squares gives what the search could only bracket
  double offset = best.phase;
  for (int round = 0; round < 3; ++round) {
    double n = 0.0, sa = 0.0, sp = 0.0, saa = 0.0, sap = 0.0;
    for (const float tangent : tangents) {
      const double a = tangent - low;
      const double pixel = std::round(focal * a + offset);
      if (std::abs(focal * a + offset - pixel) > 0.35) continue;
      n += 1.0;
      sa += a;
      sp += pixel;
      saa += a * a;
      sap += a * pixel;
    }
    // what lies between the pixels would be drawn in the wrong place
    if (n < 0.9 * static_cast<double>(tangents.size())) return std::nullopt;
    const double variance = saa - sa * sa / n;
    if (!(variance > 0.0)) return std::nullopt;
    focal = (sap - sa * sp / n) / variance;
    offset = (sp - focal * sa) / n;
  }
  const double first_pixel = std::round(offset), last_pixel = std::round(focal * extent + offset);
  if (!(last_pixel - first_pixel < 1e6)) return std::nullopt;
  return PixelGrid{focal, offset - first_pixel - focal * low, static_cast<int>(last_pixel - first_pixel) + 1};
}

}  // namespace colift::hal
