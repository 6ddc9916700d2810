#pragma once

#include <cmath>
#include <optional>
#include <string>

#include "control/task/run_record.hpp"
#include "planner/hand/hand_model.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::experiments {

/// Under which fingers a thing lies.
enum class Under { F1, F2, F1AndF2, F3 };
inline constexpr int kUnder = 4;
[[nodiscard]] const char* word(Under place);

/// Where the fingers of a run closed first, and what came of it.
struct FirstGrip {
  std::optional<planner::GraspCandidate> grasp;
  double close_s = NAN;   ///< Begin, of the record's time.
  bool accepted = false;  ///< The hand kept it, and waited for the partner.
  std::string why;        ///< It did not.
};
[[nodiscard]] FirstGrip first_grip(const control::RunRecord& record);

/// A thing as thick as a finger (20 mm), on the object's face under the pads, that comes shortly before they
/// close and is held there from elsewhere: along the palm's width, or, under level fingers that come from
/// above, upright under one of them. nullopt where no piece of clutter can lie so: fingers that close at a
/// slant, or two that one upright thing would have to be under.
[[nodiscard]] std::optional<sim_hal::ScenarioClutter> thing_between(const planner::GraspCandidate& grasp,
                                                                    const planner::HandModel& hand,
                                                                    Under place, double close_s);

}  // namespace colift::experiments
