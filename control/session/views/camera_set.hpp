#pragma once

#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "control/session/views/camera_view.hpp"
#include "control/session/views/joined_views.hpp"
#include "control/session/views/view_report.hpp"

namespace colift::control {

/// The newest frame of a camera that does not lead, and who has not looked at it yet.
struct NewestFrame {
  hal::DepthFrame frame;
  RobotPosture robot;
  bool for_partner = true, for_motion = true, for_pose = true;
};

/// One camera of a set, and what its frames last showed.
struct Camera {
  explicit Camera(CameraView v) : view(std::move(v)) {}

  CameraView view;
  ViewReport report;
  std::optional<NewestFrame> newest;
  std::optional<ViewOfPartner> partner;  ///< In the last of its frames that was looked at.
  std::vector<Eigen::Vector3f> partner_points;
  hal::Timestamp pose_checked_at{0};
  int seen_elsewhere = 0;  ///< Checks in a row by which it was pushed.

  [[nodiscard]] bool knows_object() const { return report.used && view.knows_object(); }
};

/// All cameras of a rig on one scene. One leads: its frames are the job's clock. The scene is of one camera
/// too, mostly of the same; the others are aligned to it. One thread.
class CameraSet {
 public:
  CameraSet(Method method, const Config& config, const RigView& rig, const hal::Clock& stopwatch);

  [[nodiscard]] CameraView& lead() { return cameras_[leads_].view; }
  [[nodiscard]] const CameraView& lead() const { return cameras_[leads_].view; }
  [[nodiscard]] CameraView& scene() { return cameras_[scene_of_].view; }
  [[nodiscard]] const CameraView& scene() const { return cameras_[scene_of_].view; }
  [[nodiscard]] std::size_t leading() const { return leads_; }
  [[nodiscard]] std::size_t scene_camera() const { return scene_of_; }
  [[nodiscard]] bool several() const { return cameras_.size() > 1; }
  [[nodiscard]] std::vector<Camera>& cameras() { return cameras_; }
  [[nodiscard]] const std::vector<ViewReport>& reports() const { return reports_; }

  /// Before the scene is seen any camera can lead; later one that knows the object. False: this one cannot.
  [[nodiscard]] bool let_lead(std::size_t camera);
  /// Calls `work(camera, its number)` for those that do not lead and have a frame of about that time.
  template <class Work>
  void beside(hal::Timestamp at, Work work) {
    for (std::size_t n = 0; n < cameras_.size(); ++n) {
      Camera& camera = cameras_[n];
      if (n == leads_ || !camera.report.used || !camera.newest) continue;
      const double age_s = hal::seconds(at - camera.newest->frame.exposed_at);
      if (std::abs(age_s) <= config_.views.max_age_s) work(camera, n);
    }
  }

  /// The scene by the leading camera, or by another one where that shows no object; the others are aligned
  /// to it. Errors: those of PerceptionSession::analyse_scene().
  [[nodiscard]] hal::Result<> see_scene();
  /// The scene as if the object stood where X takes it. Errors: those of CameraView::move_object().
  [[nodiscard]] hal::Result<> move_object(const hal::Pose& X_Wnow_Wthen);
  /// After one of these, where there is an object: further frames of all cameras are compared with it. The
  /// collision map comes back. Errors: those of CameraView::begin_to_watch(), of the scene's camera.
  [[nodiscard]] hal::Result<perception::WorldMap> begin_to_watch(const RobotPosture& robot);
  /// Part of the space around the object of which a map says nothing; NaN without an object.
  [[nodiscard]] double unseen(const perception::WorldMap& map) const;

  /// Now and then, whether a camera still is where the scene was seen from; one that is not does not count
  /// any more.
  [[nodiscard]] std::optional<PushedCamera> check_pose(std::size_t camera, const hal::DepthFrame& frame,
                                                       const RobotPosture& robot);

 private:
  void analyse_others();
  [[nodiscard]] ViewReport analyse_beside(CameraView& view);
  /// Whether what a view takes for the object is the one of the scene; else why not.
  [[nodiscard]] bool is_same_object(const SceneAnalysis& analysis, std::string& reason) const;
  void join_centres();
  /// Of all views, or of all but one.
  [[nodiscard]] perception::WorldMap make_map(const RobotPosture& robot,
                                              std::optional<std::size_t> without = {}) const;

  const Config& config_;
  RigView rig_;
  std::vector<Camera> cameras_;
  std::vector<ViewReport> reports_;
  std::size_t leads_ = 0, scene_of_ = 0;
};

}  // namespace colift::control
