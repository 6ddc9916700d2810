#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "sim_hal/mujoco/sim_world.hpp"

namespace colift::sim_hal {

/// The hand never opens while loaded, but with the object supported, which then stays where it is (I4); and
/// `lifted` is said of what was lifted by both (I8).
class LoadRules {
 public:
  void tick(const TickReport& report, std::vector<std::string>& breaches);
  /// The program's word at its end, against what was true.
  void lifted(std::vector<std::string>& breaches) const;

 private:
  static constexpr std::size_t kBefore_ms = 100;
  struct Moment {
    double borne_n = 0.0, height_m = 0.0, tilt_rad = 0.0;  // what the hand bore, and how the object lay
  };
  struct Opening {
    double t_s = 0.0;
    Moment before;
  };
  std::array<Moment, kBefore_ms> past_{};  // the last 100 ms
  std::optional<Opening> opening_;         // with a load: the object stays where it is, or was not supported
  std::size_t tick_ = 0;
  std::optional<double> closed_rad_;         // mean of the fingers, at their most closed on the object
  double max_height_m_ = 0.0, top_m_ = 0.0;  ///< Of the run; since the partner took hold.
  bool held_ = false;
  bool partner_at_top_ = false;
};

}  // namespace colift::sim_hal
