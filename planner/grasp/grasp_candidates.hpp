#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "perception/organised_cloud.hpp"
#include "perception/scene.hpp"
#include "planner/grasp/grasp_lines.hpp"
#include "planner/grasp/grasp_stability.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand/completed_shape.hpp"
#include "planner/hand/hand_collision.hpp"
#include "planner/hand/hand_model.hpp"

namespace colift::planner {

/// Where grasps are looked for, and what refuses them.
struct CandidateConfig {
  double step_m = 0.05;
  double end_margin_m = 0.04;
  double min_width_m = 0.004;
  double min_length_m = 0.015;
  bool pads_bear = true;
  bool edges = true;
  double side_clearance_m = 0.0;
  double assumed_thickness_m = 0.03;
  double edge_probe_m = 0.03;
  double edge_jump_m = 0.04;
  double adjoin_m = 0.025;
  double max_free_of_solid = 0.1;
  bool wraps = true;
  double wrap_step_deg = 30.0;
  bool try_both_ways = true;
  int refine_lines = 4;
  double turn_step_deg = 20.0;
  double max_turn_deg = 0.0;
  CollisionConfig collision;
  StabilityConfig stability;

  template <class Visitor>
  void visit(Visitor& v) {
    v("step_m", step_m, hal::Range{0.002, 1}, "Largest distance between neighbouring grasps (m).");
    v("end_margin_m", end_margin_m, hal::Range{0, 0.5},
      "Distance of the outermost grasps from a surface's ends (m).");
    v("min_width_m", min_width_m, hal::Range{0, 0.2}, "Thinner surfaces are not grasped (m).");
    v("min_length_m", min_length_m, hal::Range{0, 1}, "Shorter surfaces are not grasped (m).");
    v("pads_bear", pads_bear,
      "Whether the load is taken to hang where the pads press, behind the face; the thesis takes the face "
      "itself.");
    v("edges", edges, "Whether rims of plates are grasped.");
    v("side_clearance_m", side_clearance_m, hal::Range{0, 0.2},
      "A hand on a rim that would meet the object this far aside is refused: of a leg only the faces towards "
      "the camera "
      "are seen (m).");
    v("assumed_thickness_m", assumed_thickness_m, hal::Range{0.001, 0.5},
      "Of a plate whose edge was not seen (m).");
    v("edge_probe_m", edge_probe_m, hal::Range{0.001, 0.2}, "How far beyond a rim the view is tested (m).");
    v("edge_jump_m", edge_jump_m, hal::Range{0.001, 2},
      "How far behind a rim the background must be at least (m).");
    v("adjoin_m", adjoin_m, hal::Range{0, 0.2}, "Faces nearer than this at an edge belong together (m).");
    v("max_free_of_solid", max_free_of_solid, hal::kFraction,
      "Part of an implied box that may have been seen free.");
    v("wraps", wraps, "Whether cylinders are grasped.");
    v("wrap_step_deg", wrap_step_deg, hal::Range{1, 180},
      "Angle between approaches around a cylinder (deg).");
    v("try_both_ways", try_both_ways, "Whether the hand is turned by half a turn where it collides.");
    v("refine_lines", refine_lines, hal::Range{0, 100},
      "How many surface lines get a candidate near a given point.");
    v("turn_step_deg", turn_step_deg, hal::Range{1, 90},
      "Step of the angles at which the hand comes to a face where the arm does not get there straight "
      "(deg).");
    v("max_turn_deg", max_turn_deg, hal::Range{0, 60},
      "Largest such angle; 0: the hand always comes straight (deg).");
    v("collision", collision, "When the hand collides.");
    v("stability", stability, "When a grasp slips.");
  }
};

/// The thesis's choice: rectangles only, no unseen space, the object's points only, every grasp assumed
/// stable.
[[nodiscard]] CandidateConfig thesis_candidates();

/// All that the candidates of one scene rest on, made once per scene: the lines along which grasps may lie,
/// the obstacles, what the camera saw, the solids that the faces imply. Keeps no reference to its arguments.
class CandidateFinder {
 public:
  /// `cloud` may be null (thesis method, unorganised input): then nothing is known of unseen space, the
  /// object's points are the only obstacles, and there are no edge grasps. `collision` may hold the hand's
  /// tables from an earlier scene (same hand, same config); null makes them.
  CandidateFinder(const perception::Scene& scene, const perception::OrganisedCloud* cloud,
                  const HandModel& hand, const CandidateConfig& config,
                  std::shared_ptr<const HandCollision> collision = nullptr);

  /// Every candidate with its verdict: Ok, Collision, TooWide or Unstable. Ids count from 0 in the order
  /// Ega5, too wide, edge, wrap.
  [[nodiscard]] std::vector<GraspCandidate> find() const;

  /// Candidates on the lines that pass nearest to a point, at the point's foot on each line: where the
  /// closed-form optimum falls between two steps. Judged like the others. Leaves out what `existing` holds
  /// already (within 2 mm, with the same approach and closing axis); ids go on after the last of `existing`.
  [[nodiscard]] std::vector<GraspCandidate> near(const Vec3& point,
                                                 const std::vector<GraspCandidate>& existing) const;

  /// The same grasp taken at an angle to the face: the hand turned by `angle_rad` about its closing axis, so
  /// that the pads stay parallel to what they hold, and the palm as much farther away as its corner needs.
  /// Judged like the others. None for a cylinder, or where the fingers would not reach deep enough.
  [[nodiscard]] std::optional<GraspCandidate> turned(const GraspCandidate& candidate, double angle_rad) const;

  /// Sets verdict, reason and stability. Tries the hand turned by half a turn, and where fingers would meet
  /// the ground also a palm farther away, and keeps the first free way.
  void judge(GraspCandidate& candidate) const;

  [[nodiscard]] const CandidateConfig& config() const { return config_; }
  [[nodiscard]] const HandModel& hand() const { return hand_; }
  [[nodiscard]] const std::vector<GraspLine>& lines() const { return lines_; }
  [[nodiscard]] const CompletedSolids& solids() const { return solids_; }
  [[nodiscard]] const Obstacles& obstacles() const { return obstacles_; }
  [[nodiscard]] const HandCollision& collision() const { return *collision_; }
  [[nodiscard]] const SeenSpace* seen() const { return seen_ ? &*seen_ : nullptr; }

 private:
  /// A gap that keeps the fingers off the ground, if there is one with which they still hold.
  [[nodiscard]] std::optional<double> raised_gap(const GraspCandidate& candidate, const Collision& met) const;
  /// A palm in the middle of the hand meets the same when the hand is turned by half a turn.
  /// What a hand on a rim would meet of the object if it stood a little aside.
  [[nodiscard]] std::optional<Collision> beside(const GraspCandidate& candidate) const;
  [[nodiscard]] bool same_when_turned(const Collision& met) const;
  /// What is `enough_m` deep ends the search.
  [[nodiscard]] std::optional<Collision> collides(const GraspCandidate& candidate, double enough_m) const;

  HandModel hand_;
  CandidateConfig config_;
  Vec3 up_ = Vec3::UnitZ();
  Vec3 cog_ = Vec3::Zero();
  std::optional<SeenSpace> seen_;
  CompletedSolids solids_;
  Obstacles obstacles_;
  std::shared_ptr<const HandCollision> collision_;
  std::vector<GraspLine> lines_;
  std::vector<GraspCandidate> too_wide_;
};

/// The same in one call.
[[nodiscard]] std::vector<GraspCandidate> generate_candidates(
    const perception::Scene& scene, const HandModel& hand, const CandidateConfig& config,
    const perception::OrganisedCloud* cloud = nullptr);

/// One sentence on what became of the candidates; when none is free, how many fell to what and which came
/// nearest.
[[nodiscard]] std::string explain(const std::vector<GraspCandidate>& candidates);

[[nodiscard]] const char* name_of(GraspKind kind);

}  // namespace colift::planner
