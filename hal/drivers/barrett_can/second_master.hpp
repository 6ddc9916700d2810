#pragma once

#include <array>
#include <optional>

#include "hal/drivers/barrett_can/hand_facts.hpp"

namespace colift::hal::barrett {

/// Notices another program that commands the same hand: by its settings, where the bus shows them, and by
/// working values that are not what they were set to, where it does not. Questions of another program harm
/// nobody and are a warning.
class SecondMaster {
 public:
  SecondMaster(PuckLink& link, const HandFacts& facts) : link_(link), facts_(facts) {}

  void start();  ///< Forgets what was noticed.
  void ask();    ///< The next working value; often enough for all of them within half a second.
  void step(Timestamp now);

  /// It gave the hand a command; until start().
  [[nodiscard]] bool commands() const { return !words_.empty(); }
  [[nodiscard]] const ShortText& words() const { return words_; }
  /// It asked something within the last two seconds.
  [[nodiscard]] const ShortText& warning() const { return warning_; }

 private:
  void judge(Puck puck, std::size_t which);

  static constexpr std::array kWatched{Property::E,    Property::Mt, Property::Tstop, Property::Hsg,
                                       Property::Hold, Property::Mv, Property::Accel, Property::Ct};
  struct Odd {
    std::int32_t value = 0;
    Timestamp asked_at{0};
  };

  PuckLink& link_;
  const HandFacts& facts_;
  std::size_t next_ = 0;
  std::uint64_t settings_ = 0, questions_ = 0;
  std::array<std::array<std::optional<Odd>, kWatched.size()>, kPucks> odd_{};
  ShortText words_, warning_;
};

}  // namespace colift::hal::barrett
