#include "control/session/perception_session.hpp"

#include <utility>

#include "control/session/views/camera_set.hpp"
#include "control/session/views/unseen_grasp.hpp"
#include "perception/map/line_of_sight.hpp"

namespace colift::control {

struct PerceptionSession::Impl {
  Impl(Method method, const Config& c, const RigView& rig, const hal::Clock& s)
      : config(c),
        stopwatch(s),
        set(method, c, rig, s),
        map(c.map),
        tracker(c.tracker),
        unseen_grasp(c.raise, c.tracker.hidden_dwell_s),
        body_tracker(c.body_tracks) {}

  const Config& config;
  const hal::Clock& stopwatch;
  CameraSet set;
  std::optional<PushedCamera> pushed;
  perception::WorldMap map;
  perception::PartnerTracker tracker;
  UnseenGrasp unseen_grasp;
  perception::BodyTracker body_tracker;
  JoinedBodies joined_bodies;
  std::vector<ViewOfBodies> body_views;
  std::vector<Eigen::Vector3f> partner_points;
  int frames = 0;                             ///< That the partner might have been looked for in.
  perception::PartnerObservation last_sight;  ///< Holds for the frames in which nobody is looked for.

  hal::Result<> watch_scene(const RobotPosture& robot) {
    const perception::Scene& scene = set.scene().analysis().scene;
    if (!scene.target || !scene.ground) return {};
    auto made = set.begin_to_watch(robot);
    if (!made) return tl::unexpected(made.error());
    map = std::move(*made);
    return {};
  }

  /// All views of the partner, joined.
  hal::Result<PartnerSighting> see_partner(const hal::DepthFrame& frame, const RobotPosture& robot) {
    const hal::Timestamp at = frame.exposed_at;
    auto seen = set.lead().find_partner(frame, robot, partner_points);
    if (!seen || !set.several()) return seen;
    std::vector<ViewOfPartner> views{{set.leading(), std::move(*seen)}};
    set.beside(at, [&](Camera& camera, std::size_t n) {
      if (!camera.view.knows_object()) return;
      if (std::exchange(camera.newest->for_partner, false)) {
        auto there =
            camera.view.find_partner(camera.newest->frame, camera.newest->robot, camera.partner_points);
        camera.partner.reset();
        if (there) camera.partner = ViewOfPartner{n, std::move(*there)};
      }
      if (!camera.partner) return;
      views.push_back(*camera.partner);
      partner_points.insert(partner_points.end(), camera.partner_points.begin(), camera.partner_points.end());
    });
    return join_sightings(views, config.views.same_hand_m);
  }

  /// The partner in this frame, if it is one in which he is looked for: is_new.
  hal::Result<Sight> next_sight(const hal::DepthFrame& frame, const RobotPosture& robot) {
    if (!set.lead().knows_object())
      return hal::failure(hal::ErrorCode::NotFound, "watch", "there is no object");
    Sight out;
    const int every = set.lead().frames_per_sight();
    if (frames++ % every != 0) {
      out.partner = last_sight;
      out.is_new = false;
      return out;
    }
    auto seen = see_partner(frame, robot);
    if (!seen) return tl::unexpected(seen.error());
    if (every > 1) last_sight = seen->observation;
    out.partner = std::move(seen->observation);
    out.hidden = seen->hidden;
    return out;
  }

  /// Hands what was seen to the tracker.
  void track(hal::Timestamp at, Sight& sight) {
    // a scene that moved says nothing about hands
    if (sight.event || sight.partner.kind == perception::PartnerKind::ObjectMoved) return;
    if (sight.hidden && sight.partner.kind != perception::PartnerKind::Grasp) {
      sight.event = tracker.update_hidden(at);
      sight.partner.reason += "; his body hides from the camera where he held the object";
    } else if (tracker.is_unseen() && unseen_grasp.hides(sight.partner, tracker.grasp())) {
      sight.event = tracker.update_hidden(at);
      sight.partner.reason += "; he holds it there";
    } else {
      sight.event = tracker.update(at, sight.partner);
    }
  }

  void check_pose(std::size_t camera, const hal::DepthFrame& frame, const RobotPosture& robot) {
    // one at a time: nobody has asked about the last one yet
    if (!pushed) pushed = set.check_pose(camera, frame, robot);
  }
};

PerceptionSession::PerceptionSession(Method method, const Config& config, const RigView& rig,
                                     const hal::Clock& stopwatch)
    : impl_(std::make_unique<Impl>(method, config, rig, stopwatch)) {}
PerceptionSession::~PerceptionSession() = default;

void PerceptionSession::take_frame(std::size_t camera, hal::DepthFrame frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  if (camera >= i.set.cameras().size() || camera == i.set.leading()) return;
  i.set.cameras()[camera].newest = NewestFrame{std::move(frame), robot};
}

bool PerceptionSession::lead(std::size_t camera) {
  return impl_->set.let_lead(camera);
}
std::size_t PerceptionSession::leading() const {
  return impl_->set.leading();
}
std::size_t PerceptionSession::scene_camera() const {
  return impl_->set.scene_camera();
}
const std::vector<ViewReport>& PerceptionSession::views() const {
  return impl_->set.reports();
}
std::optional<PushedCamera> PerceptionSession::take_pushed() {
  return std::exchange(impl_->pushed, std::nullopt);
}

void PerceptionSession::add_reference(hal::DepthFrame frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  i.set.lead().add_reference(std::move(frame), robot);
  for (Camera& camera : i.set.cameras()) {
    if (!camera.newest) continue;
    camera.view.add_reference(std::move(camera.newest->frame), camera.newest->robot);
    camera.newest.reset();
  }
}

int PerceptionSession::reference_frames() const {
  return impl_->set.lead().reference_frames();
}

void PerceptionSession::forget_reference() {
  for (Camera& camera : impl_->set.cameras()) camera.view.forget_reference();
}

hal::Result<> PerceptionSession::analyse_scene(const RobotPosture& robot) {
  auto seen = impl_->set.see_scene();
  forget_reference();
  impl_->unseen_grasp.forget_place();
  if (!seen) return seen;
  return impl_->watch_scene(robot);
}

hal::Result<> PerceptionSession::object_moved(const hal::Pose& X, const RobotPosture& robot) {
  if (auto moved = impl_->set.move_object(X); !moved) return moved;
  forget_partner();
  return impl_->watch_scene(robot);
}

const std::optional<perception::CameraCorrection>& PerceptionSession::camera_correction() const {
  return impl_->set.lead().correction();
}
hal::DepthFrame PerceptionSession::corrected(hal::DepthFrame frame) const {
  impl_->set.lead().correct(frame);
  return frame;
}

const SceneAnalysis& PerceptionSession::analysis() const {
  return impl_->set.scene().analysis();
}
SceneAnalysis& PerceptionSession::analysis() {
  return impl_->set.scene().analysis();
}
const perception::WorldMap& PerceptionSession::map() const {
  return impl_->map;
}

std::size_t PerceptionSession::free_carried_off(const hal::DepthFrame& frame) {
  return impl_->map.free_carried_off(impl_->set.lead().cloud_of(frame));
}

void PerceptionSession::keep_hidden(const hal::DepthFrame& frame,
                                    std::vector<Eigen::Vector3f>& points_W) const {
  const perception::OrganisedCloud cloud = impl_->set.lead().cloud_of(frame);
  const hal::Pose X_CW = cloud.X_WC.inverse();
  std::erase_if(points_W, [&](const Eigen::Vector3f& p) {
    return !perception::is_hidden(cloud, X_CW, p.cast<double>());
  });
}

double PerceptionSession::unseen() const {
  return impl_->set.unseen(impl_->map);
}

hal::Result<Sight> PerceptionSession::observe_partner(const hal::DepthFrame& frame,
                                                      const RobotPosture& robot) {
  Impl& i = *impl_;
  const hal::Timestamp start = i.stopwatch.now();
  auto out = i.next_sight(frame, robot);
  if (!out || !out->is_new) return out;
  i.track(frame.exposed_at, *out);
  out->compute_ms = 1e3 * hal::seconds(i.stopwatch.now() - start);
  return out;
}

hal::Result<Sight> PerceptionSession::await_grasp(const hal::DepthFrame& frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  const hal::Timestamp start = i.stopwatch.now();
  auto out = i.next_sight(frame, robot);
  if (!out || !out->is_new) return out;
  const bool holds = i.tracker.state() == perception::PartnerTracker::State::Holding;
  i.unseen_grasp.look(out->partner);
  const auto& ground = analysis().scene.ground;
  if (!holds && ground) {
    std::optional<perception::ObjectMotion> motion;
    if (i.unseen_grasp.needs_motion()) motion = watch_object(frame, robot);
    out->event =
        i.unseen_grasp.update(frame.exposed_at, motion, ground->plane.normal, out->partner, i.tracker);
  }
  // the edge of an object that somebody raises is nearer than it was, like a hand
  if (holds || !i.unseen_grasp.moves()) i.track(frame.exposed_at, *out);
  out->compute_ms = 1e3 * hal::seconds(i.stopwatch.now() - start);
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
  impl_->unseen_grasp.forget_motion();
  for (Camera& camera : impl_->set.cameras()) camera.view.forget_partner();
}
const std::vector<Eigen::Vector3f>& PerceptionSession::partner_points() const {
  return impl_->partner_points;
}

BodySighting PerceptionSession::observe_bodies(const hal::DepthFrame& frame, const RobotPosture& robot) {
  Impl& i = *impl_;
  if (!i.set.lead().knows_scene() || !i.set.lead().knows_object()) return {};
  const hal::Pose X = i.set.lead().last_motion();
  const auto bodies = i.set.lead().find_bodies(frame, robot, X);
  if (!i.set.several())
    return {bodies, i.body_tracker.update(frame.exposed_at, bodies), i.set.lead().body_points()};
  i.body_views.clear();
  i.body_views.push_back({bodies, i.set.lead().body_points()});
  i.check_pose(i.set.leading(), frame, robot);
  i.set.beside(frame.exposed_at, [&](Camera& camera, std::size_t n) {
    const NewestFrame& newest = *camera.newest;
    const auto found = camera.view.find_bodies(newest.frame, newest.robot, X);
    i.body_views.push_back({found, camera.view.body_points()});
    if (std::exchange(camera.newest->for_pose, false)) i.check_pose(n, newest.frame, newest.robot);
  });
  const auto joined = i.joined_bodies.join(i.body_views, i.config.views.same_body_m);
  return {joined, i.body_tracker.update(frame.exposed_at, joined), i.joined_bodies.points()};
}

std::optional<perception::ObjectMotion> PerceptionSession::watch_object(
    const hal::DepthFrame& frame, const RobotPosture& robot,
    const std::optional<perception::HeldPoint>& held) {
  Impl& i = *impl_;
  const hal::Timestamp at = frame.exposed_at;
  auto motion = i.set.lead().watch_object(frame, robot, held);
  i.set.beside(at, [&](Camera& camera, std::size_t) {
    // each follows it, to be ready to lead
    if (!camera.view.knows_object() || !std::exchange(camera.newest->for_motion, false)) return;
    const auto there = camera.view.watch_object(camera.newest->frame, camera.newest->robot, held);
    if (!motion) motion = there;
  });
  return motion;
}

std::optional<perception::HandSighting> PerceptionSession::hand_at_grasp(const hal::DepthFrame& frame,
                                                                         const RobotPosture& robot,
                                                                         const hal::Pose& X_Wnow_Wref,
                                                                         const hal::Vec3& contact_W) {
  return impl_->set.lead().hand_at_grasp(frame, robot, X_Wnow_Wref, contact_W);
}

void PerceptionSession::object_stands_again() {
  for (Camera& camera : impl_->set.cameras()) camera.view.object_stands_again();
}

}  // namespace colift::control
