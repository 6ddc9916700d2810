#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "hal/can_bus.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/hand.hpp"
#include "hal/types/short_text.hpp"
#include "hal/types/time.hpp"

namespace colift::hal {

/// What the hand reports beyond HandState, for an operator and for reactions. Index 3 is the spread.
struct HandReport {
  bool slipped = false;  ///< The object leaves the grip; until the next release().
  bool loaded = false;   ///< From the first contact of close() to the end of release().
  bool warm = false;     ///< Go slower: it holds with less torque.
  bool hot = false;      ///< Loaded: lower the object. Not loaded: close() is refused.
  bool over_torque = false;
  CanHealth::State bus = CanHealth::State::Closed;  ///< Warning and Passive: go slower.
  std::array<bool, 4> silent{}, zero_lost{};
  std::array<bool, kFingers> broken_away{};  ///< The clutch of the inner link has given way.
  std::array<double, 4> temperature_c{};     ///< Of puck or motor, the hotter; NaN when not reported.
  double palm_force_n = 0.0;                 ///< NaN without tactile pads.
  std::uint64_t error_frames = 0, bus_offs = 0, not_sent = 0;
  /// MODE of each motor as it was read back after deactivate(); nullopt: not read back, so not known.
  std::array<std::optional<std::int32_t>, 4> mode_at_rest{};
  ShortText why;      ///< How the last move ended, if not as wished.
  ShortText warning;  ///< Heat, torque, another program that asks.
  ShortText remark;   ///< Of the start: what does not keep the hand from working.
};

/// What deactivate() read back of the motors, in one sentence: who rests, who keeps its angle, who goes on
/// pressing, of whom it is not known.
[[nodiscard]] std::string motors_at_rest(const HandReport& report);
/// All three fingers were read back as idle.
[[nodiscard]] bool fingers_rest(const HandReport& report);

/// The BarrettHand BH8-282 (and 280) over a CAN bus. The bus and the clock have to outlive the hand, and time
/// stamps of frames have to be of that clock.
///
/// Nobody but the caller lets it run: every call of state() takes in answers and sends what is due, and costs
/// some ten microseconds; it has to come every few milliseconds (HandThread does that). state() waits, up to
/// 3 ms, only when it was not called for more than 30 ms. It allocates nothing but to report a fault. While a
/// lost gateway is opened again, one call a second may take as long as CanBus::open(). configure() waits for
/// the pucks and opens the hand to find its zeros, when those are not known and nothing is held.
///
/// Errors of state(): LinkLost (bus lost, a puck silent), DeviceFault (a puck reset, out of its mode, in
/// error), Timeout (no fresh positions). Fingers keep their torque through all of them. `where` names a puck
/// that is silent alone: "hand.f2.state", "hand.spread".
class BarrettHand final : public Hand {
 public:
  BarrettHand(CanBus& bus, const BarrettHandConfig& config, const Clock& clock);
  ~BarrettHand() override;

  /// Errors: BadConfig (bus, settings), LinkLost (interface, supply, termination, bit rate, silent puck: in
  /// words), DeviceFault (wrong firmware, stop not found), NotReady (needs initialising and may not). When
  /// the hand is loaded nothing moves.
  Result<> configure() override;
  Result<> activate() override;
  /// The motors rest, the worms keep what is held; the spread of a loaded hand, which has none, keeps its
  /// angle. Waits up to 0.1 s to get that through and to read it back: report().mode_at_rest.
  void deactivate() noexcept override;
  [[nodiscard]] DeviceHealth health() const override;

  Result<HandState> state() override;
  Result<> preshape(double spread_rad) override;
  /// Refused with DeviceFault when the hand is too hot.
  Result<> close(double torque_nm) override;
  /// Also with a silent or reset puck, as far as the others go. From then on state() tells of the others,
  /// with a warning and the silent one's last known angle, until another falls silent.
  Result<> release() override;
  void stop() noexcept override;  ///< Takes effect with the next state().

  /// From any thread.
  [[nodiscard]] HandReport report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::hal
