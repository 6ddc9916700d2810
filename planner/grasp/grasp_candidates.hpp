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

/// How the thickness of a plate is measured below its rim.
struct RimConfig {
  double probe_step_m = 0.01;
  double place_m = 0.02;
  double depth_quantile = 0.95;
  double min_place_fraction = 1.0 / 3.0;
  int min_place_points = 4;

  template <class Visitor>
  void visit(Visitor& v) {
    v("probe_step_m", probe_step_m, hal::Range{0.001, 0.5},
      "Distance between the places along a rim at which the view beyond it is tested (m).");
    v("place_m", place_m, hal::Range{0.001, 0.5},
      "Length of the places along a rim at which the thickness is measured (m).");
    v("depth_quantile", depth_quantile, hal::Range{0, 0.999},
      "Quantile of the depths below the rim at one place that is the thickness there.");
    v("min_place_fraction", min_place_fraction, hal::kFraction,
      "Min fraction of the places with points; with fewer the thickness counts as not seen.");
    v("min_place_points", min_place_points, hal::Range{1, 1000},
      "Min number of points of a place that counts.");
  }
};

/// Where grasps are searched, and what refuses them.
struct CandidateConfig {
  double step_m = 0.05;
  double end_margin_m = 0.04;
  double min_width_m = 0.004;
  double min_length_m = 0.015;
  bool pads_bear = true;
  bool measure_depth = true;
  double max_bar_m = 0.09;
  int min_in_reach = 5;
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
  double max_pull_back_m = 0.015;
  int refine_lines = 4;
  int refine_steps = 3;
  double turn_step_deg = 20.0;
  double max_turn_deg = 0.0;
  double min_hold_depth_m = 0.03;
  double min_depth_gain_m = 0.01;
  double same_approach_cosine = 0.866;
  double palm_clearance_m = 0.006;
  RimConfig rim;
  SolidConfig solids;
  CollisionConfig collision;
  StabilityConfig stability;

  template <class Visitor>
  void visit(Visitor& v) {
    v("step_m", step_m, hal::Range{0.002, 1}, "Max distance between neighbouring grasps (m).");
    v("end_margin_m", end_margin_m, hal::Range{0, 0.5},
      "Distance of the outermost grasps from a surface's ends (m).");
    v("min_width_m", min_width_m, hal::Range{0, 0.2}, "Min width of a surface that is grasped (m).");
    v("min_length_m", min_length_m, hal::Range{0, 1}, "Min length of a surface that is grasped (m).");
    v("pads_bear", pads_bear,
      "Whether the load acts where the pads press, behind the face; the thesis takes the face itself.");
    v("measure_depth", measure_depth,
      "Whether the palm stays farther from a bar, leg or handle behind which the pads would press.");
    v("max_bar_m", max_bar_m, hal::Range{0, 0.2},
      "Max thickness of a bar that is grasped from sides that were not seen as faces (m).");
    v("min_in_reach", min_in_reach, hal::Range{0, 1000},
      "Number of grasps within the arm's reach below which more are searched: other sides of bars, smaller "
      "steps; 0: never.");
    v("edges", edges, "Whether rims of plates are grasped.");
    v("side_clearance_m", side_clearance_m, hal::Range{0, 0.2},
      "Distance to both sides along a rim within which the hand must not meet the object either, because of "
      "a leg only the faces towards the camera are seen (m).");
    v("assumed_thickness_m", assumed_thickness_m, hal::Range{0.001, 0.5},
      "Thickness of a plate whose edge was not seen (m).");
    v("edge_probe_m", edge_probe_m, hal::Range{0.001, 0.2},
      "Distance beyond a rim at which the view is tested (m).");
    v("edge_jump_m", edge_jump_m, hal::Range{0.001, 2}, "Min distance of the background behind a rim (m).");
    v("adjoin_m", adjoin_m, hal::Range{0, 0.2}, "Max distance between faces that adjoin at an edge (m).");
    v("max_free_of_solid", max_free_of_solid, hal::kFraction,
      "Max fraction of an implied box that may have been seen free.");
    v("wraps", wraps, "Whether cylinders are grasped.");
    v("wrap_step_deg", wrap_step_deg, hal::Range{1, 180},
      "Angle between approaches around a cylinder (deg).");
    v("try_both_ways", try_both_ways, "Whether the hand is tried turned by 180 degrees where it collides.");
    v("max_pull_back_m", max_pull_back_m, hal::Range{0, 0.1},
      "Max distance by which the hand reaches less far, where a finger would meet what is behind (m).");
    v("refine_lines", refine_lines, hal::Range{0, 100},
      "Number of grasp lines that get a candidate near a given point.");
    v("refine_steps", refine_steps, hal::Range{0, 100},
      "Number of candidates that are added on each side of the chosen one, up to its neighbours; 0: none.");
    v("turn_step_deg", turn_step_deg, hal::Range{1, 90},
      "Step of the angles at which the hand approaches a face that the arm does not reach along its normal "
      "(deg).");
    v("max_turn_deg", max_turn_deg, hal::Range{0, 60},
      "Max such angle; 0: the hand always approaches along the face's normal (deg).");
    v("min_hold_depth_m", min_hold_depth_m, hal::Range{0, 0.5},
      "Min depth of the pads behind the face in candidates that grip less deep than the hand can (m).");
    v("min_depth_gain_m", min_depth_gain_m, hal::Range{0, 0.5},
      "Min difference in depth to the deepest grip for such a candidate to be added (m).");
    v("same_approach_cosine", same_approach_cosine, hal::kFraction,
      "Min cosine between the approaches of an edge grasp and of the face grasp that it repeats (0.866: 30 "
      "degrees).");
    v("palm_clearance_m", palm_clearance_m, hal::Range{0, 0.1},
      "Min distance of the palm from the face where the hand is turned (m).");
    v("rim", rim, "How the thickness of a plate is measured below its rim.");
    v("solids", solids, "When two faces imply a solid behind them.");
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

  /// Candidates on the line of one of them, on both sides of it up to its neighbours (config.refine_steps).
  /// Judged like the others, without those of `existing`; ids go on after its last. None for a candidate that
  /// was turned off its line.
  [[nodiscard]] std::vector<GraspCandidate> around(const GraspCandidate& candidate,
                                                   const std::vector<GraspCandidate>& existing) const;

  /// Candidates at this step on all lines and on the other sides of bars, without those that `existing` holds
  /// within half a step. Judged like the others; ids go on after the last of `existing`.
  [[nodiscard]] std::vector<GraspCandidate> between(double step_m,
                                                    const std::vector<GraspCandidate>& existing) const;

  /// The same grasp taken at an angle to the face: the hand turned by `angle_rad` about its closing axis, so
  /// that the pads stay parallel to what they hold, and the palm as much farther away as its corner needs.
  /// Judged like the others. None where the fingers would not reach deep enough.
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
  /// A gap at which the fingers reach less far behind the face, where one of them met the object there.
  [[nodiscard]] std::optional<double> pulled_back_gap(const GraspCandidate& candidate,
                                                      const Collision& met) const;
  /// A gap that keeps the fingers off the ground, if there is one with which they still hold.
  [[nodiscard]] std::optional<double> raised_gap(const GraspCandidate& candidate, const Collision& met) const;
  /// Collision of a hand on a rim with the object, with the hand shifted sideways along the rim.
  [[nodiscard]] std::optional<Collision> beside(const GraspCandidate& candidate) const;
  /// Whether the hand turned by half a turn about the approach has the same collision: a palm in the middle
  /// does not move then.
  [[nodiscard]] bool same_when_turned(const Collision& met) const;
  /// First collision of the hand at this grasp. Early exit at a penetration depth of `enough_m`.
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

/// Candidates that were refused for one kind of reason.
struct Refusals {
  std::string why;  ///< "out of the arm's reach", "would move through unobserved space", ...
  int count = 0;
  const GraspCandidate* nearest = nullptr;  ///< Of them the one that was least short of it; never null.
};

/// Why candidates were refused, the most frequent reason first. Points into `candidates`.
[[nodiscard]] std::vector<Refusals> refusals(const std::vector<GraspCandidate>& candidates);

/// One sentence on what became of the candidates; when none is free, how many fell to what and which came
/// nearest.
[[nodiscard]] std::string explain(const std::vector<GraspCandidate>& candidates);

[[nodiscard]] const char* name_of(GraspKind kind);

}  // namespace colift::planner
