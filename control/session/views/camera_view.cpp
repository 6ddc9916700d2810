#include "control/session/views/camera_view.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "control/session/views/in_box.hpp"
#include "hal/types/units.hpp"
#include "perception/motion/moved_object.hpp"
#include "perception/partner/contact_cover.hpp"
#include "perception/reference_image.hpp"
#include "perception/self_filter.hpp"
#include "perception/target/slivers.hpp"

namespace colift::control {
namespace {

bool shows_anything(const hal::DepthFrame& frame) {
  if (frame.depth_m.size() !=
      static_cast<std::size_t>(frame.intrinsics.width) * static_cast<std::size_t>(frame.intrinsics.height))
    return false;
  return std::any_of(frame.depth_m.begin(), frame.depth_m.end(), [](float d) { return d > 0.0f; });
}

bool same(const RobotPosture& a, const RobotPosture& b) {
  return a.q_rad == b.q_rad && a.hand.inner_rad == b.hand.inner_rad && a.hand.outer_rad == b.hand.outer_rad &&
         a.hand.spread_rad == b.hand.spread_rad;
}

/// A frame with the camera corrected and without the robot's own pixels.
struct CleanFrame {
  hal::DepthFrame frame;
  std::vector<std::uint32_t> robot;  ///< The pixels that were its own.
  RobotPosture posture;
  bool made = false;
};

}  // namespace

struct CameraView::Impl {
  Impl(Method m, const Config& c, const RigView& r, const hal::Pose& X, const hal::Clock& s)
      : method(m), config(c), rig(r), X_WC(X), stopwatch(s), hand_pixels(c.tracker.hidden) {
    // a method that is not there is said by the first look
    if (auto made = make_pipeline(m)) pipeline = std::move(*made);
  }

  Method method;
  std::unique_ptr<const Pipeline> pipeline;
  const Config& config;
  RigView rig;
  hal::Pose X_WC;
  const hal::Clock& stopwatch;

  std::vector<hal::DepthFrame> reference_frames;
  std::optional<hal::DepthFrame> with_robot;  ///< The first of them, before the robot was taken out.
  RobotPosture robot_then;
  std::vector<hal::DepthFrame> whole_frames;  ///< All of them, as long as the camera is not yet judged.
  std::vector<RobotPosture> postures;         ///< Of the robot in each of these.
  std::optional<perception::CameraCorrection> correction;
  std::optional<perception::SelfFilter> filter;
  CleanFrame clean;  ///< Of the newest frame.
  std::optional<perception::ReferenceImage> reference;
  SceneAnalysis analysis;
  std::unique_ptr<PartnerSight> partner_sight;
  std::optional<perception::ObjectFollower> follower;
  perception::HandPixels hand_pixels;
  std::optional<perception::SelfFilter> body_filter;  ///< With a wider margin than the other's.
  std::optional<perception::BodyFinder> body_finder;
  hal::DepthFrame body_frame;
  std::vector<char> robot_hid;  ///< By pixel, in any frame of the reference.

  /// A refused camera is judged again with each scene: somebody may have put it back, or nobody has.
  [[nodiscard]] bool camera_known() const {
    return correction && correction->verdict != perception::CameraCorrection::Verdict::Refused;
  }

  void correct(hal::DepthFrame& frame) const {
    if (correction) correction->correct(frame);
  }

  void take_reference(hal::DepthFrame frame, const RobotPosture& robot) {
    const auto& hidden = hide_robot(frame, robot);
    if (reference_frames.empty()) robot_hid.assign(frame.depth_m.size(), 0);
    for (const std::uint32_t p : hidden)
      if (p < robot_hid.size()) robot_hid[p] = 1;
    reference_frames.push_back(std::move(frame));
  }

  hal::Result<> build_reference(std::span<const hal::DepthFrame> frames) {
    auto built = perception::build_reference(frames, X_WC, config.noise, config.partner.reference);
    if (!built) return tl::unexpected(built.error());
    reference = std::move(*built);
    return {};
  }

  /// Estimates the camera's correction from the frames with the robot; true: everything is to be seen anew
  /// with it.
  hal::Result<bool> correct_camera() {
    std::vector<hal::DepthFrame> frames;
    frames.swap(whole_frames);
    const auto whole = perception::build_reference(frames, X_WC, config.noise, config.partner.reference);
    if (!whole) return tl::unexpected(whole.error());
    hal::DepthFrame mean;
    mean.intrinsics = frames.front().intrinsics;
    mean.depth_m = whole->cloud.depth_m;
    const hal::Vec3 middle = config.calibration.workspace_center_m,
                    half = 0.5 * config.calibration.workspace_size_m;
    correction = perception::estimate_correction(mean, whole->frames, X_WC, rig.model, postures.front().q_rad,
                                                 postures.front().hand, config.noise,
                                                 {middle - half, middle + half}, config.camera_correction);
    if (correction->verdict == perception::CameraCorrection::Verdict::Refused && config.pose_check.on)
      return hal::failure(hal::ErrorCode::BadConfig, kCameraOff,
                          fmt::format("the camera is not where its calibration says: {}; calibrate again",
                                      correction->reason));
    if (!correction->applied()) return false;
    X_WC = X_WC * correction->X_KC;
    forget_filters();
    reference_frames.clear();
    for (std::size_t n = 0; n < frames.size(); ++n) {
      correct(frames[n]);
      if (n == 0 && with_robot) with_robot = frames[n];
      take_reference(std::move(frames[n]), postures[n]);
    }
    return true;
  }

  // the robot's own pixels are nobody's
  const std::vector<std::uint32_t>& hide_robot(hal::DepthFrame& frame, const RobotPosture& robot) {
    if (!filter) filter.emplace(rig.model, frame.intrinsics, X_WC, config.noise, config.self_filter);
    return filter->remove(frame, robot.q_rad, robot.hand);
  }

  /// The camera is not where it was thought to be.
  void forget_filters() {
    filter.reset();
    body_filter.reset();
    clean.made = false;
  }

  /// The partner, the object and his hand are looked for in one frame: it is cleaned once. A frame is known
  /// by its time. Valid until the next call.
  const CleanFrame& without_robot(const hal::DepthFrame& frame, const RobotPosture& robot) {
    if (clean.made && clean.frame.exposed_at == frame.exposed_at &&
        clean.frame.depth_m.size() == frame.depth_m.size() && same(clean.posture, robot))
      return clean;
    clean.frame = frame;
    correct(clean.frame);
    clean.robot = hide_robot(clean.frame, robot);
    clean.posture = robot;
    clean.made = true;
    return clean;
  }

  hal::Result<> take_look(hal::DepthFrame frame, const std::optional<hal::Vec3>& at_W) {
    SceneAnalysisInput input;
    input.frame = std::move(frame);
    input.frame.depth_m = reference->cloud.depth_m;
    input.X_WC = X_WC;
    input.base_frame_known = true;
    input.at_W = at_W;
    auto seen =
        control::analyse_scene(std::move(input), method, config, rig.hand, stopwatch, rig.hand_tables);
    if (!seen) return tl::unexpected(seen.error());
    analysis = std::move(*seen);
    return {};
  }

  /// From the collected frames, with the camera corrected.
  hal::Result<> see_reference() {
    if (auto built = build_reference(reference_frames); !built) return built;
    if (whole_frames.empty()) return {};
    const auto corrected = correct_camera();
    if (!corrected) {  // nothing seen through this camera counts
      reference_frames.clear();
      postures.clear();
      return tl::unexpected(corrected.error());
    }
    return *corrected ? build_reference(reference_frames) : hal::Result<>{};
  }

  /// The scene of the reference; the camera has to be where its calibration says.
  hal::Result<> take_scene(const std::optional<hal::Vec3>& at_W) {
    if (auto seen = take_look(reference_frames.back(), at_W); !seen) return seen;
    if (!with_robot) return {};
    std::optional<hal::Plane> ground;
    if (analysis.scene.ground) ground = analysis.scene.ground->plane;
    const auto check = perception::check_pose(*with_robot, X_WC, ground, rig.model, robot_then.q_rad,
                                              robot_then.hand, config.pose_check);
    with_robot.reset();
    if (!check.good) return hal::failure(hal::ErrorCode::BadConfig, kCameraOff, check.reason);
    return {};
  }

  [[nodiscard]] bool sees_object() const { return analysis.scene.target && analysis.scene.ground; }

  [[nodiscard]] std::vector<std::uint32_t> slivers() const {
    return perception::find_slivers(analysis.cloud, *analysis.scene.target, *analysis.scene.ground,
                                    config.noise, config.target.slivers);
  }

  /// Of the target and of the slivers that go where it goes, ascending.
  [[nodiscard]] std::vector<std::uint32_t> target_pixels(const std::vector<std::uint32_t>& slivers) const {
    std::vector<std::uint32_t> pixels = pipeline->target_pixels(analysis, config);
    const auto own = static_cast<std::ptrdiff_t>(pixels.size());
    pixels.insert(pixels.end(), slivers.begin(), slivers.end());
    std::inplace_merge(pixels.begin(), pixels.begin() + own, pixels.end());
    return pixels;
  }

  hal::Result<> watch_for_object() {
    auto sight = pipeline->observe_partner({*reference, analysis, robot_hid}, config);
    if (!sight) return tl::unexpected(sight.error());
    partner_sight = std::move(*sight);
    perception::Target target = *analysis.scene.target;
    target.pixels = pipeline->target_pixels(analysis, config);
    auto followed = perception::ObjectFollower::make(*reference, target, config.noise, config.object_motion);
    if (!followed) return tl::unexpected(followed.error());
    follower.emplace(std::move(*followed));
    return {};
  }
};

CameraView::CameraView(Method method, const Config& config, const RigView& rig, const hal::Pose& X_WC,
                       const hal::Clock& stopwatch)
    : impl_(std::make_unique<Impl>(method, config, rig, X_WC, stopwatch)) {}
CameraView::~CameraView() = default;
CameraView::CameraView(CameraView&&) noexcept = default;

void CameraView::add_reference(hal::DepthFrame frame, const RobotPosture& robot) {
  if (!shows_anything(frame)) return;
  Impl& i = *impl_;
  i.correct(frame);
  if (i.reference_frames.empty() && i.config.pose_check.on) {
    i.with_robot = frame;
    i.robot_then = robot;
  }
  if (i.config.camera_correction.on && !i.camera_known()) {
    i.whole_frames.push_back(frame);
    i.postures.push_back(robot);
  }
  i.take_reference(std::move(frame), robot);
}

int CameraView::reference_frames() const {
  return static_cast<int>(impl_->reference_frames.size());
}

void CameraView::forget_reference() {
  impl_->reference_frames.clear();
  impl_->whole_frames.clear();
  impl_->postures.clear();
}

hal::Result<> CameraView::analyse_scene() {
  if (auto built = impl_->see_reference(); !built) return built;
  return impl_->take_scene(std::nullopt);
}

hal::Result<perception::ViewAlignment> CameraView::analyse_scene_beside(const SceneAnalysis& first) {
  Impl& i = *impl_;
  const ViewsConfig& limits = i.config.views;
  if (auto built = i.see_reference(); !built) return tl::unexpected(built.error());
  const auto alignment =
      perception::align_views(first.cloud, i.reference->cloud, i.config.noise, limits.alignment);
  if (alignment.enough && (alignment.shift_m > limits.max_correction_m ||
                           alignment.rotation_rad() > hal::deg_to_rad(limits.max_rotation_deg)))
    return hal::failure(
        hal::ErrorCode::BadConfig, kCameraOff,
        fmt::format("it does not agree with the first camera: {}; at most {:.0f} mm and "
                    "{:.1f} deg; calibrate again",
                    alignment.reason, 1e3 * limits.max_correction_m, limits.max_rotation_deg));
  if (alignment.enough && alignment.shift_m >= limits.min_correction_m &&
      alignment.sigmas >= limits.min_sigmas && alignment.after_m < alignment.before_m) {
    i.X_WC = alignment.X * i.X_WC;
    i.forget_filters();
    if (auto built = i.build_reference(i.reference_frames); !built) return tl::unexpected(built.error());
  }
  std::optional<hal::Vec3> at_W;
  if (first.scene.target) at_W = first.scene.target->obb.center;
  if (auto seen = i.take_scene(at_W); !seen) return tl::unexpected(seen.error());
  return alignment;
}

perception::ViewAlignment CameraView::compare_with_scene(hal::DepthFrame frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  if (!i.reference || i.reference->cloud.size() != frame.depth_m.size()) return {};
  i.correct(frame);
  i.hide_robot(frame, robot);
  return perception::align_views(i.reference->cloud, perception::deproject(frame, i.X_WC), i.config.noise,
                                 i.config.views.alignment);
}

hal::Result<> CameraView::move_object(const hal::Pose& X, const std::optional<hal::Vec3>& at_W) {
  Impl& i = *impl_;
  if (!i.sees_object()) return hal::failure(hal::ErrorCode::NotFound, "watch", "there is no object");
  const hal::DepthFrame moved = perception::move_object(i.analysis.cloud, i.target_pixels(i.slivers()), X,
                                                        i.config.object_motion.moved);
  if (auto built = i.build_reference({&moved, 1}); !built) return built;
  return i.take_look(i.analysis.frame, at_W);
}

hal::Result<> CameraView::begin_to_watch(std::span<const Eigen::Vector3f> object) {
  Impl& i = *impl_;
  if (!i.reference) return hal::failure(hal::ErrorCode::NotFound, "watch", "no scene was seen");
  i.partner_sight.reset();
  i.follower.reset();
  if (i.sees_object())
    if (auto made = i.watch_for_object(); !made) return made;
  i.body_finder.emplace(*i.reference, object, i.robot_hid, i.config.noise, i.config.bodies);
  return {};
}

bool CameraView::knows_scene() const {
  return impl_->body_finder.has_value();
}
bool CameraView::knows_object() const {
  return impl_->follower.has_value();
}
void CameraView::forget_object() {
  impl_->analysis.scene.target.reset();
  impl_->partner_sight.reset();
  impl_->follower.reset();
}

SceneAnalysis& CameraView::analysis() {
  return impl_->analysis;
}
const SceneAnalysis& CameraView::analysis() const {
  return impl_->analysis;
}
const std::optional<perception::CameraCorrection>& CameraView::correction() const {
  return impl_->correction;
}
perception::OrganisedCloud CameraView::cloud_of(hal::DepthFrame frame) const {
  correct(frame);
  return perception::deproject(frame, impl_->X_WC);
}
void CameraView::correct(hal::DepthFrame& frame) const {
  impl_->correct(frame);
}

void CameraView::enter(perception::WorldMap& map, std::vector<hal::Vec3>& points) const {
  const Impl& i = *impl_;
  const std::vector<std::uint32_t> own_slivers = i.slivers();
  map.insert(i.analysis.cloud, i.target_pixels(own_slivers));
  points.reserve(points.size() + i.analysis.scene.target->points.size() + own_slivers.size());
  for (const auto& p : i.analysis.scene.target->points) points.emplace_back(p.cast<double>());
  for (const std::uint32_t s : own_slivers) points.push_back(i.analysis.cloud.point(s));
  const std::vector<hal::Vec3> more = i.pipeline->target_obstacle(i.analysis, i.config);
  points.insert(points.end(), more.begin(), more.end());
}

void CameraView::enter_around(perception::WorldMap& map, const hal::OrientedBox& object,
                              double margin_m) const {
  const perception::OrganisedCloud& cloud = impl_->analysis.cloud;
  std::vector<std::uint32_t> of_object;
  for (std::size_t p = 0; p < cloud.size(); ++p)
    if (cloud.seen(p) && is_inside(object, cloud.point(p), margin_m))
      of_object.push_back(static_cast<std::uint32_t>(p));
  map.insert(cloud, of_object);
}

int CameraView::frames_per_sight() const {
  return impl_->pipeline->frames_per_sight(impl_->config);
}

hal::Result<PartnerSighting> CameraView::find_partner(const hal::DepthFrame& frame, const RobotPosture& robot,
                                                      std::vector<Eigen::Vector3f>& points) {
  Impl& i = *impl_;
  if (!i.partner_sight) return hal::failure(hal::ErrorCode::NotFound, "watch", "there is no object");
  const CleanFrame& clean = i.without_robot(frame, robot);
  PartnerSighting out;
  out.seen_before = i.hand_pixels.seen_before();
  out.hidden = i.config.tracker.max_hidden_s > 0.0 &&
               i.hand_pixels.hidden(i.analysis.cloud, clean.frame, clean.robot, i.config.noise);
  auto observation = i.partner_sight->find(clean.frame, points);
  if (!observation) return tl::unexpected(observation.error());
  // a scene that moved says nothing about hands
  if (observation->kind != perception::PartnerKind::ObjectMoved && observation->grasp)
    i.hand_pixels.seen(i.analysis.cloud, clean.frame, observation->pixels, observation->grasp->position);
  out.observation = std::move(*observation);
  return out;
}

void CameraView::forget_partner() {
  impl_->hand_pixels.forget();
}

std::span<const perception::Body> CameraView::find_bodies(const hal::DepthFrame& frame,
                                                          const RobotPosture& robot,
                                                          const hal::Pose& X_WTnow_WTref) {
  Impl& i = *impl_;
  if (!i.body_finder) return {};
  i.body_frame.exposed_at = frame.exposed_at;
  i.body_frame.intrinsics = frame.intrinsics;
  i.body_frame.depth_m.assign(frame.depth_m.begin(), frame.depth_m.end());
  i.correct(i.body_frame);
  if (!i.body_filter) {
    perception::SelfFilterConfig padded = i.config.self_filter;
    padded.padding_m = std::max(padded.padding_m, i.config.bodies.robot_padding_m);
    i.body_filter.emplace(i.rig.model, i.body_frame.intrinsics, i.X_WC, i.config.noise, padded);
  }
  const auto& own = i.body_filter->remove(i.body_frame, robot.q_rad, robot.hand);
  return i.body_finder->find(i.body_frame, own, X_WTnow_WTref);
}

std::span<const perception::BodyPoint> CameraView::body_points() const {
  if (!impl_->body_finder) return {};
  return impl_->body_finder->points();
}

std::optional<perception::ObjectMotion> CameraView::watch_object(
    const hal::DepthFrame& frame, const RobotPosture& robot,
    const std::optional<perception::HeldPoint>& held) {
  Impl& i = *impl_;
  if (!i.follower || !shows_anything(frame)) return std::nullopt;
  return i.follower->update(i.without_robot(frame, robot).frame, nullptr, held);
}

hal::Pose CameraView::last_motion() const {
  return impl_->follower ? impl_->follower->last().X_WTnow_WTref : hal::Pose::Identity();
}

std::optional<perception::HandSighting> CameraView::hand_at_grasp(const hal::DepthFrame& frame,
                                                                  const RobotPosture& robot,
                                                                  const hal::Pose& X_Wnow_Wref,
                                                                  const hal::Vec3& contact_W) {
  Impl& i = *impl_;
  if (!i.follower || !shows_anything(frame) || i.analysis.cloud.size() != frame.depth_m.size())
    return std::nullopt;
  return perception::hand_at_contact(i.analysis.cloud, i.without_robot(frame, robot).frame, X_Wnow_Wref,
                                     contact_W, i.config.noise, i.config.presence);
}

void CameraView::object_stands_again() {
  if (impl_->follower) impl_->follower->start_again();
}

}  // namespace colift::control
