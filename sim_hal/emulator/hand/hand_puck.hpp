#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/types/time.hpp"
#include "sim_hal/emulator/hand/hand_plant.hpp"
#include "sim_hal/emulator/hand/hand_property.hpp"
#include "sim_hal/emulator/hand/hand_wire.hpp"

namespace colift::sim_hal {

/// One puck of the hand as it was built, and how quick it is.
struct HandPuckConfig {
  int firmware = 200;
  int finger_role = 0x1e05, spread_role = 0x1605;  ///< 0x0800 strain gauge, 0x1000 tactile.
  int group_c = 5;                                 ///< Hands of 2010 have 8.
  bool awake = false;                              ///< Was woken before, and has found its zero.
  double boot_s = 0.9;
  double auto_ready_s = 0.0;     ///< Newer firmware leaves its monitor by itself after 2 s; 0: it does not.
  double hi_silence_s = 0.6;     ///< Says nothing when it begins to initialise.
  bool answers_unknown = false;  ///< With 0; else it says nothing.
  double ambient_c = 28.0;
  std::array<int, kHandFingers> strain_idle{2012, 2041, 1996};
  /// True torque over that of the maker's curve; gauges of other hands differ by 30 %.
  std::array<double, kHandFingers> strain_scale{1.0, 1.0, 1.0};
};

/// Firmware of one motor controller: properties, modes, moves, what ends them. Knows no bus: the emulator
/// asks and sets; every millisecond it decides on its motor and looks at what became of it.
class HandPuck {
 public:
  enum class Taken { Yes, Unknown, ReadOnly, Asleep };
  enum class Life { Monitor, Booting, Error, Ready };

  HandPuck(std::size_t index, const HandPuckConfig& config);

  /// Power comes on; how its motor stands then.
  void start(const HandJoint& joint);

  [[nodiscard]] int node() const { return node_; }
  [[nodiscard]] Life life() const { return life_; }
  [[nodiscard]] bool ready() const { return life_ == Life::Ready; }
  [[nodiscard]] bool deaf() const { return life_ == Life::Booting || quiet_ms_ > 0.0; }
  [[nodiscard]] bool listens_to(int group) const;
  [[nodiscard]] bool knows(int property) const;

  /// Nullopt: it says nothing.
  [[nodiscard]] std::optional<std::int32_t> get(int property) const;
  Taken set(int property, std::int32_t value);
  [[nodiscard]] std::int32_t value(int property) const { return ram_[static_cast<std::size_t>(property)]; }

  [[nodiscard]] std::int32_t position() const;  ///< As its encoder tells, from its own zero.
  [[nodiscard]] std::int32_t joint() const;
  [[nodiscard]] bool has_joint() const { return index_ != kHandSpread; }
  [[nodiscard]] bool has_pad() const;
  [[nodiscard]] HandCells cells() const;
  [[nodiscard]] bool moving() const { return mode() != 0 || finding_; }
  [[nodiscard]] bool finding() const { return finding_; }

  /// Bends its outer link open (N m), beside what it meets by itself.
  void hang(double weight_nm) { weight_nm_ = weight_nm; }
  [[nodiscard]] HandMotor decide();  ///< For the next millisecond.
  /// After it. True: the motor was driven against its stop and the clutch is tight.
  [[nodiscard]] bool look(const HandJoint& joint);

  // What may happen to it.
  void reset();                             ///< Power was gone: monitor, zero lost.
  void fail(int error_code);                ///< STAT 1.
  void supply(double v);                    ///< VBUS from now on.
  void heat(double c);                      ///< Puck and motor have this temperature now.
  void shift(double counts);                ///< Its encoder jumps.
  void freeze(bool yes) { frozen_ = yes; }  ///< Its encoder tells the same position for ever.
  [[nodiscard]] double temperature_c() const { return puck_c_; }

 private:
  [[nodiscard]] int mode() const { return ram_[prop::kMode]; }
  std::int32_t& at(int property) { return ram_[static_cast<std::size_t>(property)]; }
  void set_mode(int mode);
  void command(int code);
  void move_to(std::int32_t target, int speed_property);
  void end_move();
  void load_flash();
  void warm_up(double torque);
  [[nodiscard]] double torque_limit() const;
  [[nodiscard]] bool strain_stops() const;
  [[nodiscard]] double trapezoid(double from, double to) const;

  std::size_t index_;
  int node_;
  HandPuckConfig config_;
  Life life_ = Life::Monitor;
  std::array<std::int32_t, 128> ram_{}, flash_{};
  HandJoint now_;
  double zero_ = 0.0, joint_zero_ = 0.0;  // counts of the plant at which it tells 0
  double frozen_motor_ = 0.0, frozen_joint_ = 0.0;
  double speed_ = 0.0, wished_ = 0.0;  // counts/ms
  double set_point_ = 0.0;             // of MODE 3, own counts
  int speed_property_ = prop::kMv;
  double boot_ms_ = 0.0, quiet_ms_ = 0.0, still_ms_ = 0.0, up_ms_ = 0.0;
  bool finding_ = false, frozen_ = false, protects_ = true;
  std::array<double, kHandCells> tare_{};
  double puck_c_, motor_c_;
  double weight_nm_ = 0.0;
};

}  // namespace colift::sim_hal
