#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "perception/scene.hpp"
#include "perception/world_map.hpp"
#include "planner/motion/collision_spheres.hpp"
#include "planner/motion/distance_field.hpp"

namespace colift::planner {

struct SceneConfig {
  double margin_m = 0.01;
  bool hidden_is_obstacle = true;
  bool out_of_view_is_obstacle = false;
  double ground_clearance_m = 0.005;
  double partner_clearance_m = 0.12;

  template <class Visitor>
  void visit(Visitor& v) {
    v("margin_m", margin_m, hal::Range{0, 0.2}, "Distance that the arm keeps from obstacles (m).");
    v("hidden_is_obstacle", hidden_is_obstacle,
      "Whether the arm keeps out of space behind what was seen; the hand has a rule of its own for it.");
    v("out_of_view_is_obstacle", out_of_view_is_obstacle,
      "The same for space at which the camera does not look.");
    v("ground_clearance_m", ground_clearance_m, hal::Range{0, 0.2},
      "Distance that links keep from the ground (m).");
    v("partner_clearance_m", partner_clearance_m, hal::Range{0, 1},
      "Distance that arm and hand keep from the partner's hands and body (m).");
  }
};

/// Which contacts a motion may make.
enum class Contacts {
  None,             ///< On the way: nothing may touch anything.
  FingersOnTarget,  ///< Last bit of the approach, and away again: hand links may be beside the target (their
                    ///< exact test is HandCollision's), arm links may not.
  Carrying,  ///< The target is in the hand and carried along.
};

/// Everything a motion must not touch, made once for a map: distance fields of scene and target, ground
/// plane, the partner's points. Immutable; any thread.
struct CollisionScene {
  DistanceField obstacles;      ///< Occupied cells, not the target: for hand links.
  DistanceField arm_obstacles;  ///< The same and hidden cells as configured: for arm links.
  DistanceField target;
  hal::Plane ground;
  std::vector<Eigen::Vector3f> carried_W;  ///< Target's cells as they stand before the lift (for Carrying).
  SceneConfig config;
};
/// `partner_points` keep the robot away from him; may be empty.
[[nodiscard]] CollisionScene make_collision_scene(const perception::WorldMap& map, const hal::Plane& ground,
                                                  std::span<const Eigen::Vector3f> partner_points,
                                                  const SceneConfig& config);

/// What a configuration would touch.
struct Touch {
  enum class With { Nothing, Obstacle, Target, Ground, Itself, Limits, Carried };
  With with = With::Nothing;
  std::string part;                        ///< Link that touches.
  double depth_m = 0.0;                    ///< By how much it is too near.
  [[nodiscard]] std::string text() const;  ///< "forearm comes 12 mm too near to an obstacle"
};

/// Conservative and fast: spheres against distance fields, self collision by sphere pairs, joint limits.
/// Keeps buffers: one checker, one thread.
class FastChecker {
 public:
  FastChecker(const hal::RobotModel& model, const SphereModel& spheres,
              std::shared_ptr<const CollisionScene> scene);
  ~FastChecker();
  FastChecker(FastChecker&&) noexcept;

  /// Posture of the hand for what follows (open by default), and what it may touch.
  void set_hand(const hal::HandPosture& hand);
  void allow(Contacts contacts);
  /// For Carrying: where the palm holds the target, in W, before the lift.
  void set_carry_origin(const hal::Pose& X_WH);

  [[nodiscard]] bool is_free(const hal::JointVector& q_rad);
  /// The straight motion between two joint positions at steps of at most `step_rad` in any joint; batched,
  /// the middle first. False as soon as one is not free.
  [[nodiscard]] bool is_free(const hal::JointVector& from, const hal::JointVector& to, double step_rad);
  /// The first thing that is touched, for words.
  [[nodiscard]] Touch what_touches(const hal::JointVector& q_rad);
  [[nodiscard]] std::size_t checks() const;  ///< States looked at so far.

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The exact judge: FCL primitives of the URDF against the OctoMap's octree, boxes of the target's cells,
/// ground and self. Slow; every final path is checked with it again.
class ExactChecker {
 public:
  ExactChecker(const hal::RobotModel& model, const perception::WorldMap& map, const hal::Plane& ground);
  ~ExactChecker();
  ExactChecker(ExactChecker&&) noexcept;
  void set_hand(const hal::HandPosture& hand);
  void allow(Contacts contacts);
  [[nodiscard]] Touch what_touches(const hal::JointVector& q_rad);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::planner
