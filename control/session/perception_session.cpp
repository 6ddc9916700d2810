#include "control/session/perception_session.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "control/session/pipeline.hpp"
#include "perception/motion/moved_object.hpp"
#include "perception/partner/contact_cover.hpp"
#include "perception/partner/grasp_presence.hpp"
#include "perception/reference_image.hpp"
#include "perception/target/slivers.hpp"

namespace colift::control {
namespace {

using perception::PartnerKind;

bool shows_anything(const hal::DepthFrame& frame) {
  if (frame.depth_m.size() !=
      static_cast<std::size_t>(frame.intrinsics.width) * static_cast<std::size_t>(frame.intrinsics.height))
    return false;
  return std::any_of(frame.depth_m.begin(), frame.depth_m.end(), [](float d) { return d > 0.0f; });
}

}  // namespace

struct PerceptionSession::Impl {
  Impl(Method m, const Config& c, const RigView& r, const hal::Clock& s)
      : method(m),
        config(c),
        rig(r),
        stopwatch(s),
        map(c.map),
        tracker(c.tracker),
        hand_pixels(c.tracker.hidden),
        body_tracker(c.body_tracks) {
    // a method that is not there is said by the first look
    if (auto made = make_pipeline(m)) pipeline = std::move(*made);
  }

  Method method;
  std::unique_ptr<const Pipeline> pipeline;
  const Config& config;
  RigView rig;
  const hal::Clock& stopwatch;

  std::vector<hal::DepthFrame> reference_frames;
  std::optional<hal::DepthFrame> with_robot;  ///< The first of them, before the robot was taken out.
  RobotPosture robot_then;
  std::vector<hal::DepthFrame> whole_frames;  ///< All of them, as long as the camera is not yet judged.
  std::vector<RobotPosture> postures;         ///< Of the robot in each of these.
  std::optional<perception::CameraCorrection> correction;
  std::optional<perception::SelfFilter> filter;
  SceneAnalysis analysis;
  perception::WorldMap map;
  std::unique_ptr<PartnerSight> partner_sight;
  std::optional<perception::ObjectFollower> follower;
  perception::PartnerTracker tracker;
  perception::HandPixels hand_pixels;
  std::optional<perception::SelfFilter> body_filter;  ///< With a wider margin than the other's.
  std::optional<perception::BodyFinder> body_finder;
  perception::BodyTracker body_tracker;
  hal::DepthFrame body_frame;
  std::vector<Eigen::Vector3f> partner_points;
  int frames = 0;                             ///< That the partner might have been looked for in.
  std::vector<char> robot_hid;                ///< By pixel, in any frame of the reference.
  perception::PartnerObservation last_sight;  ///< Holds for the frames in which nobody is looked for.

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

  hal::Result<perception::ReferenceImage> build_reference() const {
    return perception::build_reference(reference_frames, rig.X_WC, config.noise, config.partner.reference);
  }

  /// Estimates the camera's correction from the frames with the robot; true: everything is to be seen anew
  /// with it.
  hal::Result<bool> correct_camera() {
    std::vector<hal::DepthFrame> frames;
    frames.swap(whole_frames);
    const auto whole = perception::build_reference(frames, rig.X_WC, config.noise, config.partner.reference);
    if (!whole) return tl::unexpected(whole.error());
    hal::DepthFrame mean;
    mean.intrinsics = frames.front().intrinsics;
    mean.depth_m = whole->cloud.depth_m;
    const hal::Vec3 middle = config.calibration.workspace_center_m,
                    half = 0.5 * config.calibration.workspace_size_m;
    correction = perception::estimate_correction(mean, whole->frames, rig.X_WC, rig.model,
                                                 postures.front().q_rad, postures.front().hand, config.noise,
                                                 {middle - half, middle + half}, config.camera_correction);
    if (correction->verdict == perception::CameraCorrection::Verdict::Refused && config.pose_check.on)
      return hal::failure(hal::ErrorCode::BadConfig, kCameraOff,
                          fmt::format("the camera is not where its calibration says: {}; calibrate again",
                                      correction->reason));
    if (!correction->applied()) return false;
    rig.X_WC = rig.X_WC * correction->X_KC;
    filter.reset();
    body_filter.reset();
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
    if (!filter) filter.emplace(rig.model, frame.intrinsics, rig.X_WC, config.noise, config.self_filter);
    return filter->remove(frame, robot.q_rad, robot.hand);
  }

  hal::Result<> take_look(const perception::ReferenceImage& reference, hal::DepthFrame frame) {
    SceneAnalysisInput input;
    input.frame = std::move(frame);
    input.frame.depth_m = reference.cloud.depth_m;
    input.X_WC = rig.X_WC;
    input.base_frame_known = true;
    auto seen =
        control::analyse_scene(std::move(input), method, config, rig.hand, stopwatch, rig.hand_tables);
    if (!seen) return tl::unexpected(seen.error());
    analysis = std::move(*seen);
    return {};
  }

  hal::Result<> make_rest(const perception::ReferenceImage& reference, const RobotPosture& robot) {
    if (!analysis.scene.target || !analysis.scene.ground) return {};
    if (auto made = make_finders(reference); !made) return made;
    make_map(robot);
    return {};
  }

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

  hal::Result<> make_finders(const perception::ReferenceImage& reference) {
    auto sight = pipeline->observe_partner({reference, analysis, robot_hid}, config);
    if (!sight) return tl::unexpected(sight.error());
    partner_sight = std::move(*sight);
    perception::Target target = *analysis.scene.target;
    target.pixels = pipeline->target_pixels(analysis, config);
    auto followed = perception::ObjectFollower::make(reference, target, config.noise, config.object_motion);
    if (!followed) return tl::unexpected(followed.error());
    follower.emplace(std::move(*followed));
    body_finder.emplace(reference, target.points, robot_hid, config.noise, config.bodies);
    return {};
  }

  void make_map(const RobotPosture& robot) {
    const std::vector<std::uint32_t> own_slivers = slivers();
    map = perception::WorldMap(config.map);
    map.insert(analysis.cloud, target_pixels(own_slivers));
    map.carve_robot(rig.model, robot.q_rad, robot.hand);
    std::vector<hal::Vec3> points;
    points.reserve(analysis.scene.target->points.size() + own_slivers.size());
    for (const auto& p : analysis.scene.target->points) points.emplace_back(p.cast<double>());
    for (const std::uint32_t i : own_slivers) points.push_back(analysis.cloud.point(i));
    const std::vector<hal::Vec3> more = pipeline->target_obstacle(analysis, config);
    points.insert(points.end(), more.begin(), more.end());
    map.set_target(points);
  }
};

PerceptionSession::PerceptionSession(Method method, const Config& config, const RigView& rig,
                                     const hal::Clock& stopwatch)
    : impl_(std::make_unique<Impl>(method, config, rig, stopwatch)) {}
PerceptionSession::~PerceptionSession() = default;

void PerceptionSession::add_reference(hal::DepthFrame frame, const RobotPosture& robot) {
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

int PerceptionSession::reference_frames() const {
  return static_cast<int>(impl_->reference_frames.size());
}

void PerceptionSession::forget_reference() {
  impl_->reference_frames.clear();
  impl_->whole_frames.clear();
  impl_->postures.clear();
}

hal::Result<> PerceptionSession::analyse_scene(const RobotPosture& robot) {
  Impl& i = *impl_;
  auto reference = i.build_reference();
  if (!reference) return tl::unexpected(reference.error());
  if (!i.whole_frames.empty()) {
    const auto corrected = i.correct_camera();
    if (!corrected) {
      forget_reference();  // nothing seen through this camera counts
      return tl::unexpected(corrected.error());
    }
    if (*corrected) reference = i.build_reference();
    if (!reference) return tl::unexpected(reference.error());
  }

  if (auto seen = i.take_look(*reference, i.reference_frames.back()); !seen) return seen;
  i.reference_frames.clear();
  if (i.with_robot) {
    std::optional<hal::Plane> ground;
    if (i.analysis.scene.ground) ground = i.analysis.scene.ground->plane;
    const auto check = perception::check_pose(*i.with_robot, i.rig.X_WC, ground, i.rig.model,
                                              i.robot_then.q_rad, i.robot_then.hand, i.config.pose_check);
    i.with_robot.reset();
    if (!check.good) return hal::failure(hal::ErrorCode::BadConfig, kCameraOff, check.reason);
  }
  return i.make_rest(*reference, robot);
}

hal::Result<> PerceptionSession::object_moved(const hal::Pose& X, const RobotPosture& robot) {
  Impl& i = *impl_;
  if (!i.analysis.scene.target || !i.analysis.scene.ground)
    return hal::failure(hal::ErrorCode::NotFound, "watch", "there is no object");
  const hal::DepthFrame moved = perception::move_object(i.analysis.cloud, i.target_pixels(i.slivers()), X,
                                                        i.config.object_motion.moved);
  const auto reference =
      perception::build_reference({&moved, 1}, i.rig.X_WC, i.config.noise, i.config.partner.reference);
  if (!reference) return tl::unexpected(reference.error());
  if (auto seen = i.take_look(*reference, i.analysis.frame); !seen) return seen;
  forget_partner();
  return i.make_rest(*reference, robot);
}

const std::optional<perception::CameraCorrection>& PerceptionSession::camera_correction() const {
  return impl_->correction;
}
hal::DepthFrame PerceptionSession::corrected(hal::DepthFrame frame) const {
  impl_->correct(frame);
  return frame;
}

const SceneAnalysis& PerceptionSession::analysis() const {
  return impl_->analysis;
}
SceneAnalysis& PerceptionSession::analysis() {
  return impl_->analysis;
}
const perception::WorldMap& PerceptionSession::map() const {
  return impl_->map;
}

hal::Result<Sight> PerceptionSession::observe_partner(hal::DepthFrame frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  Sight out;
  const hal::Timestamp start = i.stopwatch.now();
  if (!i.partner_sight) return hal::failure(hal::ErrorCode::NotFound, "watch", "there is no object");
  const int every = i.pipeline->frames_per_sight(i.config);
  if (i.frames++ % every != 0) {
    out.partner = i.last_sight;
    out.is_new = false;
    return out;
  }
  i.correct(frame);
  const auto& own = i.hide_robot(frame, robot);
  const hal::Timestamp at = frame.exposed_at;
  const bool hidden = i.config.tracker.max_hidden_s > 0.0 &&
                      i.hand_pixels.hidden(i.analysis.cloud, frame, own, i.config.noise);
  auto observation = i.partner_sight->find(frame, i.partner_points);
  if (!observation) return tl::unexpected(observation.error());
  if (every > 1) i.last_sight = *observation;
  // a scene that moved says nothing about hands
  if (observation->kind != PartnerKind::ObjectMoved) {
    if (hidden && observation->kind != PartnerKind::Grasp) {
      out.event = i.tracker.update_hidden(at);
      observation->reason += "; his body hides from the camera where he held the object";
    } else {
      out.event = i.tracker.update(at, *observation);
    }
    if (observation->grasp)
      i.hand_pixels.seen(i.analysis.cloud, frame, observation->pixels, observation->grasp->position);
  }
  out.partner = std::move(*observation);
  out.compute_ms = 1e3 * hal::seconds(i.stopwatch.now() - start);
  return out;
}

std::optional<perception::PartnerEvent> PerceptionSession::no_frame(hal::Timestamp now) {
  return impl_->tracker.tick(now);
}
void PerceptionSession::looked_away(hal::Duration how_long) {
  impl_->tracker.looked_away(how_long);
}
const perception::PartnerTracker& PerceptionSession::tracker() const {
  return impl_->tracker;
}
void PerceptionSession::forget_partner() {
  impl_->tracker = perception::PartnerTracker(impl_->config.tracker);
  impl_->hand_pixels.forget();
}
const std::vector<Eigen::Vector3f>& PerceptionSession::partner_points() const {
  return impl_->partner_points;
}

BodySighting PerceptionSession::observe_bodies(const hal::DepthFrame& frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  if (!i.body_finder || !i.follower) return {};
  i.body_frame.exposed_at = frame.exposed_at;
  i.body_frame.intrinsics = frame.intrinsics;
  i.body_frame.depth_m.assign(frame.depth_m.begin(), frame.depth_m.end());
  i.correct(i.body_frame);
  if (!i.body_filter) {
    perception::SelfFilterConfig padded = i.config.self_filter;
    padded.padding_m = std::max(padded.padding_m, i.config.bodies.robot_padding_m);
    i.body_filter.emplace(i.rig.model, i.body_frame.intrinsics, i.rig.X_WC, i.config.noise, padded);
  }
  const auto& own = i.body_filter->remove(i.body_frame, robot.q_rad, robot.hand);
  const auto& bodies = i.body_finder->find(i.body_frame, own, i.follower->last().X_WTnow_WTref);
  return {bodies, i.body_tracker.update(frame.exposed_at, bodies), i.body_finder->points()};
}

std::optional<perception::ObjectMotion> PerceptionSession::watch_object(hal::DepthFrame frame,
                                                                        const RobotPosture& robot) {
  Impl& i = *impl_;
  if (!i.follower || !shows_anything(frame)) return std::nullopt;
  i.correct(frame);
  i.hide_robot(frame, robot);
  return i.follower->update(frame);
}
std::optional<perception::HandSighting> PerceptionSession::hand_at_grasp(hal::DepthFrame frame,
                                                                         const RobotPosture& robot,
                                                                         const hal::Pose& X_Wnow_Wref,
                                                                         const hal::Vec3& contact_W) {
  Impl& i = *impl_;
  if (!i.follower || !shows_anything(frame) || i.analysis.cloud.size() != frame.depth_m.size())
    return std::nullopt;
  i.correct(frame);
  i.hide_robot(frame, robot);
  return perception::hand_at_contact(i.analysis.cloud, frame, X_Wnow_Wref, contact_W, i.config.noise,
                                     i.config.presence);
}
void PerceptionSession::object_stands_again() {
  if (impl_->follower) impl_->follower->start_again();
}

}  // namespace colift::control
