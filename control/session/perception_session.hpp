#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "control/session/rig_view.hpp"
#include "control/session/scene_analysis.hpp"
#include "control/session/views/view_report.hpp"
#include "perception/bodies/body_finder.hpp"
#include "perception/bodies/body_tracker.hpp"
#include "perception/calibration/arm_in_view/camera_correction.hpp"
#include "perception/map/world_map.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/partner/partner_grasp.hpp"
#include "perception/partner/partner_tracker.hpp"

namespace colift::control {

/// One frame, seen with the scene in mind.
struct Sight {
  perception::PartnerObservation partner;
  std::optional<perception::PartnerEvent> event;
  bool is_new = true;   ///< Of this frame; else `partner` is what an earlier one showed.
  bool hidden = false;  ///< His body, or the robot, is before a hand that was seen.
  double compute_ms = 0.0;
};

/// Bodies in one frame that are neither robot nor object nor known scene. Borrowed until the next one.
struct BodySighting {
  std::span<const perception::Body> bodies;
  std::span<const perception::BodyTrack> tracks;  ///< Of the first bodies, in their order.
  std::span<const perception::BodyPoint> points;  ///< Body::first and count refer to them.
};

/// Everything that the cameras tell during one job: first the scene (several frames averaged, the robot's own
/// pixels removed), then frame by frame where the partner's hands are, then how the object moves. One camera
/// leads: its frames are handed in by the calls below, and the scene is its own; the newest frames of the
/// others (take_frame()) are joined with them. One job, one thread.
class PerceptionSession {
 public:
  PerceptionSession(Method method, const Config& config, const RigView& rig, const hal::Clock& stopwatch);
  ~PerceptionSession();

  /// The newest frame of a camera that does not lead; each at its own time.
  void take_frame(std::size_t camera, hal::DepthFrame frame, const RobotPosture& robot);
  /// Another camera leads from here on, because the one that did gives no frames. Before the scene is seen,
  /// any can; later one that knows the object. False: this one cannot.
  [[nodiscard]] bool lead(std::size_t camera);
  [[nodiscard]] std::size_t leading() const;
  /// The camera that the scene is seen by.
  [[nodiscard]] std::size_t scene_camera() const;
  /// By camera, after analyse_scene(); that of the scene's own camera says nothing.
  [[nodiscard]] const std::vector<ViewReport>& views() const;
  /// A camera that was pushed since the scene was seen: it does not count any more. Each is said once. With
  /// several cameras only.
  [[nodiscard]] std::optional<PushedCamera> take_pushed();

  /// Collects a frame of the scene before anybody comes, and those of the other cameras that came since the
  /// last one. Frames that show nothing at all are left out.
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
  /// WorldMap::free_carried_off() with a frame of the leading camera.
  std::size_t free_carried_off(const hal::DepthFrame& frame);
  /// Leaves those points (W) of which a frame of the leading camera says nothing.
  void keep_hidden(const hal::DepthFrame& frame, std::vector<Eigen::Vector3f>& points_W) const;
  /// Part of the space around the object that no camera sees (0 to 1); NaN without an object.
  [[nodiscard]] double unseen() const;

  /// Looks for the partner's hands; the tracker turns touches into events. A method that is too slow for
  /// every frame looks at some; in between its last sighting is returned, and the tracker hears of nothing.
  /// Errors: NotFound before there is an object, and the method's.
  [[nodiscard]] hal::Result<Sight> observe_partner(const hal::DepthFrame& frame, const RobotPosture& robot);
  /// The same where nobody holds the object yet, and the robot does not: somebody whose body hides an edge of
  /// it holds it there, once it has risen and stands again (perception::RaisedEnd).
  [[nodiscard]] hal::Result<Sight> await_grasp(const hal::DepthFrame& frame, const RobotPosture& robot);
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
  [[nodiscard]] std::optional<perception::ObjectMotion> watch_object(
      const hal::DepthFrame& frame, const RobotPosture& robot,
      const std::optional<perception::HeldPoint>& held = std::nullopt);
  /// Visible area of the partner's hand at his contact (m^2; W, as the scene shows it), with the object moved
  /// by X; nullopt when the frame or the place shows nothing.
  [[nodiscard]] std::optional<perception::HandSighting> hand_at_grasp(const hal::DepthFrame& frame,
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
