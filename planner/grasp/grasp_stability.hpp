#pragma once

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand/hand_model.hpp"
#include "planner/load_sharing/load_sharing.hpp"

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
    v("load_n", load_n, hal::Range{0.1, 1000}, "Load of the hand for the nominal margin (N).");
    v("cog_lever_m", cog_lever_m, hal::Range{0, 1},
      "Lever of that share about the line between both grasps (m).");
    v("min_margin", min_margin, hal::Range{0, 100}, "Min stability margin of a grasp.");
  }
};

/// What the closed hand can bear at a candidate before any load, per component in H about the grasp centre
/// (the middle between the pads).
struct GraspStrength {
  Vec3 center = Vec3::Zero();  ///< Grasp centre in W.
  double squeeze_n = 0.0;      ///< Normal force of each side.
  double bear_minus_n = 0.0;   ///< Load towards -Hy, borne by the fingers there; likewise towards +Hy.
  double bear_plus_n = 0.0;
  double shear_n = 0.0;   ///< Friction of all pads along Hx and against the palm.
  double pull_n = 0.0;    ///< Against being pulled out along +Hz: friction and the hook of fingers behind a
                          ///< cylinder, whose locked fingers bear then.
  double twist_nm = 0.0;  ///< About the closing axis.
  double pitch_nm = 0.0;  ///< About Hx.
  double roll_nm = 0.0;   ///< About the approach, until a finger comes loose.
};

/// Strength of the patch contact of two opposing finger sides. docs/decisions/0005-stability-margin.md.
///
/// Each side presses with N = finger_force_n * max(n-, n+): the stronger side pushes until its motors stall,
/// and the worms of the other do not give way. With mu friction, w the width, b x h the pad, r = (2/3)
/// sqrt(b h / pi) the lever of a round patch of the pad's area under even pressure, and a the mean distance
/// of a side's fingers from Hx = 0:
///
///   shear = 2 mu N        twist = mu N (sqrt(a-^2 + r^2) + sqrt(a+^2 + r^2))
///   pitch = N h + mu N w  roll = N (a- + a+ + b)
///
/// Of a cylinder, alpha is how far beyond its middle the pads touch: sin(alpha) = (height - gap - radius) /
/// radius; pull = 2 N (mu cos(alpha) + sin(alpha)) before the middle, and behind it the same of what locked
/// fingers bear; pitch = mu N w.
[[nodiscard]] GraspStrength grasp_strength(const GraspCandidate& candidate, const HandModel& hand);

/// By which factor a load may grow, at 1 just held; infinite for no load.
struct StabilityMargin {
  double slip = 0.0;  ///< Until the pads slide on the object, or it turns in them.
  double bear = 0.0;  ///< Until a finger bears more of the load than `finger_hold_n`.
  [[nodiscard]] double least() const { return slip < bear ? slip : bear; }
};

/// `load` is what the object does to the hand: force, and torque about the point that the decision hangs it
/// on (`candidate.depth_m` behind the grasp point, between the pads), frame W. Of a cylinder the torque is
/// taken to its axis, which the normals of all pads meet.
///
/// Locked fingers are springs under the preload N. A force f_y along the closing axis adds its part to the
/// side that bears it and takes the other's from the other, until that one comes loose; so pads that bear
/// also rub more. A torque t_z about the approach is a couple of normal forces, of one finger against the
/// opposite one: it is borne. What the shift of pressure along the pads does not hold of t_x is a couple of
/// friction between the sides. A side gives way where
///
///   (F / (mu N_side))^2 + (t_y / (mu sum N_side rho_side))^2 > 1,
///
/// the ellipsoid that bounds the friction of a soft contact (Howe and Cutkosky, IJRR 1996).
[[nodiscard]] StabilityMargin stability_margins(const GraspCandidate& candidate, const HandModel& hand,
                                                const hal::Wrench& load);
/// The smaller one.
[[nodiscard]] double stability_margin(const GraspCandidate& candidate, const HandModel& hand,
                                      const hal::Wrench& load);

/// What the robot's hand has to stand of a decision: its own part, and the partner's torque as well. A
/// person's hand gives way to turning long before a closed gripper does, so the couple that the decision
/// leaves to him comes to the robot; his force does not.
[[nodiscard]] hal::Wrench load_on_robot(const AgentWrenches& decided);

/// Normal force of a fingertip that closes until `torque_nm` is felt about its outer joint (N).
[[nodiscard]] double fingertip_force(const HandModel& hand, double torque_nm);

/// The nominal load of a candidate: the share straight down, and as torque that share at `cog_lever_m` about
/// the horizontal line from the grasp to the centre of gravity. The partner stands on the other side of that
/// line and takes every other torque as a pair of forces.
[[nodiscard]] hal::Wrench nominal_load(const GraspCandidate& candidate, const Vec3& up, const Vec3& cog,
                                       const StabilityConfig& config);

}  // namespace colift::planner
