#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace colift::sim_hal {

/// One touch of one region of one person, from first contact until 50 ms without.
struct JudgedContact {
  double t_s = 0.0;                     ///< Of the scenario.
  std::string region;                   ///< "lower-arm"
  std::string by;                       ///< robot | object
  int person = 0;                       ///< Place in the scenario's people; -1: the partner who carries.
  double force_n = 0.0, limit_n = 0.0;  ///< Peak, and the limit that counts for it (transient or clamped).
  double counts_n = 0.0;                ///< Peak of the kind (transient or clamped) that the limit is for.
  double clamped_s = 0.0;               ///< Pressed against something else, or without a pause beyond 0.5 s.
  double kept_n = 0.0;                  ///< Peak of what clamped him after the first half second.
  double closing_m_s = 0.0;             ///< How fast they came together, the person's own motion in it.
  double commanded_j = 0.0;  ///< What commands had put into the arm since it last rested, at the peak (J).
  double robot_m_s = 0.0;    ///< How fast the robot's (the object's) surface came towards him, at most.
  /// He ran into a robot, or into what it held, that had been at rest, whose surface did not come towards him
  /// or whose commands put no energy into what then did; no fingers closed, and what still clamped him after
  /// half a second stayed within its limit: reported, no breach.
  bool his_own = false;
};

/// How near people were to the robot within one tenth of a second; infinite: nobody was there.
struct DistanceSample {
  double t_s = 0.0;  ///< End of the tenth.
  double people_m = 0.0, partner_m = 0.0;
};

/// What the simulation says of a run, whatever the program says.
struct Verdict {
  std::vector<std::string> breaches;  ///< One sentence each, the invariant's or the region's name first.
  std::vector<JudgedContact> contacts;
  std::optional<double> min_distance_m;  ///< Of the scenario's people to the robot; unset: nobody was there.
  std::optional<double> partner_distance_m;  ///< Of the partner who carries.
  std::vector<DistanceSample> distances;     ///< Over time.
  std::optional<double> stop_latency_s;      ///< Longest from a person's 45 N to the first slower command.
  std::vector<std::string> judged;
  std::vector<std::pair<std::string, std::string>> not_judged;  ///< Invariant, why.
};

}  // namespace colift::sim_hal
