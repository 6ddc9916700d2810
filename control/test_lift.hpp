#pragma once

#include <optional>
#include <string>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"

namespace colift::control {

/// What is done after a lift of a few millimetres.
struct TestLiftConfig {
  double height_m = 0.006;
  double hold_s = 0.6;
  double density_sigma_m = 0.10;
  double max_lever_m = 0.03;
  double max_share_error = 0.10;
  double least_load_n = 2.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("height_m", height_m, hal::Range{0.002, 0.03}, "Height of the test lift (m).");
    v("hold_s", hold_s, hal::Range{0.1, 10}, "How long is measured at the top (s).");
    v("density_sigma_m", density_sigma_m, hal::Range{0.0, 1.0},
      "How far uneven density may put the centre of gravity off the shape's, standard deviation (m).");
    v("max_lever_m", max_lever_m, hal::Range{0.001, 0.5},
      "Distance of the centre of gravity from the line between both hands that is still lifted (m).");
    v("max_share_error", max_share_error, hal::kFraction,
      "Difference of the robot's share from what was predicted that is still lifted.");
    v("least_load_n", least_load_n, hal::kNotNegative,
      "A load below this says nothing: the object stands still on the ground (N).");
  }
};

/// What was felt while the object was clear of the ground, and what was believed before. Frame W.
struct TestLiftInput {
  hal::Wrench felt;  ///< Of the object on the hand, about `palm` (LoadEstimator::wrench_W), mean at the top.
  hal::Vec3 palm = hal::Vec3::Zero();
  hal::Vec3 grasp = hal::Vec3::Zero();  ///< Where the load hangs in the hand.
  hal::Vec3 partner = hal::Vec3::Zero();
  hal::Vec3 cog = hal::Vec3::Zero();  ///< Of the shape.
  Eigen::Matrix3d cog_covariance = Eigen::Matrix3d::Zero();
  double share_predicted = 0.5;
  std::optional<double> known_mass_kg = {};
};

struct TestLift {
  double mass_kg = 0.0;
  hal::Vec3 cog = hal::Vec3::Zero();  ///< Corrected; its height stays as believed.
  double lever_m = 0.0;  ///< Of the corrected centre of gravity from the line between both hands, level.
  double share = 0.0;    ///< The robot's measured part of the weight.
  enum class Next {
    GoOn,
    OtherShare,  ///< Level, but the robot bears another part than was agreed: say so, and ask.
    Regrasp,     ///< Put down and decide again with the corrected centre of gravity.
  } next = Next::GoOn;
  std::string because;
};

/// Mass and centre of gravity from external torques.
///
/// Torques about the partner's grasp p balance without his force: m g (c - p) x up = what the robot exerts.
/// So the level part of m (c - p) is measured, two numbers for three unknowns: the *direction* in which the
/// centre of gravity lies from the partner, which is what tilts the object, is known, while mass and distance
/// are known as a product only, whatever the lift. The distance is taken as the point of that ray nearest to
/// the believed centre of gravity, in units of its uncertainty; a known mass settles it. The partner's hand
/// is taken as a point: his torque (1 N m or so) shows as an error of the direction. Errors: NotFound (the
/// load says nothing, with the numbers), BadInput (not finite, hands at one place).
[[nodiscard]] hal::Result<TestLift> understand_test_lift(const TestLiftInput& input,
                                                         const TestLiftConfig& config);

}  // namespace colift::control
