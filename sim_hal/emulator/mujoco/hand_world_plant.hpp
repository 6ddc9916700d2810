#pragma once

#include "sim_hal/emulator/hand_plant.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

struct HandWorldConfig {
  bool moves_world = false;      ///< Nobody else moves the world's time.
  double tip_units_nm = 2900.0;  ///< Motor's units for 1 N m at a fingertip.
};

/// The hand of a simulated world behind four pucks. The world knows moves of the whole hand only, so: three
/// fingers close or open together, at the world's own speeds and with the greatest torque of the three; the
/// spread turns when the fingers are open; a finger that goes the other way than its neighbours stays. What
/// stalls, breaks away, is felt and is held comes from the physics.
class HandWorldPlant final : public HandPlant {
 public:
  /// The world has to outlive the plant.
  explicit HandWorldPlant(SimWorld& world, const HandWorldConfig& config = {});

  void command(std::size_t puck, const HandMotor& motor) override { motors_[puck] = motor; }
  void tighten(std::size_t) override {}  // the world's clutches close by themselves on the way back
  void advance(hal::Duration by) override;
  [[nodiscard]] HandJoint joint(std::size_t puck) const override { return joints_[puck]; }

 private:
  enum class Move { None, Close, Open, Turn };

  void tell_world();
  void begin(Move move, double torque_nm, double spread_rad);
  void read_world();
  [[nodiscard]] Move wished() const;
  [[nodiscard]] double way(std::size_t puck) const { return motors_[puck].goal - joints_[puck].motor; }

  SimWorld& world_;
  HandWorldConfig config_;
  std::array<HandMotor, kHandPucks> motors_{};
  std::array<HandJoint, kHandPucks> joints_{};
  Move move_ = Move::None;
  double told_nm_ = 0.0, told_rad_ = 0.0;
  int since_told_ms_ = 0, without_wish_ms_ = 0;
  bool world_moves_ = false, touches_ = false;
};

}  // namespace colift::sim_hal
