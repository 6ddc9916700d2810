#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "planner/grasp_candidate.hpp"

namespace colift::planner {

// Frame H of a hand: origin in the middle of the palm at the height of the finger joints, Hz out of the palm
// (the direction of approach), Hy the closing axis, Hx across. Right-handed.

/// A part of the hand that does not move while the fingers close: a box along the axes of H (m).
struct HandCuboid {
  std::string part = "palm";
  Vec3 center_m = Vec3::Zero();
  Vec3 size_m = Vec3::Zero();

  template <class Visitor>
  void visit(Visitor& v) {
    v("part", part, "Name of the part in messages.");
    v("center_m", center_m, hal::Range{-1, 1}, "Middle in the hand frame H (m).");
    v("size_m", size_m, hal::Range{0, 1}, "Full lengths along Hx, Hy, Hz (m).");
  }
};

/// Where a finger stands. It moves in the plane Hx = x_m.
struct HandFinger {
  std::string part = "finger";
  double x_m = 0.0;
  int side = 1;  ///< +1: the finger stands at +Hy and closes towards -Hy; -1: the other way.

  template <class Visitor>
  void visit(Visitor& v) {
    v("part", part, "Name of the part in messages.");
    v("x_m", x_m, hal::Range{-0.5, 0.5}, "Offset of the finger's plane along Hx (m).");
    v("side", side, hal::Range{-1, 1}, "Side of the finger: +1 at +Hy, -1 at -Hy.");
  }
};

/// A finger of two links that is driven by one angle: the inner link at q above the palm, the outer one bent
/// by `outer_bend_deg + coupling * q` against it. Both links are boxes of their own width and one thickness.
struct FingerGeometry {
  double joint_radius_m = 0.050;
  double inner_length_m = 0.070;
  double inner_overhang_m = 0.011;
  double inner_width_m = 0.021;
  double outer_length_m = 0.057;
  double outer_width_m = 0.023;
  double half_thickness_m = 0.0095;
  double outer_bend_deg = 42.0;
  double coupling = 1.0 / 3.0;
  double open_deg = 0.0;
  double closed_deg = 140.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("joint_radius_m", joint_radius_m, hal::Range{0, 0.5},
      "Distance of the inner joint from the middle (m).");
    v("inner_length_m", inner_length_m, hal::Range{0.001, 0.5}, "Inner joint to outer joint (m).");
    v("inner_overhang_m", inner_overhang_m, hal::Range{0, 0.1},
      "Inner link's body beyond each of its joints (m).");
    v("inner_width_m", inner_width_m, hal::Range{0.001, 0.2}, "Inner link along Hx (m).");
    v("outer_length_m", outer_length_m, hal::Range{0.001, 0.5}, "Outer joint to fingertip (m).");
    v("outer_width_m", outer_width_m, hal::Range{0.001, 0.2}, "Outer link along Hx (m).");
    v("half_thickness_m", half_thickness_m, hal::Range{0.001, 0.1},
      "Link's axis to its pad and to its back (m).");
    v("outer_bend_deg", outer_bend_deg, hal::Range{-90, 120},
      "Bend of the outer link with the finger open (deg).");
    v("coupling", coupling, hal::Range{0, 3}, "Turn of the outer joint for each turn of the inner one.");
    v("open_deg", open_deg, hal::Range{-30, 90}, "Inner joint in the open pre-shape (deg).");
    v("closed_deg", closed_deg, hal::Range{1, 180}, "Inner joint at the end of its range (deg).");
  }
};

/// A gripper as the planner sees it: its body, how its fingers sweep, and how strong they are. The defaults
/// are the BarrettHand BH8-282 with spread 0 (F1 and F2 at -Hy, F3 at +Hy) and equal
/// config/hand/bh8_282.yaml, where each number's source stands.
struct HandModel {
  std::string name = "BarrettHand BH8-282";
  double opening_m = 0.19;
  double palm_gap_m = 0.03;
  double wrap_gap_m = 0.01;
  std::vector<HandCuboid> cuboids = bh8_282_cuboids();
  std::vector<HandFinger> fingers = bh8_282_fingers();
  FingerGeometry finger;
  double pad_width_m = 0.020;
  double pad_height_m = 0.020;
  double finger_force_n = 15.0;
  double finger_hold_n = 19.6;
  double friction = 0.5;
  double min_hold_m = 0.012;
  double wrap_margin_m = 0.005;

  /// Distance of the palm plane from the object's face (m).
  [[nodiscard]] double gap(const GraspCandidate& c) const {
    return c.gap_m.value_or(c.kind == GraspKind::Wrap ? wrap_gap_m : palm_gap_m);
  }

  /// Largest distance at which the fingers still hold the object: `min_hold_m` behind the face, or about
  /// at a cylinder's middle.
  [[nodiscard]] double largest_gap(const GraspCandidate& c) const;

  [[nodiscard]] static std::vector<HandCuboid> bh8_282_cuboids();
  [[nodiscard]] static std::vector<HandFinger> bh8_282_fingers();

  template <class Visitor>
  void visit(Visitor& v) {
    v("name", name, "Make and type.");
    v("opening_m", opening_m, hal::Range{0.001, 1}, "Max width that parallel pads can hold (m).");
    v("palm_gap_m", palm_gap_m, hal::Range{0.001, 0.5},
      "Palm plane to the grasped face, Ega5 and edge grasps (m).");
    v("wrap_gap_m", wrap_gap_m, hal::Range{0.001, 0.5},
      "Palm plane to the cylinder's surface, wrap grasps (m).");
    v("cuboids", cuboids, "Parts that stay while the fingers close.");
    v("fingers", fingers, "Where the fingers stand.");
    v("finger", finger, "Shape and motion of each finger.");
    v("pad_width_m", pad_width_m, hal::Range{0.001, 0.2}, "Contact patch of a pad along Hx (m).");
    v("pad_height_m", pad_height_m, hal::Range{0.001, 0.2}, "Contact patch of a pad along the finger (m).");
    v("finger_force_n", finger_force_n, hal::Range{0.1, 1000},
      "Normal force that a finger presses with (N).");
    v("finger_hold_n", finger_hold_n, hal::Range{0.1, 1000}, "Max force on a locked finger (N).");
    v("friction", friction, hal::Range{0.01, 3}, "Coefficient of friction between pad and object.");
    v("min_hold_m", min_hold_m, hal::Range{0, 0.2},
      "Min distance of the pads behind the grasped face at which they still hold the object (m).");
    v("wrap_margin_m", wrap_margin_m, hal::Range{0, 0.2},
      "Max distance of the pads before the middle of a cylinder at which they still hold it (m).");
  }
};

/// Reads a hand file. Errors: those of the configuration reader; BadConfig when the hand could not close, has
/// fingers on one side only, or states an opening that its fingers do not have.
[[nodiscard]] hal::Result<HandModel> load_hand(const std::filesystem::path& file);

/// What load_hand() checks beside the ranges. Errors: BadConfig.
[[nodiscard]] hal::Result<> check_hand(const HandModel& hand);

/// Pose of H in W when the palm has arrived at the candidate.
[[nodiscard]] Pose hand_pose(const GraspCandidate& candidate, const HandModel& hand);

/// A box of the hand in H, turned about Hx only. Unit vector (0, ey, ez) is its first axis in the plane of
/// the finger.
struct HandBox {
  double cx, cy, cz;  ///< Middle (m).
  double hx, h1, h2;  ///< Half lengths along Hx, along (ey, ez), along (-ez, ey) (m).
  double ey, ez;

  /// Distance of p from the nearest face if p is inside (0 on a face), negative outside.
  [[nodiscard]] double depth(double x, double y, double z) const {
    const double dx = x - cx, dy = y - cy, dz = z - cz;
    const double a = hx - (dx < 0 ? -dx : dx);
    const double l1 = dy * ey + dz * ez, l2 = dz * ey - dy * ez;
    const double b = h1 - (l1 < 0 ? -l1 : l1);
    const double c = h2 - (l2 < 0 ? -l2 : l2);
    const double ab = a < b ? a : b;
    return ab < c ? ab : c;
  }
};

/// Both links of one finger with its inner joint at `q_rad`.
struct FingerPose {
  HandBox inner, outer;
};
[[nodiscard]] FingerPose finger_at(const HandModel& hand, const HandFinger& finger, double q_rad);

/// Distance of the innermost point of a finger from the plane Hy = 0 (m); half of the width that it leaves
/// free.
[[nodiscard]] double half_gap_at(const HandModel& hand, double q_rad);

/// Where the fingers touch an object of the given width.
struct PadContact {
  double q_rad;     ///< Inner joint.
  double height_m;  ///< Of the contact above the palm plane, along Hz.
};
[[nodiscard]] PadContact contact_at_width(const HandModel& hand, double width_m);

/// Inner joint's angle at which the fingers are stopped by what a candidate grasps (rad): by its width
/// between the pads; by a cylinder where the first link meets it, which for a thin one is far from where pads
/// that wide would be. With something else of the given thickness on it (m), it is stopped so much sooner.
[[nodiscard]] double stopped_angle(const HandModel& hand, const GraspCandidate& candidate,
                                   double between_m = 0.0);

}  // namespace colift::planner
