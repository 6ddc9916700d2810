#pragma once

#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "control/config/monitor_config.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/time.hpp"

namespace colift::control {

/// Who is near the arm.
enum class Nearby {
  Person,       ///< Anybody, and anything that might be somebody.
  Partner,      ///< The body of the partner who holds the object.
  PartnerHand,  ///< His hand and forearm at the object.
  Thing,        ///< Something low that has been at rest for a while.
};

/// One of them, at its nearest point.
struct Neighbour {
  Nearby who = Nearby::Person;
  double distance_m = 0.0;  ///< To the links or to the rest of the path, whichever is less.
  bool to_path = false;     ///< It is the path that is nearer.
  double speed_m_s = 1.6;   ///< Measured, with its uncertainty added.
  hal::Vec3 point_W = hal::Vec3::Zero();
  int id = 0;
  bool behind = false;  ///< The rest of the path comes no nearer to it than the arm is.
};

/// How fast the arm may be, and why.
struct SeparationState {
  bool hold = false;
  bool stopped = false;              ///< It moved when the hold began; else its start waits.
  bool to_confirm = false;           ///< It stopped, and continues only when an operator confirms it.
  bool may_confirm = false;          ///< ... and nobody is near any more: a confirmation counts now.
  Nearby held_for = Nearby::Person;  ///< Who was too near last.
  double speed_m_s = std::numeric_limits<double>::infinity();  ///< Limit of any point of the arm.
  Neighbour nearest;                                           ///< That sets the limit ...
  bool limited = false;                                        ///< ... if any does.
};

/// Speed and separation monitoring. A continuous limit of the arm's speed from the distances of one frame:
/// the fastest at which it comes to rest before anybody is reached. Nearer than the hold distance it stops;
/// it resumes when nobody has been near for MonitorConfig::free_s, without MonitorConfig::resume when an
/// operator confirms it; an arm that had not begun to move starts after free_to_start_s. A contact is not its
/// business: that ends the job (state yield), and motion resumes after a confirmation in `colift recover`
/// only. One thread, no allocation.
class SeparationMonitor {
 public:
  explicit SeparationMonitor(const MonitorConfig& config) : config_(config) {}

  /// Once for each frame. `moves`: the arm may move now. `latency_s`: measured, from exposure until now;
  /// `robot_kg`: effective mass.
  const SeparationState& update(hal::Timestamp now, bool moves, std::span<const Neighbour> near,
                                double latency_s, double robot_kg);

  /// An operator confirms that the arm may continue. Counts only while SeparationState::may_confirm, and for
  /// this stop alone: whoever comes near before the arm moves has to be confirmed anew. Whether it counted.
  bool confirm();

  [[nodiscard]] const SeparationState& state() const { return state_; }
  /// Distance from somebody or something of this kind at which a hold ends.
  [[nodiscard]] double free_distance_m(Nearby who) const {
    return hold_distance_m(who) + config_.hysteresis_m;
  }

 private:
  [[nodiscard]] double hold_distance_m(Nearby who) const;
  [[nodiscard]] double limit_m_s(const Neighbour& n, double latency_s, double robot_kg) const;

  MonitorConfig config_;
  SeparationState state_;
  hal::Timestamp near_at_{0};  ///< When somebody was last too near.
  bool to_confirm_ = false;    ///< Since a stop that is to be confirmed the arm has not moved.
  double free_speed_m_s_ = std::numeric_limits<double>::infinity();  ///< Limit without the hold.
};

/// "a person", "the partner", ...
[[nodiscard]] std::string_view describe(Nearby who);
/// In a person's words: "a person is 0.42 m from the arm".
[[nodiscard]] std::string describe(const Neighbour& neighbour);

}  // namespace colift::control
