#include "control/session/views/camera_set.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/session/views/in_box.hpp"
#include "perception/map/unseen_space.hpp"

namespace colift::control {

CameraSet::CameraSet(Method method, const Config& config, const RigView& rig, const hal::Clock& stopwatch)
    : config_(config), rig_(rig) {
  cameras_.emplace_back(CameraView(method, config, rig, rig.X_WC, stopwatch));
  for (const hal::Pose& X_WC : rig.X_WC_more)
    cameras_.emplace_back(CameraView(method, config, rig, X_WC, stopwatch));
  reports_.resize(cameras_.size());
}

bool CameraSet::let_lead(std::size_t camera) {
  if (camera >= cameras_.size()) return false;
  if (scene().knows_scene() && !cameras_[camera].knows_object()) return false;
  leads_ = camera;
  cameras_[camera].newest.reset();
  cameras_[camera].partner.reset();
  return true;
}

hal::Result<> CameraSet::see_scene() {
  if (auto seen = lead().analyse_scene(); !seen) return seen;
  // what the leading camera does not show, another one may
  for (std::size_t n = 0; n < cameras_.size() && !lead().analysis().scene.target; ++n) {
    CameraView& view = cameras_[n].view;
    if (n != leads_ && view.reference_frames() > 0 && view.analyse_scene() && view.analysis().scene.target)
      leads_ = n;
  }
  analyse_others();
  for (std::size_t n = 0; n < cameras_.size(); ++n) reports_[n] = cameras_[n].report;
  return {};
}

void CameraSet::analyse_others() {
  scene_of_ = leads_;
  cameras_[leads_].report = {true, true, NAN, NAN, "the scene is seen by it"};
  for (std::size_t n = 0; n < cameras_.size(); ++n)
    if (n != leads_) cameras_[n].report = analyse_beside(cameras_[n].view);
  join_centres();
}

ViewReport CameraSet::analyse_beside(CameraView& view) {
  ViewReport report;
  if (view.reference_frames() == 0) {
    report.reason = "it gave no picture of the scene that counts";
    return report;
  }
  const auto alignment = view.analyse_scene_beside(scene().analysis());
  if (!alignment) {
    report.reason = alignment.error().detail;
    return report;
  }
  report.used = true;
  if (alignment->enough) report.agreement_m = alignment->after_m;
  report.knows_object = is_same_object(view.analysis(), report.reason);
  if (!report.knows_object) view.forget_object();
  report.reason += (report.reason.empty() ? "" : "; ") + alignment->reason;
  return report;
}

bool CameraSet::is_same_object(const SceneAnalysis& analysis, std::string& reason) const {
  const auto& target = scene().analysis().scene.target;
  if (!target) return false;
  if (!analysis.scene.target || !analysis.scene.ground) {
    reason = "it does not see the object: " + analysis.reason;
    return false;
  }
  const hal::OrientedBox& box = target->shape;
  const hal::Vec3 half = 0.5 * box.size + hal::Vec3::Constant(config_.views.object_margin_m);
  const auto& points = analysis.scene.target->points;
  const auto inside = std::ranges::count_if(points, [&](const Eigen::Vector3f& p) {
    const hal::Vec3 in_box = in_frame_of(box, p.cast<double>());
    // what stands beneath it is no other thing: a view may not tell an object from its stands
    return (in_box.head<2>().cwiseAbs().array() <= half.head<2>().array()).all() && in_box.z() <= half.z();
  });
  const double part =
      static_cast<double>(inside) / static_cast<double>(std::max<std::size_t>(1, points.size()));
  if (part >= config_.views.min_of_object) return true;
  reason = fmt::format("what it sees there is not the object: {:.0f} % of it lies in the object's box",
                       1e2 * part);
  return false;
}

void CameraSet::join_centres() {
  std::vector<ViewOfObject> views;
  const auto add = [&](SceneAnalysis& analysis) {
    views.push_back({&*analysis.scene.target, &analysis.cloud});
  };
  if (scene().analysis().scene.target) add(scene().analysis());
  for (std::size_t n = 0; n < cameras_.size(); ++n)
    if (n != scene_of_ && cameras_[n].report.knows_object) add(cameras_[n].view.analysis());
  if (views.size() > 1) join_cogs(views, config_.views.covered_m);
}

hal::Result<> CameraSet::move_object(const hal::Pose& X) {
  if (auto moved = scene().move_object(X); !moved) return moved;
  const auto& target = scene().analysis().scene.target;
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    Camera& camera = cameras_[n];
    if (n == scene_of_ || !camera.knows_object()) continue;
    // a view that loses the object here still shows the room
    if (target && camera.view.move_object(X, target->obb.center) &&
        is_same_object(camera.view.analysis(), camera.report.reason))
      continue;
    camera.report.knows_object = false;
    camera.view.forget_object();
  }
  join_centres();
  return {};
}

hal::Result<perception::WorldMap> CameraSet::begin_to_watch(const RobotPosture& robot) {
  std::vector<Eigen::Vector3f> object = scene().analysis().scene.target->points;
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    if (n == scene_of_ || !cameras_[n].report.knows_object) continue;
    const auto& more = cameras_[n].view.analysis().scene.target->points;
    object.insert(object.end(), more.begin(), more.end());
  }
  if (auto made = scene().begin_to_watch(object); !made) return tl::unexpected(made.error());
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    Camera& camera = cameras_[n];
    if (n == scene_of_ || !camera.report.used || camera.view.begin_to_watch(object)) continue;
    camera.report.knows_object = false;
    camera.view.forget_object();
    camera.report.used = static_cast<bool>(camera.view.begin_to_watch(object));
  }
  perception::WorldMap map = make_map(robot);
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    if (several() && cameras_[n].report.used) cameras_[n].report.unseen_without = unseen(make_map(robot, n));
    reports_[n] = cameras_[n].report;
  }
  return map;
}

perception::WorldMap CameraSet::make_map(const RobotPosture& robot,
                                         std::optional<std::size_t> without) const {
  perception::WorldMap map(config_.map);
  std::vector<hal::Vec3> points;
  const auto enter = [&](std::size_t n) {
    const Camera& camera = cameras_[n];
    if (n == without || !camera.report.used) return;
    if (camera.report.knows_object)
      camera.view.enter(map, points);
    else
      camera.view.enter_around(map, scene().analysis().scene.target->shape, config_.map.cell_m);
  };
  enter(scene_of_);
  for (std::size_t n = 0; n < cameras_.size(); ++n)
    if (n != scene_of_) enter(n);
  map.carve_robot(rig_.model, robot.q_rad, robot.hand);
  map.set_target(points);
  return map;
}

double CameraSet::unseen(const perception::WorldMap& map) const {
  const SceneAnalysis& analysis = scene().analysis();
  if (!analysis.scene.target || !analysis.scene.ground) return NAN;
  const hal::OrientedBox& box = analysis.scene.target->shape;
  const double ground_z_m = box.center.z() - analysis.scene.ground->plane.height(box.center);
  return perception::unseen_fraction(map, perception::space_around(box, ground_z_m + config_.map.cell_m));
}

std::optional<PushedCamera> CameraSet::check_pose(std::size_t n, const hal::DepthFrame& frame,
                                                  const RobotPosture& robot) {
  Camera& camera = cameras_[n];
  const ViewsConfig& limits = config_.views;
  if (hal::seconds(frame.exposed_at - camera.pose_checked_at) < limits.check_pose_s) return std::nullopt;
  camera.pose_checked_at = frame.exposed_at;
  const auto moved = camera.view.compare_with_scene(frame, robot);
  const bool elsewhere =
      moved.receded > limits.max_receded ||
      (moved.enough && moved.shift_m > limits.pushed_m && moved.sigmas > limits.min_sigmas);
  camera.seen_elsewhere = elsewhere ? camera.seen_elsewhere + 1 : 0;
  if (camera.seen_elsewhere < limits.pushed_checks) return std::nullopt;
  camera.report.used = camera.report.knows_object = false;
  camera.report.reason = fmt::format(
      "it was pushed since the scene was seen: {:.0f} % of its image lies behind what stood there; {}",
      1e2 * moved.receded, moved.reason);
  reports_[n] = camera.report;
  return PushedCamera{n, camera.report.reason};
}

}  // namespace colift::control
