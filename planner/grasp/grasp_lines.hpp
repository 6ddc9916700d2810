#pragma once

#include <optional>
#include <string>
#include <vector>

#include "perception/scene.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand/completed_shape.hpp"
#include "planner/hand/hand_model.hpp"
#include "planner/hand/obstacles.hpp"
#include "planner/hand/seen_space.hpp"

namespace colift::planner {

struct CandidateConfig;

/// A straight run of grasps that differ only in where they are: from `from` to `to` with the same approach,
/// closing axis and width. Candidates are points on such lines, at steps or as near as possible to a given
/// point.
struct GraspLine {
  GraspKind kind = GraspKind::Ega5;
  int surface = -1;
  Vec3 from = Vec3::Zero();
  Vec3 to = Vec3::Zero();
  Vec3 approach = Vec3::UnitZ();
  Vec3 closing = Vec3::UnitY();
  double width = 0.0;
  /// How far the body goes on behind the face, where the pads would press behind it (m).
  std::optional<double> depth{};
  std::string note;  ///< What had to be assumed; empty otherwise.

  [[nodiscard]] double length() const { return (to - from).norm(); }

  /// Point of the line that is nearest to p.
  [[nodiscard]] Vec3 nearest(const Vec3& p) const;
};

/// Along the middle of every rectangle that the hand can span; across as well where both its sides fit.
[[nodiscard]] std::vector<GraspLine> ega5_lines(const perception::Scene& scene, const HandModel& hand,
                                                const CandidateConfig& config);

/// Over the rims of plates: edges of rectangles beside which the camera saw nothing but background, and where
/// no face of the same body adjoins. The plate's thickness comes from the completed solids, else from the
/// object's points below the rim, else it is assumed and the line's note says so. Needs the view; without one
/// there are none.
[[nodiscard]] std::vector<GraspLine> edge_lines(const perception::Scene& scene, const SeenSpace& seen,
                                                const CompletedSolids& solids, const Obstacles& obstacles,
                                                const HandModel& hand, const CandidateConfig& config);

/// Along every cylinder that the hand can span, from all directions of its visible side (every side without a
/// camera).
[[nodiscard]] std::vector<GraspLine> wrap_lines(const perception::Scene& scene, const Vec3* camera,
                                                const HandModel& hand, const CandidateConfig& config);

/// The closing axis with its sign chosen so that the single finger is on top and the pair bears the load.
[[nodiscard]] Vec3 thumb_up(const Vec3& closing, const perception::Scene& scene);

}  // namespace colift::planner
