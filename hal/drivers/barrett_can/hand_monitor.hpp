#pragma once

#include <array>
#include <optional>

#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/hand_facts.hpp"
#include "hal/drivers/barrett_can/hand_motion.hpp"
#include "hal/drivers/barrett_can/pucks/bus_monitor.hpp"
#include "hal/drivers/barrett_can/second_master.hpp"

namespace colift::hal::barrett {

/// Why the hand cannot be used now.
struct HandFault {
  ErrorCode code = ErrorCode::LinkLost;
  std::optional<Puck> alone;  ///< It is of this puck alone, which is silent; the others obey.
  ShortText words;
};

/// Asks the pucks for everything in its own rhythm, and notices what goes wrong: silence, reset, a lost mode
/// or zero, heat, too much torque. Sees to it that the motion does not go on then; never opens the hand.
class HandMonitor {
 public:
  HandMonitor(const BarrettHandConfig& config, PuckLink& link, BusMonitor& bus, HandFacts& facts,
              HandMotion& motion);

  void start();  ///< Forgets what was noticed; after start-up.
  void step(Timestamp now);

  [[nodiscard]] std::optional<HandFault> fault() const;
  /// Pucks that are silent now are no fault any more, until they have answered again or start() was called:
  /// a person or a controller knows, and goes on with the others.
  void go_without_silent();
  [[nodiscard]] std::optional<Puck> missing() const;  ///< One of those.
  [[nodiscard]] const GoodPosition& good(Puck puck) const { return facts_.good[index(puck)]; }
  [[nodiscard]] Timestamp oldest_position() const;  ///< Of those that are not done without.
  [[nodiscard]] bool all_known() const;
  [[nodiscard]] double temperature_c(
      Puck puck) const;  ///< Of puck or motor, the hotter; NaN when not reported.
  [[nodiscard]] double hottest_c() const;
  [[nodiscard]] bool warm() const { return warm_; }
  [[nodiscard]] bool hot() const { return hot_; }
  [[nodiscard]] bool over_torque() const { return over_torque_; }
  /// Heat or torque, else the supply, else another program that asks the pucks.
  [[nodiscard]] const ShortText& warning() const {
    if (!warning_.empty()) return warning_;
    if (!supply_.empty()) return supply_;
    return others_.warning().empty() ? outage_ : others_.warning();
  }

 private:
  void ask(Timestamp now);
  void judge_position(Puck puck);
  void judge_status(Puck puck);
  void judge_mark(Puck puck);
  void judge_mode(Puck puck, Timestamp now);
  void judge_heat();
  void judge_supply();
  void judge_torque(Puck puck);
  void lose_zero(Puck puck);
  void lose_zero_by_jump(Puck puck, std::int32_t by);

  struct Rhythm {
    Duration period{0};
    Timestamp next{0};
    bool due(Timestamp now) {
      if (now < next) return false;
      next = now + period;
      return true;
    }
  };

  const BarrettHandConfig& config_;
  PuckLink& link_;
  BusMonitor& bus_;
  HandFacts& facts_;
  HandMotion& motion_;
  SecondMaster others_;
  Rhythm measure_, status_, mode_, pads_, palm_, heat_, torque_, ping_;
  std::array<int, kPucks> jumps_{}, torques_over_{};
  std::array<std::int32_t, kPucks> jumped_to_{};
  std::array<Timestamp, kPucks> torque_seen_{}, judged_at_{}, mode_suspected_{}, reset_suspected_{},
      mark_suspected_{};
  std::array<Timestamp, kFingers> strained_at_{};  ///< When a gauge last showed its most.
  std::array<bool, kPucks> was_quiet_{}, failed_{}, without_{};
  int slow_turn_ = 0, supply_low_ = 0;
  bool current_next_ = false, warm_ = false, hot_ = false, fades_ = false, over_torque_ = false;
  bool spread_kept_on_ = false;
  std::array<Timestamp, kPucks> supply_seen_{};
  ShortText warning_, outage_, supply_;
  Timestamp lost_at_{0};  ///< The bus, last.
};

}  // namespace colift::hal::barrett
