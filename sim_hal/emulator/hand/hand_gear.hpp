#pragma once

#include <array>
#include <cstddef>
#include <numbers>

namespace colift::sim_hal {

inline constexpr std::size_t kHandPucks = 4;  ///< F1, F2, F3 and, last, the spread.
inline constexpr std::size_t kHandFingers = 3;
inline constexpr std::size_t kHandSpread = 3;  ///< Index of the spread's puck.
inline constexpr std::size_t kHandCells = 24;  ///< Of a tactile pad.
inline constexpr int kFirstHandNode = 11;

// Gears of the BH8-280 and 282 (maker's wiki and manual): 4096 counts per motor turn, inner link 125:1, outer
// link 1/375 of a turn more, spread 17.5:1; the joint encoder sits on the inner link's worm, 50:1.
inline constexpr double kHandTurn = 4096.0, kHandTurn_rad = 2.0 * std::numbers::pi;
inline constexpr double kInnerCounts_rad = kHandTurn * 125.0 / kHandTurn_rad;  ///< 81487, before breakaway.
inline constexpr double kTotalCounts_rad =
    kHandTurn / (kHandTurn_rad * (1.0 / 125.0 + 1.0 / 375.0));  ///< 61116: both joints together, always.
inline constexpr double kWormCounts_rad = kHandTurn * 50.0 / kHandTurn_rad;  ///< 32595, of JP.
inline constexpr double kSpreadGear_rad = kHandTurn * 17.5 / kHandTurn_rad;  ///< 11408.
inline constexpr double kFingerStop = 199'111.0;  ///< Counts at the closed end (manual: 140 degrees).
inline constexpr double kSpreadStop = 36'000.0;   ///< A little beyond the factory's CT of 35 950.

/// Strain gauge (N m about the outer joint) of 12 bits, one unit's calibration as the maker's Python client
/// has it; rises throughout.
[[nodiscard]] constexpr double hand_strain_nm(double counts) {
  return ((2.754e-10 * counts - 1.708e-6) * counts + 0.003764) * counts - 2.85;
}

/// Area of a tactile cell (cm2): fingertips have five rows of three larger and three rows of smaller cells.
[[nodiscard]] constexpr double hand_cell_cm2(bool palm, std::size_t cell) {
  return palm ? 0.97 : cell < 15 ? 0.26 : 0.14;
}

}  // namespace colift::sim_hal
