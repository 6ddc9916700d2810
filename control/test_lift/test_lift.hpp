#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "control/test_lift/cog_belief.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "planner/grasp_candidate.hpp"

namespace colift::control {

/// How a test lift goes on: it is enough when the object has turned too far, or every foot is well clear of
/// the ground.
enum class Raise { On, Slowly, Enough };
[[nodiscard]] Raise raise_on(const Hanging& now, const TestLiftConfig& config);

/// What a test lift says.
struct TestLift {
  Hanging seen;
  bool stands = false;  ///< A foot is on the ground and bears torque that the arm does not feel.
  bool bearable =
      false;         ///< It hangs, still, at max_turn_deg or less: to be lifted if no better grip is found.
  CogBelief belief;  ///< After this and all test lifts before it.
  double mass_kg = 0.0;
  hal::Vec3 cog = hal::Vec3::Zero();  ///< Mean of the belief; its height stays the shape's.
  double lever_m = 0.0;               ///< Of it from the line between both hands, level.
  double share = 0.0;                 ///< The robot's measured part of the weight.
  enum class Next {
    GoOn,
    OtherShare,  ///< Level, but the robot bears another part than was agreed: say so, and ask.
    Regrasp,     ///< Put down, and grasp where the belief gives the best chance (chance_level).
  } next = Next::GoOn;
  std::string reason;
};

/// Mass and centre of gravity from test lifts of one object, the last of which was made just now.
///
/// An object whose centre of gravity lies beside the line between the hands turns about that line until it
/// hangs, or until feet on the heavy side stand on the ground. Only one that hangs is felt as it is
/// (weigh_cog() says what follows from either). So a test lift is raised until the camera sees that all feet
/// are clear, or that the object has turned by max_turn_deg: before it would show the whole lever. One that
/// hangs still and at good_turn_deg or less is lifted on, as slowly: its tilt does not grow with height. All
/// others are put down. Errors: NotFound (the load says nothing, or nothing that is possible fits it, with
/// the numbers), BadInput (no test lift, not finite, hands at one place, fewer than three feet).
[[nodiscard]] hal::Result<TestLift> analyse_test_lift(const CarriedObject& object,
                                                      std::span<const MeasuredLift> tests,
                                                      const TestLiftConfig& config);

/// Of the grasps that are possible (Ok or Chosen), where the hand takes hold next while the partner holds at
/// `partner` (W): where chance_level() is best; of those that are as good to within a twentieth, the one
/// whose share is nearest to `wanted_share`. Places that a test lift was made at are left out, unless the
/// partner was elsewhere then. nullopt when no chance is as good as TestLiftConfig::min_level_probability.
struct NextGrip {
  std::size_t index = 0;  ///< Of the grasps.
  double chance = 0.0;
  double share = 0.0;  ///< What the robot would bear, by the mean of the belief.
};
[[nodiscard]] std::optional<NextGrip> next_grip(std::span<const planner::GraspCandidate> grasps,
                                                const hal::Vec3& partner, std::span<const MeasuredLift> tests,
                                                const CogBelief& belief, double wanted_share,
                                                const TestLiftConfig& config);

}  // namespace colift::control
