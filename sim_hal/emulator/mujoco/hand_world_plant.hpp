#pragma once

#include "sim_hal/emulator/hand/hand_plant.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

struct HandWorldConfig {
  bool moves_world = false;      ///< Nobody else moves the world's time.
  double tip_units_nm = 2900.0;  ///< Motor's units for 1 N m at a fingertip.
};

/// The hand of a simulated world behind four pucks. Each finger closes with its own torque, at the world's
/// speeds; while any opens, none closes; the spread turns when the fingers are open. What stalls, breaks away
/// and is felt comes from the physics; a motor that is switched off has locked its worm.
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
  struct Request {
    Move move = Move::None;
    std::array<double, kHandFingers> torque_nm{};  ///< Of closing fingers; 0: stays.
    std::array<bool, kHandFingers> opens{};
    double spread_rad = 0.0;
  };

  void tell_world();
  void begin(const Request& request);
  void read_world();
  [[nodiscard]] Request wished() const;
  [[nodiscard]] bool differs(const Request& request) const;
  [[nodiscard]] bool yielded(const Request& request) const;
  [[nodiscard]] double way(std::size_t puck) const { return motors_[puck].goal - joints_[puck].motor; }

  SimWorld& world_;
  HandWorldConfig config_;
  std::array<HandMotor, kHandPucks> motors_{};
  std::array<HandJoint, kHandPucks> joints_{};
  Request request_;
  int since_request_ms_ = 0;
  bool world_moves_ = false, touches_ = false;
};

}  // namespace colift::sim_hal
