#include "hal/drivers/barrett_can/tactile/pattern_slip.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace colift::hal::barrett {
namespace {

// Rows from the root of a fingertip, along the pad, and columns across it (mm, maker's geometry; the last
// rows bend around the tip).
constexpr std::array<double, 8> kRow_mm{0.0, 6.0, 12.0, 18.0, 24.0, 29.1, 32.5, 36.0};
constexpr double kColumn_mm = 5.2;

struct Centre {
  double along_mm = 0.0, across_mm = 0.0;
};

std::optional<Centre> centre_of(const TactileArray& pad, double min_n_cm2) {
  Centre c;
  double sum = 0.0;
  for (std::size_t i = 0; i < pad.pressure_n_cm2.size(); ++i) {
    const double p = pad.pressure_n_cm2[i];
    if (std::isnan(p)) return std::nullopt;
    sum += p;
    c.along_mm += p * kRow_mm[i / 3];
    c.across_mm += p * kColumn_mm * (static_cast<double>(i % 3) - 1.0);
  }
  if (sum < min_n_cm2) return std::nullopt;
  c.along_mm /= sum;
  c.across_mm /= sum;
  return c;
}

}  // namespace

void PatternSlip::add(const std::array<TactileArray, kFingers>& pads,
                      const std::array<bool, kFingers>& holding) {
  for (std::size_t f = 0; f < pads_.size(); ++f) {
    Pad& pad = pads_[f];
    const auto centre = holding[f] ? centre_of(pads[f], limits_.min_n_cm2) : std::nullopt;
    if (!centre) {
      pad = {};  // a pad that lifts off and comes down elsewhere has not slid there
      continue;
    }
    if (pad.known && pads[f].measured_at <= pad.at) continue;
    const double dt_s = seconds(pads[f].measured_at - pad.at);
    pad.at = pads[f].measured_at;
    if (!pad.known) {
      pad.known = true;
      pad.along_mm = centre->along_mm;
      pad.across_mm = centre->across_mm;
      continue;
    }
    const double along = centre->along_mm - pad.along_mm, across = centre->across_mm - pad.across_mm;
    pad.moved = std::hypot(along, across) > limits_.moved_mm;
    if (pad.moved) continue;
    const double by = std::min(1.0, dt_s / limits_.follows_s);
    pad.along_mm += by * along;
    pad.across_mm += by * across;
  }
  if (std::count_if(pads_.begin(), pads_.end(), [](const Pad& p) { return p.moved; }) >= 2) slipped_ = true;
}

}  // namespace colift::hal::barrett
