#pragma once

#include <functional>
#include <optional>
#include <string>

#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/barrett_can/hand_facts.hpp"
#include "hal/types/result.hpp"

namespace colift::hal::barrett {

/// From a bus that may be anything to a hand that is known: wakes the pucks, says what is wrong in words,
/// checks who they are, writes the working values, and finds the zeros where they are not known. The only
/// part of the driver that waits; every wait has a deadline.
class HandStartup {
 public:
  HandStartup(const BarrettHandConfig& config, CanBus& bus, PuckLink& link, HandFacts& facts,
              const Clock& clock);

  struct Outcome {
    bool closed = false;  ///< The hand was found initialised with its fingers closed: it may hold something.
    std::string remark;   ///< What does not keep the hand from working.
  };

  /// `loaded`: it holds something; then nothing moves and no motor is switched off.
  [[nodiscard]] Result<Outcome> run(bool loaded);

 private:
  [[nodiscard]] Result<> find_pucks();
  [[nodiscard]] Result<> wake();
  [[nodiscard]] Result<> identify();
  [[nodiscard]] Result<> join_group();
  /// The scales of the pucks that are in this hand.
  [[nodiscard]] Result<> read_scales();
  [[nodiscard]] Result<> write_working_values(bool loaded);
  [[nodiscard]] Result<> initialise();
  /// Why a zero that looks known is not believed; empty: it is.
  [[nodiscard]] std::string doubt_zero(Puck puck);
  [[nodiscard]] Result<> note_power_on();
  void name_pressing();
  void add_remark(const std::string& words);
  void start_finding(const Puck* first, std::size_t count);
  [[nodiscard]] Result<> find_stops(const Puck* first, std::size_t count, double timeout_s);
  [[nodiscard]] Result<> settle(bool loaded);
  void tare();
  [[nodiscard]] tl::unexpected<Error> nobody() const;

  /// False when the time is up first.
  bool wait(double limit_s, const std::function<bool()>& until);
  void rest(double for_s) {
    (void)wait(for_s, [] { return false; });
  }
  [[nodiscard]] double one_answer_s() const;  ///< For three tries of a puck that is awake.
  [[nodiscard]] std::optional<std::int32_t> read(Puck puck, Property property, double limit_s);
  [[nodiscard]] Result<> settings_taken(double limit_s);

  const BarrettHandConfig& config_;
  CanBus& bus_;
  PuckLink& link_;
  HandFacts& facts_;
  const Clock& clock_;
  CanHealth before_;
  std::array<bool, kPucks> marked_{};
  std::array<std::optional<std::int32_t>, kPucks> up_s_{};
  std::string remark_;
};

}  // namespace colift::hal::barrett
