#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/hand_facts.hpp"
#include "hal/drivers/barrett_can/slip_detector.hpp"
#include "hal/drivers/barrett_can/tactile/pattern_slip.hpp"

namespace colift::hal::barrett {

/// Moves of the hand, a step at a time: open, turn the spread, close until held, feel the grip, keep it, let
/// go. Gives the pucks their settings through the link and reads there how far they are; never waits.
class HandMotion {
 public:
  enum class Phase { Still, Opening, Turning, Closing, Verifying, Held };

  HandMotion(const BarrettHandConfig& config, PuckLink& link, HandFacts& facts);

  void preshape(double spread_rad);
  void close(double torque_nm);
  void release();
  void stop();  ///< Fingers stay where they are; a grip is kept.
  void idle();  ///< The motors rest; the worms keep what is held.
  /// A puck that counts from elsewhere may take the end of its move for behind it, and run back: a finger
  /// rests on its worm, the spread, which has none, keeps where it stands.
  void stay_without_zero(Puck puck);
  void resume();   ///< After idle(): what is held is pressed again.
  void abandon();  ///< The bus was lost: nothing more is said, the pucks do what they were told last.
  void assume_loaded() { loaded_ = true; }
  void forget_pressing() { pressing_ = false; }  ///< The motors may have been off meanwhile; see resume().
  void step(Timestamp now);

  /// The puck ended the mode by itself to protect its strain gauge: enough pressure, and the worm keeps it.
  /// It presses again when the strain has fallen.
  void rest(Puck finger);

  /// Most torque to keep up while holding, in units of the pucks; 0: the worms alone.
  void limit_hold(double units);

  [[nodiscard]] Phase phase() const { return phase_; }
  [[nodiscard]] bool moving() const { return phase_ != Phase::Still && phase_ != Phase::Held; }
  [[nodiscard]] bool held() const { return phase_ == Phase::Held; }
  /// From the first contact of a close() to the end of a release(): the hand must not open by itself.
  [[nodiscard]] bool loaded() const { return loaded_; }
  [[nodiscard]] bool slipped() const { return slip_.slipped() || pattern_.slipped() || spread_turned_; }
  /// The last close() came to no grip, or lost it; until the next motion.
  [[nodiscard]] bool grip_failed() const { return grip_failed_; }
  /// The motors press now; a puck that says another mode than trapezoid has lost it.
  [[nodiscard]] bool pressing(Puck finger, Timestamp now) const;
  /// Its motor may have ended the pressing by itself, because nobody renewed it (a bus that was lost).
  [[nodiscard]] bool pressing_ran_out(Puck finger, Timestamp now) const;
  /// The spread was told to keep its angle, under a load that may turn it.
  [[nodiscard]] bool keeps_spread() const { return loaded_ && !moving() && spread_kept_.has_value(); }
  [[nodiscard]] const ShortText& why() const { return why_; }

 private:
  static constexpr std::int32_t kNear = 600;  ///< Of its target a stopped puck has reached it (as in OWD).
  static constexpr int kTries = 3;
  static constexpr Duration kModeSettles =
      std::chrono::milliseconds(30);  ///< Longer than the slowest answer.

  enum class End { None, Reached, Stalled, NoMotion, Refused, Silent, TooLong };
  struct Move {
    bool active = false, started = false;
    std::int32_t start = 0, target = 0, last = 0;
    Timestamp started_at{0}, moved_at{0};
    int tries = 0;
    End end = End::None;
  };

  /// As it was accepted: a reading that may be a jump waits until the monitor has judged it.
  [[nodiscard]] std::int32_t position(Puck puck) const {
    const GoodPosition& good = facts_.good[index(puck)];
    return good.known ? good.motor : link_.reported(puck, Property::P).value;
  }
  [[nodiscard]] bool measured(Puck finger, Timestamp now) const;
  [[nodiscard]] bool any_active() const;
  void begin(Puck puck, std::int32_t target, double torque_units, int strain_limit);
  void step_move(Puck puck, Timestamp now);
  [[nodiscard]] std::optional<End> how_it_ended(Puck puck, const Move& move, Timestamp now) const;
  [[nodiscard]] bool said_too_early(Puck puck) const;
  void begin_closing();
  void after_opening();
  void after_closing(Timestamp now);
  void verify(Timestamp now);
  bool press_again();
  void say_weak(Puck finger, double holds_nm, double kept_nm);
  void watch_grip(Timestamp now);
  void watch_spread();
  void renew_pressing(Timestamp now);
  void press();
  void press(Puck finger);
  void grip_up();
  [[nodiscard]] double share(Puck finger) const;
  void let_rest(Puck puck);
  void open_fingers();
  [[nodiscard]] bool opposed() const;
  void give_up_grip();

  const BarrettHandConfig& config_;
  PuckLink& link_;
  HandFacts& facts_;
  Phase phase_ = Phase::Still;
  std::array<Move, kPucks> moves_{};
  std::array<bool, kFingers> contact_{};
  std::int32_t spread_target_ = 0;
  bool turn_after_ = false, releasing_ = false, loaded_ = false, waiting_ = false, pressing_ = false;
  std::array<bool, kFingers> rests_{};  ///< Strained so far that its puck let off; the worm holds.
  std::array<double, kFingers> hold_units_{};
  double torque_nm_ = 0.0, hold_limit_units_ = 0.0;
  bool gripped_up_ = false;
  Timestamp verify_until_{0};
  bool verify_timed_ = false;
  int press_tries_ = 0;
  SlipDetector slip_;
  PatternSlip pattern_;
  std::optional<std::int32_t> spread_kept_;  ///< Counts when the grip began.
  Timestamp spread_seen_{0};
  int spread_off_ = 0;  ///< Readings in a row that are far from it.
  bool spread_turned_ = false, grip_failed_ = false;
  ShortText why_;
};

}  // namespace colift::hal::barrett
