#include "hal/drivers/kinect/depth_table.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/drivers/kinect/kinect_facts.hpp"

namespace colift::hal::kinect {
namespace {

constexpr double kFarthest_mm = 10'000.0;  // the device's own conversion ends there too
constexpr double kNearest_mm = 400.0;      // no recording holds less than 450; code 0 would be 317
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

}  // namespace

bool plausible(const DepthConstants& c) {
  const auto near = [](double v, double nominal) { return v > 0.8 * nominal && v < 1.25 * nominal; };
  const DepthConstants nominal;
  return near(c.emitter_cm, nominal.emitter_cm) && near(c.reference_cm, nominal.reference_cm) &&
         near(c.pixel_cm, nominal.pixel_cm) && near(c.shift, nominal.shift);
}

DepthTable::DepthTable(const DepthConstants& c)
    : constants_(c),
      k_mm_(40.0 * c.reference_cm * c.emitter_cm / c.pixel_cm),
      at_infinity_(4.0 * (c.emitter_cm / c.pixel_cm + 0.375) + 4.0 * c.shift) {
  for (std::size_t raw = 0; raw < z_m_.size(); ++raw) {
    const double left = at_infinity_ - static_cast<double>(raw);
    const double z_mm = left > 0.0 ? std::trunc(k_mm_ / left) : kFarthest_mm;
    z_m_[raw] = raw == kNoDepth || z_mm >= kFarthest_mm || z_mm < kNearest_mm
                    ? kNan
                    : static_cast<float>(z_mm / 1000.0);
  }
}

void DepthTable::convert(std::span<const std::uint16_t> raw, std::vector<float>& depth_m) const {
  depth_m.resize(raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) depth_m[i] = metres(raw[i]);
}

std::uint16_t DepthTable::nearest_code(float depth_m) const {
  if (!(depth_m > 0.0f)) return kNoDepth;
  const double guess = std::round(at_infinity_ - k_mm_ / (1000.0 * static_cast<double>(depth_m)));
  if (!(guess >= -0.5 && guess <= 1100.0)) return kNoDepth;
  // truncation to millimetres moves a depth by up to one: a neighbour may be nearer
  std::uint16_t best = kNoDepth;
  float least = std::numeric_limits<float>::infinity();
  for (int raw = std::max(0, static_cast<int>(guess) - 3); raw <= static_cast<int>(guess) + 3; ++raw) {
    const float off = std::abs(metres(static_cast<std::uint16_t>(raw)) - depth_m);
    if (off < least) least = off, best = static_cast<std::uint16_t>(raw);
  }
  return best;
}

}  // namespace colift::hal::kinect
