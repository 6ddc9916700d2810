#pragma once

#include <optional>
#include <string>
#include <vector>

#include "hal/types/geometry.hpp"

namespace colift::planner {

using hal::Pose;
using hal::Vec3;

/// How the hand takes the object.
enum class GraspKind {
  Ega5,  ///< Elementary grasp action 5: along the inward normal of a narrow rectangle (thesis 5.3.2).
  Edge,  ///< Over the rim of a plate that is thinner than the opening.
  Wrap,  ///< Around a cylinder, palm towards its axis.
};

/// What became of a candidate. Every verdict but Ok and Chosen carries its reason in numbers.
enum class Verdict { Ok, Chosen, Collision, Unreachable, TooWide, Unstable, OverLimit, NearPartner };

/// A pose of the hand that may grasp the object. Frame W, SI units.
struct GraspCandidate {
  int id = 0;
  GraspKind kind = GraspKind::Ega5;
  Vec3 position = Vec3::Zero();   ///< Grasp point on the object's surface.
  Vec3 approach = Vec3::UnitZ();  ///< Unit vector in which the palm moves.
  Vec3 closing = Vec3::UnitY();   ///< Unit vector along which the fingers close; perpendicular to approach.
  double depth_m =
      0.0;  ///< How far behind the grasp point, along approach, the pads press: there the load hangs.
  double width = 0.0;  ///< Extent of the object between the fingers (m).
  int surface = -1;    ///< Index of the surface it was generated on.
  std::optional<double>
      stability;  ///< Margin of the grasp against slipping; unset where it is assumed (thesis).
  Verdict verdict = Verdict::Ok;
  std::string reason;            ///< The reason for the verdict, as a person would give it.
  std::optional<double> miss_m;  ///< By how much it was refused, where that is a length (m).
  std::optional<double> gap_m;   ///< Palm plane to the surface (m), where it is not the hand's usual one.
};

/// Where the load hangs in the hand: behind the grasp point, between the pads.
[[nodiscard]] inline Vec3 load_point(const GraspCandidate& c) {
  return c.position + c.depth_m * c.approach;
}

/// The same grasp of an object that was moved: X takes a point of it from where it stood to where it stands
/// (W).
inline void move(GraspCandidate& c, const hal::Pose& X) {
  c.position = X * c.position;
  c.approach = X.linear() * c.approach;
  c.closing = X.linear() * c.closing;
}

}  // namespace colift::planner
