#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "hal/drivers/barrett_can/hand_units.hpp"
#include "hal/drivers/barrett_can/pucks/puck_link.hpp"
#include "hal/hand.hpp"
#include "hal/types/short_text.hpp"

namespace colift::hal::barrett {

/// A position that was judged: a jump that the motor cannot make is not taken over.
struct GoodPosition {
  std::int32_t motor = 0;
  std::optional<std::int32_t> joint;
  Timestamp at{0};
  bool known = false;
};

/// What start-up found out about the hand, and what was lost of it since.
struct HandFacts {
  bool has_strain = false, has_tactile = false;
  int tactile_format = kTactOff;
  std::array<bool, kPucks> pad_works{};
  std::array<bool, kPucks>
      zero_lost{};  ///< Its encoder's zero is not that of the joint: it has to be found anew.
  /// Why the zero is lost: the encoder jumped by so many counts; 0: the puck was reset.
  std::array<std::int32_t, kPucks> jumped_by{};
  std::array<bool, kPucks> mode_lost{};  ///< It fell out of the mode that it was told.
  bool commanded_by_others = false;      ///< Nothing is renewed then: two programs would pull at one finger.
  std::array<GoodPosition, kPucks> good{};
  std::array<bool, kPucks> jump_pending{};  ///< Its last position was no possible one: it is asked once more.
  std::array<double, kFingers> strain_idle{2048.0, 2048.0, 2048.0};  ///< Of an open hand.
  /// Of HandCalibration, or what was configured: true torque over that of the maker's curve, units of the
  /// motor.
  std::array<double, kFingers> strain_scale{1.0, 1.0, 1.0}, units_per_nm{};
  std::array<double, kFingers> otemp_c{60.0, 60.0, 60.0};  ///< Where its puck gives no torque any more.
};

/// Words without allocation.
template <class... Args>
void say(ShortText& text, fmt::format_string<Args...> format, Args&&... args) {
  std::array<char, 184> letters{};
  const auto end = fmt::format_to_n(letters.data(), letters.size(), format, std::forward<Args>(args)...);
  text.set({letters.data(), std::min(end.size, letters.size())});
}

/// Torque about a finger's outer joint above that of the open hand (N m); NaN without gauges or usable
/// answer.
[[nodiscard]] inline double strain_above_idle(const PuckLink& link, const HandFacts& facts, Puck finger) {
  const Reported& sg = link.reported(finger, Property::Sg);
  const bool twelve_bits = sg.value >= 0 && sg.value <= 4095;  // others do not come from a gauge
  if (!facts.has_strain || !sg.known || !twelve_bits) return std::numeric_limits<double>::quiet_NaN();
  return facts.strain_scale[index(finger)] *
         (strain_nm(sg.value) - strain_nm(facts.strain_idle[index(finger)]));
}

/// The counts at which a finger's gauge shows a torque above that of the open hand; the most that it may be
/// strained, where it would be more.
[[nodiscard]] inline int strain_limit(const HandFacts& facts, Puck finger, double torque_nm) {
  const double shown_nm = torque_nm / facts.strain_scale[index(finger)];
  return std::min(strain_counts(facts.strain_idle[index(finger)], shown_nm).value_or(kStrainMost),
                  kStrainMost);
}

/// Fraction of the torque asked for that a finger's puck gives at its temperature: all of it below OTEMP -
/// 16, none at OTEMP (maker's library). 1 while the temperature is not known.
[[nodiscard]] inline double torque_fraction(const PuckLink& link, const HandFacts& facts, Puck finger) {
  constexpr double kDerates_k = 16.0;
  const Reported& temp = link.reported(finger, Property::Temp);
  if (!temp.known) return 1.0;
  return std::clamp((facts.otemp_c[index(finger)] - temp.value) / kDerates_k, 0.0, 1.0);
}

/// Force on a pad (N); NaN without pads, or when the last whole scan is older than 0.3 s.
[[nodiscard]] inline double pad_force(const PuckLink& link, const HandFacts& facts, Puck puck,
                                      Timestamp now) {
  const PadScan& pad = link.pad(puck);
  if (!facts.pad_works[index(puck)] || !pad.known || now - pad.at > std::chrono::milliseconds(300))
    return std::numeric_limits<double>::quiet_NaN();
  return pad_force_n(puck, pad.cells);
}

/// The cells of a pad; NaN as pad_force().
[[nodiscard]] inline TactileArray pad_cells(const PuckLink& link, const HandFacts& facts, Puck puck,
                                            Timestamp now) {
  TactileArray array;
  const PadScan& pad = link.pad(puck);
  if (!facts.pad_works[index(puck)] || !pad.known || now - pad.at > std::chrono::milliseconds(300))
    return array;
  array.measured_at = pad.at;
  static_assert(kTactileCells == kArrayCells);
  for (std::size_t i = 0; i < kArrayCells; ++i)
    array.pressure_n_cm2[i] = static_cast<float>(pad.cells[i]) / 256.0F;
  return array;
}

}  // namespace colift::hal::barrett
