#pragma once

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "planner/grasp_candidate.hpp"
#include "planner/hand/completed_shape.hpp"
#include "planner/hand/hand_model.hpp"
#include "planner/hand/hand_sweep.hpp"
#include "planner/hand/obstacles.hpp"
#include "planner/hand/seen_space.hpp"

namespace colift::planner {

/// When a hand counts as colliding.
struct CollisionConfig {
  double approach_m = 0.10;
  double closing_step_deg = 2.0;
  double feature_margin_m = 0.005;
  double feature_sigmas = 3.0;
  double ragged_px = 4.0;
  double ground_clearance_m = 0.005;
  bool refuse_unseen = true;
  double max_unseen_m = 0.10;
  double unseen_fraction = 0.2;
  double sight_sigmas = 3.0;
  int shadow_px = 30;
  double unseen_sample_m = 0.015;
  ObstacleConfig obstacles;

  template <class Visitor>
  void visit(Visitor& v) {
    v("approach_m", approach_m, hal::Range{0, 1},
      "Length of the straight approach before the grasp that is checked (m).");
    v("closing_step_deg", closing_step_deg, hal::Range{0.75, 20},
      "Step of the inner joint along the closing (deg).");
    v("feature_margin_m", feature_margin_m, hal::Range{0, 0.1},
      "Allowance for the grasped feature's points (m).");
    v("feature_sigmas", feature_sigmas, hal::Range{0, 10}, "The same in standard deviations of the depth.");
    v("ragged_px", ragged_px, hal::Range{0, 20},
      "Max error of edges in the image; closing fingers may touch the object that much earlier (px).");
    v("ground_clearance_m", ground_clearance_m, hal::Range{0, 0.2},
      "Distance that the hand keeps from the ground (m).");
    v("refuse_unseen", refuse_unseen, "Whether space that the camera did not see is taken as not free.");
    v("max_unseen_m", max_unseen_m, hal::Range{0, 1}, "Max reach of the fingers into unseen space (m).");
    v("unseen_fraction", unseen_fraction, hal::kFraction,
      "Max fraction of the volume that a part of the hand sweeps before the face that may be unseen.");
    v("sight_sigmas", sight_sigmas, hal::Range{0, 20},
      "Tolerance in the test for unseen space, in standard deviations of the depth noise.");
    v("shadow_px", shadow_px, hal::Range{0, 640},
      "Max length of a row of missing pixels that is filled from its ends (px).");
    v("unseen_sample_m", unseen_sample_m, hal::Range{0.002, 0.1},
      "Distance between the points of the hand's volume that are tested for unseen space (m).");
    v("obstacles", obstacles, "Which points are obstacles.");
  }
};

/// A hand put at a grasp.
struct HandPlacement {
  Pose X_WH = Pose::Identity();
  double width_m = 0.0;   ///< Object between the fingers: the closing ends there.
  double gap_m = 0.0;     ///< Palm plane to the face.
  double margin_m = 0.0;  ///< Allowance around the grasped feature.
  double ragged_m = 0.0;  ///< How much earlier than that closing fingers may touch the object; 0: not at all.
};

/// What the hand would meet.
struct Collision {
  enum class With { Object, Surroundings, Ground, Unseen, Reach, Completed };
  With with = With::Object;
  std::string part;      ///< Name of the part of the hand.
  double depth_m = 0.0;  ///< How far inside; for Unseen the part of the way (0 to 1).
  Vec3 at = Vec3::Zero();

  /// By how much the hand would have to give way (m); for Unseen a quarter of a metre times the part that was
  /// not seen, so that a look from elsewhere counts as farther away than a few millimetres.
  [[nodiscard]] double miss_m() const {
    return with == With::Unseen ? 0.25 * depth_m : std::max(0.001, depth_m);
  }

  /// "finger 2 meets the object 14 mm inside".
  [[nodiscard]] std::string text() const;
};

/// Tests a hand against points, ground and unseen space.
///
/// The grasped feature is allowed between the fingers: all points with |y| <= width / 2 + margin and z >= gap
/// - margin in H. Everything else inside the hand's body, inside the open hand along the straight approach,
/// or inside the fingers while they close down to the width, is a collision (thesis 5.3.2.3: one point inside
/// rejects). One exception: edges in a depth image stray by some pixels, so fingers that meet the object when
/// they have but margin + `ragged_m` each to go have taken hold of it and stop there. The points are tested
/// exactly: buckets and tables only leave out points that cannot be inside.
///
/// Unseen space: docs/decisions/0004-unseen-space.md.
class HandCollision {
 public:
  HandCollision(const HandModel& hand, const CollisionConfig& config);

  /// Placement of a candidate; the margin follows the depth noise where it is.
  [[nodiscard]] HandPlacement place(const GraspCandidate& candidate, const SeenSpace* seen) const;

  /// Ground, then points: first in the order of the motion (before the fingers close, then while they do),
  /// there the deepest. A collision that is `enough_m` deep or deeper may be returned in its place as soon as
  /// it is found.
  [[nodiscard]] std::optional<Collision> check(
      const HandPlacement& placement, const Obstacles& obstacles,
      double enough_m = std::numeric_limits<double>::infinity()) const;

  /// The same verdict from every point in the hand's bounding box against every box of the hand, without
  /// buckets and tables; for tests and benchmarks.
  [[nodiscard]] std::optional<Collision> check_exact(const HandPlacement& placement,
                                                     const Obstacles& obstacles) const;

  /// Unseen space before the face, reach into unseen space behind it, and completed solids.
  [[nodiscard]] std::optional<Collision> check_unseen(const HandPlacement& placement, const SeenSpace& seen,
                                                      const CompletedSolids& solids) const;

  [[nodiscard]] const HandSweep& sweep() const { return sweep_; }
  [[nodiscard]] const CollisionConfig& config() const { return config_; }

 private:
  /// Points of the volume that one part takes, in the order of the steps.
  struct Samples {
    std::vector<float> x, y, z;
    std::vector<std::uint8_t> step;
  };
  [[nodiscard]] std::optional<Collision> check_ground(const HandPlacement& placement,
                                                      const Obstacles& obstacles, int last) const;
  void sample_volume();

  HandModel hand_;
  CollisionConfig config_;
  HandSweep sweep_;
  std::vector<Samples> samples_;  ///< For each part, for the test of unseen space.
};

}  // namespace colift::planner
