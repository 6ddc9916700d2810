#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/types/time.hpp"

namespace colift::control {

/// What begins to move after it has been announced.
enum class Motion : std::uint8_t { Approach, Close, Lift, Lower, Open, Retreat, Return, Continue };
inline constexpr std::size_t kMotions = 8;

/// "approach", "close", ...
[[nodiscard]] std::string_view to_string(Motion motion);

/// What the robot says to the people around it before it does it: for a page, a lamp or a speaker.
struct Intent {
  hal::Timestamp at{0};
  std::optional<Motion> motion;  ///< Unset: a request to a person; nothing moves.
  double in_s = 0.0;             ///< It begins this much later, or later still.
  std::string says;
};

/// Lets a motion begin only when it was announced some time before, and writes the announcements down.
class IntentAnnouncer {
 public:
  /// `lead_s`: from announcement to motion (s). `into` has to outlive it.
  IntentAnnouncer(double lead_s, std::vector<Intent>& into) : lead_s_(lead_s), into_(&into) {}

  /// Asked in every cycle until it is true: announces `motion` at the first time, true once that is long
  /// enough ago. Who stops asking for 0.1 s has given the motion up: it is announced again. `since_start`:
  /// the robot's clock, from the start of the job.
  [[nodiscard]] bool may_begin(Motion motion, hal::Timestamp since_start);
  /// A sentence for people that no motion follows.
  void request(std::string says, hal::Timestamp since_start);

 private:
  double lead_s_;
  std::vector<Intent>* into_;
  /// Each motion for itself: while one is announced, the arm may have to wait, and its continuation is
  /// announced.
  struct Announced {
    bool ever = false;
    hal::Timestamp at{0}, asked_at{0};
  };
  std::array<Announced, kMotions> announced_{};
};

}  // namespace colift::control
