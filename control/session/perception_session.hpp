#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "control/session/scene_analysis.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "perception/bodies/body_finder.hpp"
#include "perception/bodies/body_tracker.hpp"
#include "perception/calibration/arm_in_view/camera_correction.hpp"
#include "perception/map/world_map.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/partner/partner_grasp.hpp"
#include "perception/partner/partner_tracker.hpp"
#include "perception/self_filter.hpp"

namespace colift::control {

/// What seeing needs to know about the rig, beside the configuration.
struct RigView {
  const hal::RobotModel& model;
  const planner::HandModel& hand;
  std::shared_ptr<const planner::HandCollision> hand_tables;
  hal::Pose X_WC = hal::Pose::Identity();
};

/// Where the robot is when a frame is taken.
struct RobotPosture {
  hal::JointVector q_rad = hal::JointVector::Zero();
  hal::HandPosture hand;
};

/// One frame, seen with the scene in mind.
struct Sight {
  perception::PartnerObservation partner;
  std::optional<perception::PartnerEvent> event;
  bool is_new = true;  ///< Of this frame; else `partner` is what an earlier one showed.
  double compute_ms = 0.0;
};

/// Bodies in one frame that are neither robot nor object nor known scene. Borrowed until the next one.
struct BodySighting {
  std::span<const perception::Body> bodies;
  std::span<const perception::BodyTrack> tracks;  ///< Of the first bodies, in their order.
  std::span<const perception::BodyPoint> points;  ///< Body::first and count refer to them.
};

/// `where` of the error when the camera is not where its calibration says.
inline constexpr const char* kCameraOff = "calibration";

/// Everything that the camera tells during one job: first the scene (several frames averaged, the robot's own
/// pixels removed), then frame by frame where the partner's hands are, then how the object moves. One job,
/// one thread.
class PerceptionSession {
 public:
  PerceptionSession(Method method, const Config& config, const RigView& rig, const hal::Clock& stopwatch);
  ~PerceptionSession();

  /// Collects a frame of the scene before anybody comes. Frames that show nothing at all are left out.
  void add_reference(hal::DepthFrame frame, const RobotPosture& robot);
  [[nodiscard]] int reference_frames() const;
  void forget_reference();

  /// Makes scene, candidates, collision map and partner finder from the collected frames. Whether there is
  /// something to carry stands in the look. The first time, the camera's calibration is corrected from the
  /// arm in these frames; one that is refused is judged anew with the next scene. Errors: NotFound (the
  /// frames show nothing, or things moved meanwhile), BadInput, BadConfig at kCameraOff.
  [[nodiscard]] hal::Result<> analyse_scene(const RobotPosture& robot);

  /// The object was put down elsewhere; X takes a point of it from where it stood to where it stands (W, a
  /// few centimetres). The scene is taken as if it had been seen so: everything is made anew. Errors: as
  /// analyse_scene().
  [[nodiscard]] hal::Result<> object_moved(const hal::Pose& X_Wnow_Wthen, const RobotPosture& robot);

  /// What the first scene said about the camera's calibration; unset before it, or when switched off. All
  /// frames that come in are corrected by it.
  [[nodiscard]] const std::optional<perception::CameraCorrection>& camera_correction() const;
  /// A frame as this session uses it: for pictures beside the scene.
  [[nodiscard]] hal::DepthFrame corrected(hal::DepthFrame frame) const;

  [[nodiscard]] SceneAnalysis& analysis();
  [[nodiscard]] const SceneAnalysis& analysis() const;
  [[nodiscard]] const perception::WorldMap& map() const;

  /// Looks for the partner's hands; the tracker turns touches into events. A method that is too slow for
  /// every frame looks at some; in between its last sighting is returned, and the tracker hears of nothing.
  /// Errors: NotFound before there is an object, and the method's.
  [[nodiscard]] hal::Result<Sight> observe_partner(hal::DepthFrame frame, const RobotPosture& robot);
  /// The camera gave nothing: a silent one must not keep a grasp alive.
  std::optional<perception::PartnerEvent> no_frame(hal::Timestamp now);
  /// The robot was busy for so long, and no frame was looked at.
  void looked_away(hal::Duration how_long);
  [[nodiscard]] const perception::PartnerTracker& tracker() const;
  void forget_partner();

  /// Everybody and everything that was not there in the reference, the partner too. Empty before there is an
  /// object.
  [[nodiscard]] BodySighting observe_bodies(const hal::DepthFrame& frame, const RobotPosture& robot);

  /// Points of the partner in the last frame that was looked at, in W: his hands, arms and body near the
  /// object.
  [[nodiscard]] const std::vector<Eigen::Vector3f>& partner_points() const;

  /// Where the object is now against the scene; nullopt when too little of it is seen.
  [[nodiscard]] std::optional<perception::ObjectMotion> watch_object(hal::DepthFrame frame,
                                                                     const RobotPosture& robot);
  /// Visible area of the partner's hand at his contact (m^2; W, as the scene shows it), with the object moved
  /// by X; nullopt when the frame or the place shows nothing.
  [[nodiscard]] std::optional<perception::HandSighting> hand_at_grasp(hal::DepthFrame frame,
                                                                      const RobotPosture& robot,
                                                                      const hal::Pose& X_Wnow_Wref,
                                                                      const hal::Vec3& contact_W);
  /// It was put down, and stands about where the scene was seen: what was followed before is forgotten.
  void object_stands_again();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::control
