#pragma once

#include <array>

#include "hal/hand.hpp"

namespace colift::sim_hal {

/// What the drives of the hand see of it at one moment.
struct HandReading {
  std::array<double, hal::kFingers> inner_rad{}, inner_rad_s{}, outer_rad{}, outer_rad_s{};
  std::array<double, 2> spread_rad{}, spread_rad_s{};
  std::array<double, hal::kFingers> strain_nm{};     ///< Of contacts on the outer link about its joint.
  std::array<double, hal::kFingers> tip_force_n{};   ///< Normal forces on the outer link.
  std::array<double, hal::kFingers> link_force_n{};  ///< Normal forces on both links, but not of fingers.
};

struct HandTorque {
  std::array<double, hal::kFingers> inner_nm{}, outer_nm{};
  std::array<double, 2> spread_nm{};
};

/// The drives of a BarrettHand. One motor per finger turns a worm for the inner and one for the outer link,
/// a third as far. A worm is never turned back by its link: between worm and link there is only the stiffness
/// of the gear, so a motor that stops has locked its finger. The motor stops when its torque, or the strain
/// gauge's at the outer joint, is at the limit; of a grip it then presses on with less, as the driver of the
/// real hand has it do, and follows what gives way. When the inner link is blocked and nothing is at the
/// outer one, the clutch of the inner gear slips (breakaway): its worm stays, the outer link goes on. Ratios
/// and ranges: maker's tables. Opening goes the same way back.
class HandDrive {
 public:
  void preshape(double spread_rad);
  void open() { open({true, true, true}); }
  /// Only these; the worms of the others stay where they are.
  void open(const std::array<bool, hal::kFingers>& which);
  void close(double torque_nm) { close({torque_nm, torque_nm, torque_nm}); }
  /// Each with a limit of its own; a finger with none stays locked.
  void close(const std::array<double, hal::kFingers>& torque_nm);
  void stop();          ///< Fingers stay where they are; a grip is pressed on.
  void power(bool on);  ///< Of the motors: off, the worms alone hold; on, a grip is pressed again.

  /// One step of 1 ms.
  [[nodiscard]] HandTorque tick(const HandReading& reading);

  [[nodiscard]] bool moving() const { return mode_ == Mode::Opening || mode_ == Mode::Closing; }
  /// The last close() ended on contact; until the fingers open, or close through to their stops.
  [[nodiscard]] bool held() const { return held_; }
  [[nodiscard]] bool turns() const;  ///< Any worm, in the last step; also while a grip is pressed.
  /// Number of grasps that ended on contact so far: tells that the fingers were locked anew.
  [[nodiscard]] int grasps() const { return grasps_; }

 private:
  enum class Mode { Still, Opening, Closing, Pressing };
  struct Finger {
    double inner_rad = 0.0, outer_rad = 0.0;      ///< Worms, as angles of their links ...
    double inner_rad_s = 0.0, outer_rad_s = 0.0;  ///< ... and how fast they turn.
    double speed_rad_s = 0.0;                     ///< Of the motor, as an angle of the inner link.
    bool broken_away = false;
    int still_ms = 0;
  };

  static bool at_end(const Finger& finger);
  static void turn_closing(Finger& finger, double load);
  /// Of its motor or its gauge, whichever is nearer to `limit_nm`: 1 there.
  [[nodiscard]] double load_of(std::size_t f, double limit_nm, const HandReading& reading,
                               const HandTorque& gears) const;
  void close_finger(std::size_t f, const HandReading& reading, const HandTorque& gears);
  void press_finger(std::size_t f, const HandReading& reading, const HandTorque& gears);
  [[nodiscard]] bool closed_through() const;
  static bool open_finger(Finger& finger);

  Mode mode_ = Mode::Still;
  std::array<Finger, hal::kFingers> fingers_;
  double spread_rad_ = 0.0, spread_goal_rad_ = 0.0;
  std::array<double, hal::kFingers> limit_nm_{};
  std::array<bool, hal::kFingers> opens_{};
  int still_ms_ = 0, grasps_ = 0;
  bool held_ = false;
};

}  // namespace colift::sim_hal
