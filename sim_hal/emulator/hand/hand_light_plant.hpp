#pragma once

#include <optional>

#include "sim_hal/emulator/hand/hand_plant.hpp"

namespace colift::sim_hal {

/// Something between the fingers, as each of them meets it; unset: not at all.
struct HandObject {
  std::array<std::optional<double>, kHandFingers> inner_rad;  ///< Angle of the inner link that touches it.
  std::array<std::optional<double>, kHandFingers> total_rad;  ///< Of both joints together, when the pad does.
  double palm_n = 0.0;                                        ///< How it rests on the palm.
  std::size_t pad_rows = 0;  ///< How many rows of cells towards the tips it touches, from the pads' middle.

  /// In the middle of the hand, touched by the three pads. Wider than 0.3 m: not at all; the fingers' length
  /// and the bend of 42 degrees in the outer link are those of the maker's tables.
  [[nodiscard]] static HandObject of_width(double width_m);
};

/// Chosen, not published: there is no measured figure of what a unit of torque does at a fingertip.
struct LightHandConfig {
  double tip_units_nm = 2900.0;    ///< Motor's units for 1 N m about the outer joint at the pad ...
  double freed_units_nm = 1400.0;  ///< ... after breakaway, when it drives the outer link alone ...
  double inner_units_nm = 700.0;   ///< ... and for 1 N m on the inner link.
  double pad_nm_rad = 20.0, inner_nm_rad = 60.0;           ///< Stiffness of contact.
  double breakaway_nm = 2.5;                               ///< On the inner link.
  double finger_friction = 200.0, spread_friction = 60.0;  ///< Units.
  double most_speed = 400.0;                               ///< Counts/ms.
};

/// Three fingers with coupled outer joints and a spread, quasi-static: a motor goes on until what it meets
/// takes its torque; worms keep what they have when the torque ends. No physics engine.
class LightHandPlant final : public HandPlant {
 public:
  explicit LightHandPlant(const LightHandConfig& config = {}) : config_(config) {}

  void put(const HandObject& object) { object_ = object; }
  void take_away() { object_ = {}; }
  /// Where a motor stands when the test begins, in counts.
  void place(std::size_t puck, double motor);
  [[nodiscard]] bool broken_away(std::size_t finger) const { return fingers_[finger].frozen_at.has_value(); }

  void command(std::size_t puck, const HandMotor& motor) override { motors_[puck] = motor; }
  void tighten(std::size_t finger) override { fingers_[finger].frozen_at.reset(); }
  void advance(hal::Duration by) override;
  [[nodiscard]] HandJoint joint(std::size_t puck) const override;

 private:
  struct Finger {
    double motor = 0.0, torque = 0.0;
    std::optional<double> frozen_at;  // counts of the motor when the inner link's clutch gave way
  };

  void tick(std::size_t puck);
  [[nodiscard]] double inner_rad(const Finger& finger, double motor) const;
  [[nodiscard]] double pad_nm(std::size_t finger, double motor) const;
  [[nodiscard]] double inner_nm(std::size_t finger, double motor) const;
  [[nodiscard]] double load(std::size_t puck, double motor) const;

  LightHandConfig config_;
  HandObject object_;
  std::array<HandMotor, kHandPucks> motors_{};
  std::array<Finger, kHandPucks> fingers_{};
};

}  // namespace colift::sim_hal
