#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "control/config/config.hpp"
#include "control/session/pipeline.hpp"
#include "control/session/rig_view.hpp"
#include "control/session/scene_analysis.hpp"
#include "perception/bodies/body_finder.hpp"
#include "perception/calibration/arm_in_view/camera_correction.hpp"
#include "perception/map/world_map.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/partner/grasp_presence.hpp"
#include "perception/partner/partner_grasp.hpp"
#include "perception/views/view_alignment.hpp"

namespace colift::control {

/// What one frame shows of the partner.
struct PartnerSighting {
  perception::PartnerObservation observation;
  bool seen_before = false;  ///< An earlier frame showed his hand at the object.
  bool hidden = false;       ///< His body, or the robot, is before that hand.
};

/// What one camera tells during a job, by itself: its scene, from several frames without the robot, and then,
/// frame by frame, partner, bodies and the object's motion. PerceptionSession joins the views of all cameras.
/// One thread.
class CameraView {
 public:
  /// `X_WC`: where this camera is, by its calibration. The config has to outlive the view.
  CameraView(Method method, const Config& config, const RigView& rig, const hal::Pose& X_WC,
             const hal::Clock& stopwatch);
  ~CameraView();
  CameraView(CameraView&&) noexcept;

  /// Collects a frame of the scene before anybody comes. Frames that show nothing at all are left out.
  void add_reference(hal::DepthFrame frame, const RobotPosture& robot);
  [[nodiscard]] int reference_frames() const;
  void forget_reference();

  /// Makes scene and candidates from the collected frames, and corrects the camera's calibration the first
  /// time. Errors: those of PerceptionSession::analyse_scene().
  [[nodiscard]] hal::Result<> analyse_scene();
  /// The same for a camera beside the one that saw `first`: its pose is corrected to agree with that view,
  /// and the object is the one there. Errors also: BadConfig, at kCameraOff, where the two do not agree.
  [[nodiscard]] hal::Result<perception::ViewAlignment> analyse_scene_beside(const SceneAnalysis& first);
  /// How far what stands still in a frame is from where the scene has it; the camera was pushed.
  [[nodiscard]] perception::ViewAlignment compare_with_scene(hal::DepthFrame frame,
                                                             const RobotPosture& robot);
  /// The scene as if the object had been seen where X takes it (W).
  [[nodiscard]] hal::Result<> move_object(const hal::Pose& X_Wnow_Wthen,
                                          const std::optional<hal::Vec3>& at_W = std::nullopt);
  /// After one of these: what will look for bodies, and, where this view shows the object, for the partner
  /// and for its motion. `object`: visible points of it in any view (W).
  [[nodiscard]] hal::Result<> begin_to_watch(std::span<const Eigen::Vector3f> object);
  /// The scene was seen: bodies are found in further frames.
  [[nodiscard]] bool knows_scene() const;
  /// Further frames also tell of partner and object.
  [[nodiscard]] bool knows_object() const;
  /// What it takes for the object is something else: it says nothing of partner and object.
  void forget_object();

  [[nodiscard]] SceneAnalysis& analysis();
  [[nodiscard]] const SceneAnalysis& analysis() const;
  [[nodiscard]] const std::optional<perception::CameraCorrection>& correction() const;
  void correct(hal::DepthFrame& frame) const;
  /// Points of a further frame (W).
  [[nodiscard]] perception::OrganisedCloud cloud_of(hal::DepthFrame frame) const;

  /// Enters its scene into the map and appends the object's points, slivers included (W).
  void enter(perception::WorldMap& map, std::vector<hal::Vec3>& object_points) const;
  /// The same for a view that does not know the object: what lies in `object`, of which the others know,
  /// grown by `margin_m` is no obstacle.
  void enter_around(perception::WorldMap& map, const hal::OrientedBox& object, double margin_m) const;

  /// A method that is too slow for every frame looks at one of so many.
  [[nodiscard]] int frames_per_sight() const;
  /// Looks for the partner's hands; `points` becomes what is seen of him (W). Errors: NotFound where the
  /// object is not known, and the method's.
  [[nodiscard]] hal::Result<PartnerSighting> find_partner(const hal::DepthFrame& frame,
                                                          const RobotPosture& robot,
                                                          std::vector<Eigen::Vector3f>& points);
  void forget_partner();
  /// Everybody and everything that was not there in the reference; their points are those of body_points().
  /// Empty before the scene is known. Valid until the next call.
  [[nodiscard]] std::span<const perception::Body> find_bodies(const hal::DepthFrame& frame,
                                                              const RobotPosture& robot,
                                                              const hal::Pose& X_WTnow_WTref);
  [[nodiscard]] std::span<const perception::BodyPoint> body_points() const;

  /// Where the object is now against the scene; nullopt when too little of it is seen.
  [[nodiscard]] std::optional<perception::ObjectMotion> watch_object(
      const hal::DepthFrame& frame, const RobotPosture& robot,
      const std::optional<perception::HeldPoint>& held = std::nullopt);
  [[nodiscard]] hal::Pose last_motion() const;
  [[nodiscard]] std::optional<perception::HandSighting> hand_at_grasp(const hal::DepthFrame& frame,
                                                                      const RobotPosture& robot,
                                                                      const hal::Pose& X_Wnow_Wref,
                                                                      const hal::Vec3& contact_W);
  void object_stands_again();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::control
