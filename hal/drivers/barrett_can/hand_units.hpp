#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <optional>

#include "hal/drivers/barrett_can/pucks/puck_codec.hpp"

namespace colift::hal::barrett {

// Gears of the 280 and 282 (maker's wiki and library): 4096 counts per turn of a motor; inner link 125:1,
// outer link another 375:1 on top, spread 17.5:1; the joint encoder sits on the inner link's worm, 50:1.
inline constexpr double kCountsPerTurn = 4096.0;
inline constexpr double kTurn_rad = 2.0 * std::numbers::pi;
inline constexpr double kFingerCounts_rad =
    kCountsPerTurn * 125.0 / kTurn_rad;  ///< 81487.33, before breakaway.
inline constexpr double kJointCounts_rad = kCountsPerTurn * 50.0 / kTurn_rad;  ///< 32594.93.
inline constexpr double kBothCounts_rad =                                      ///< 61115.50.
    kCountsPerTurn / (kTurn_rad * (1.0 / 125.0 + 1.0 / 375.0));
inline constexpr double kSpreadCounts_rad = kCountsPerTurn * 17.5 / kTurn_rad;  ///< 11408.23.

inline constexpr std::int32_t kClosedCounts = 195'000;  ///< Factory's CT of a finger; its stop is at 199 111.
inline constexpr std::int32_t kClosedSpreadCounts = 35'950;  ///< Factory's CT of the spread.

/// Written into CT once the zero is known. A reset brings back the factory's value, so that it tells an
/// initialised puck from one that was off meanwhile (as OWD does with its own number).
[[nodiscard]] constexpr std::int32_t zero_mark(Puck puck) {
  return puck == Puck::Spread ? 35'949 : 194'987;
}
[[nodiscard]] constexpr std::int32_t factory_ct(Puck puck) {
  return puck == Puck::Spread ? kClosedSpreadCounts : kClosedCounts;
}
inline constexpr std::int32_t kBreakawayCounts =
    9'500;  ///< Of P - 2.5 JP: the clutch of the finger has given way.

struct FingerAngles {
  double inner_rad = 0.0;
  double outer_rad = 0.0;  ///< Against the inner link.
};

[[nodiscard]] inline FingerAngles finger_angles(std::int32_t motor, std::optional<std::int32_t> joint) {
  const double inner = joint ? *joint / kJointCounts_rad : motor / kFingerCounts_rad;
  return {inner, motor / kBothCounts_rad - inner};
}

[[nodiscard]] inline bool broken_away(std::int32_t motor, std::optional<std::int32_t> joint) {
  return joint && motor - 2.5 * *joint > kBreakawayCounts;
}

[[nodiscard]] inline std::int32_t spread_counts(double rad) {
  return static_cast<std::int32_t>(std::lround(rad * kSpreadCounts_rad));
}

/// Torque about the outer joint from a strain gauge's 12 bits (N m). One unit's calibration as Barrett's
/// Python client has it: 30 % off on another; take differences.
[[nodiscard]] inline double strain_nm(double counts) {
  return ((2.754e-10 * counts - 1.708e-6) * counts + 0.003764) * counts - 2.85;
}

/// The counts at which the gauge shows `above_nm` more than at `idle`; nullopt beyond what it can show.
[[nodiscard]] inline std::optional<int> strain_counts(double idle, double above_nm) {
  const double wanted = strain_nm(idle) + above_nm;
  double low = idle, high = 4095.0;
  if (strain_nm(high) < wanted) return std::nullopt;
  while (high - low > 0.5) {
    const double middle = 0.5 * (low + high);
    (strain_nm(middle) < wanted ? low : high) = middle;
  }
  return static_cast<int>(std::lround(high));
}

/// From here on a gauge is strained as far as it may be: a puck protects itself above 3460 (and below 667).
inline constexpr int kStrainMost = 3400;

/// Amperes from IMOTOR.
[[nodiscard]] inline double motor_a(std::int32_t counts) {
  return (counts - 2048) / 205.0;
}

/// Normal force on a pad (N): pressure times area over its cells. Areas in cm2 from the pads' geometry: a
/// fingertip has five rows of three wide cells and three rows of narrow ones, the palm cells of 10 x 9.7 mm.
[[nodiscard]] inline double pad_force_n(Puck puck, const std::array<std::uint16_t, kTactileCells>& cells) {
  double force = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const double area_cm2 = puck == Puck::Spread ? 0.97 : i < 15 ? 0.26 : 0.14;
    force += cells[i] / 256.0 * area_cm2;
  }
  return force;
}

}  // namespace colift::hal::barrett
