#pragma once

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand_model.hpp"

namespace colift::planner {

/// The load that a grasp must stand before the decision knows the real one.
struct StabilityConfig {
  bool enabled = true;
  double load_n = 10.0;
  double cog_lever_m = 0.015;
  double min_margin = 1.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("enabled", enabled, "Whether the margin is computed; off: every grasp is assumed stable (thesis).");
    v("load_n", load_n, hal::Range{0.1, 1000}, "The hand's share of the object's weight (N).");
    v("cog_lever_m", cog_lever_m, hal::Range{0, 1},
      "Lever of the share that both partners' line does not balance (m).");
    v("min_margin", min_margin, hal::Range{0, 100}, "Margin below which a grasp is refused.");
  }
};

/// What the closed hand can bear at a candidate, per component in H about the grasp centre (the middle
/// between the pads).
struct GraspStrength {
  Vec3 center = Vec3::Zero();  ///< Grasp centre in W.
  double squeeze_n = 0.0;      ///< Normal force of each side.
  double bear_minus_n = 0.0;   ///< Load towards -Hy, borne by the fingers there; likewise towards +Hy.
  double bear_plus_n = 0.0;
  double shear_n = 0.0;  ///< Friction of all pads along Hx and against the palm.
  double pull_n =
      0.0;  ///< Against being pulled out along +Hz: friction and the hook of fingers behind a cylinder.
  double twist_nm = 0.0;  ///< About the closing axis.
  double pitch_nm = 0.0;  ///< About Hx.
  double roll_nm = 0.0;   ///< About the approach.
};

/// Strength of the patch contact of two opposing finger sides. docs/decisions/0005-stability-margin.md.
///
/// Each side presses with N = force * min(n-, n+) fingers. With mu friction, w the width, b x h the pad, r =
/// (2/3) sqrt(b h / pi) the lever of a round patch of the pad's area under even pressure, and a the mean
/// distance of a side's fingers from Hx = 0:
///   shear = 2 mu N                        pull = 2 N (mu cos(alpha) + sin(alpha)), alpha = 0 but for a
///   cylinder twist = mu N (sqrt(a-^2 + r^2) + sqrt(a+^2 + r^2)) pitch = N h + mu N w                  roll =
///   N (a- + a+ + b)
/// alpha is how far beyond the middle of the cylinder the pads touch: sin(alpha) = (height - gap - radius) /
/// radius. A locked finger bears `finger_hold_n`.
[[nodiscard]] GraspStrength grasp_strength(const GraspCandidate& candidate, const HandModel& hand);

/// How many times the load could grow before the grasp gives way; 1 is just stable, infinite for no load.
/// `load` is what the object does to the hand: force, and torque about the grasp centre, frame W. The
/// decision's wrench about `candidate.position`, some centimetres before it, may be handed in as it stands:
/// which point the force goes through is the decision's choice.
///
///   1 / margin = max(|f_y| / bear, sqrt((f_t / F)^2 + (t_y / twist)^2 + (t_x / pitch)^2 + (t_z / roll)^2))
///
/// f_t / F adds f_x / shear and f_z / (pull outwards, shear inwards) in squares; the second term is the
/// ellipsoid that bounds friction of a soft contact (Howe and Cutkosky, IJRR 1996), with the normal couples
/// taken from the same budget.
[[nodiscard]] double stability_margin(const GraspCandidate& candidate, const HandModel& hand,
                                      const hal::Wrench& load);

/// The nominal load of a candidate: the share straight down, and as torque that share at `cog_lever_m` about
/// the horizontal line from the grasp to the centre of gravity. The partner stands on the other side of that
/// line and takes every other torque as a pair of forces.
[[nodiscard]] hal::Wrench nominal_load(const GraspCandidate& candidate, const Vec3& up, const Vec3& cog,
                                       const StabilityConfig& config);

}  // namespace colift::planner
