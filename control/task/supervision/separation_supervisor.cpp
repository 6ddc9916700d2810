#include "control/task/supervision/separation_supervisor.hpp"

#include "control/monitor/separation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace colift::control {
namespace {

constexpr double kPeakOfMean = 1.875;      // of a minimum-jerk profile's speed: 15/8
constexpr double kSampleEvery_s = 0.0666;  // of the curves
// Beyond the monitor's own distance: pixels that fly at a thing's edges, and bounding spheres of links.
constexpr double kPassBeyond_m = 0.20;
constexpr double kForget_s = 0.5;        // a thing that no frame shows
constexpr double kComesNearer_m = 0.01;  // of a path that comes nearer than the arm is
constexpr double kWaitsInAll = 3.0;  // of a state, in longest waits: its own time limits wait with the arm

hal::Vec3 flat(const hal::Vec3& v) {
  return {v.x(), v.y(), 0.0};
}

}  // namespace

SeparationSupervisor::SeparationSupervisor(TaskContext& context)
    : c_(context), monitor_(context.config.monitor), arm_(context.rig.model) {}

void SeparationSupervisor::start() {
  updated_at_ = c_.now;
  c_.record.monitor.on = c_.config.monitor.on;
  c_.record.monitor.hold_distance_m = c_.config.monitor.hold_distance_m;
  c_.record.monitor.slow_distance_m = slow_distance_m();
  if (!c_.config.monitor.on)
    c_.note_device("monitor",
                   "speed and separation monitoring is off: nobody near the arm is noticed; T1 speed");
}

void SeparationSupervisor::update(double image_age_s) {
  const double passed_s = std::max(0.0, hal::seconds(c_.now - updated_at_));
  updated_at_ = c_.now;
  if (!c_.config.monitor.on) {
    if (c_.options.policies.carry) request(c_.carry_scale, "");
    return;
  }
  const bool moving = c_.arm_moves();
  if (moving) c_.waited_s += (1.0 - scale_) * passed_s;
  waited_s_ = moving && holds() ? waited_s_ + passed_s : 0.0;
  MonitorRecord& record = c_.record.monitor;
  if (moving && holds()) record.waited_s += passed_s;
  if (waited_s_ == 0.0) asked_aside_ = false;
  if (waited_s_ > c_.config.monitor.obstacle_wait_s && !asked_aside_ && monitor_.state().limited &&
      !may_confirm() && monitor_.state().nearest.who != Nearby::Thing) {
    asked_aside_ = true;
    c_.note_device("monitor", "asks to step aside: " + reason_);
    c_.request("please step aside: " + reason_);
  }
  if (c_.readings.frame && c_.record.analysis && c_.record.analysis->scene.target) look(*c_.readings.frame);

  const SeparationState& state = monitor_.state();
  const bool late = moving && !is_loaded(c_.state) && image_age_s > c_.config.monitor.hold_image_age_s;
  double scale = 1.0;
  std::string why;
  blind_ = c_.readings.camera_lost || late;
  if (c_.readings.camera_lost) {  // what is not seen is not known
    bodies_.clear();
    c_.bodies_in_view.reset();
  }
  if (state.to_confirm) {
    // nor does an arm continue by itself because the camera is lost: whether the way is free is not known
    scale = 0.0;
    why = why_it_stands();
  } else if (c_.readings.camera_lost) {
    // the state's own rule stops or slows the arm
  } else if (late) {
    scale = 0.0;
    why = fmt::format("the camera's pictures are {:.0f} ms old in the mean", 1e3 * image_age_s);
  } else if (state.hold || state.limited) {
    scale = state.hold ? 0.0 : std::min(1.0, state.speed_m_s / planned_speed_m_s());
    if (scale < 1.0) why = describe(state.nearest);
  }
  if (c_.carry_scale < scale) scale = c_.carry_scale;
  request(scale, std::move(why));
  note_wait();
  note_confirmable();
  add_sample();
  if (path_obstructed()) obstructed_by_ = state.nearest.who;
}

// What a frame shows replaces what was known; what it says nothing of may still be there.
void SeparationSupervisor::note_obstacles(const hal::DepthFrame& frame) {
  auto& known = c_.obstacles_W;
  if (!known.empty()) c_.session.keep_hidden(frame, known);
  const auto& shown = obstructed_by_ ? seen_W_ : things_W_;
  known.insert(known.end(), shown.begin(), shown.end());
  if (known.empty()) obstructed_by_.reset();
  c_.obstacle_clearance_m = monitor_.free_distance_m(obstructed_by_.value_or(Nearby::Thing)) + kPassBeyond_m;
}

void SeparationSupervisor::request(double scale, std::string why) {
  const bool held = holds();
  if (scale == scale_) {
    if (!why.empty()) reason_ = std::move(why);
    return;
  }
  const bool end = scale == 0.0 || scale == 1.0;
  if (!end && std::abs(scale - scale_) < c_.config.monitor.min_scale_change) return;
  if (held && c_.arm_moves() && !c_.may_begin(Motion::Continue)) return;
  scale_ = scale;
  reason_ = std::move(why);
  c_.arm.set_scale(scale_);
  c_.arm_waits = holds();
  if (c_.arm_moves()) c_.record.monitor.min_scale = std::min(c_.record.monitor.min_scale, scale_);
}

// somebody may have been there before the arm was to move
void SeparationSupervisor::note_wait() {
  const bool waits = c_.arm_moves() && holds();
  if (waits == waits_) return;
  waits_ = waits;
  if (waits && (!monitor_.state().hold || monitor_.state().stopped)) ++c_.record.monitor.stops;
  if (waits || c_.arm_moves())
    c_.note_device("monitor", waits ? "the arm waits: " + reason_ : "the arm continues");
}

bool SeparationSupervisor::may_confirm() const {
  return monitor_.state().may_confirm && !blind_ && c_.arm_moves() && holds();
}

void SeparationSupervisor::confirm() {
  if (!may_confirm() || !monitor_.confirm()) return;
  reason_ = "its continuation is confirmed";
  c_.note_device("monitor", "an operator confirmed that the arm may continue");
}

std::string SeparationSupervisor::why_it_stands() const {
  const SeparationState& state = monitor_.state();
  if (!state.may_confirm) return describe(state.nearest);
  const std::string stopped = fmt::format("the arm stopped for {}", describe(state.held_for));
  if (blind_) return stopped + "; without pictures nobody knows whether the path is free again";
  return "nobody is near any more; " + stopped;
}

// once for each time that the way becomes free: who waited for a person waits for the operator from then on,
// as long again
void SeparationSupervisor::note_confirmable() {
  const bool asks = may_confirm();
  if (asks == asked_to_confirm_) return;
  asked_to_confirm_ = asks;
  waited_s_ = 0.0;
  asked_aside_ = false;
  if (!asks) return;
  c_.note_device("monitor", "waits for confirmation: " + reason_);
  c_.request("please confirm that the arm may continue: " + reason_);
}

double SeparationSupervisor::slow_distance_m() const {
  const MonitorConfig& config = c_.config.monitor;
  return separation_distance(planned_speed_m_s(), config.person_speed_m_s, config.latency_s, config);
}

void SeparationSupervisor::add_sample() {
  MonitorRecord& record = c_.record.monitor;
  if (hal::seconds(c_.now - sampled_at_) < kSampleEvery_s || !c_.record.analysis) return;
  sampled_at_ = c_.now;
  SeparationSample s{hal::seconds(c_.now - c_.began), NAN, NAN, scale_};
  for (const Neighbour& n : near_) {
    double& nearest =
        n.who == Nearby::Partner || n.who == Nearby::PartnerHand ? s.partner_distance_m : s.distance_m;
    if (!(nearest <= n.distance_m)) nearest = n.distance_m;
  }
  record.curve.push_back(s);
}

// Of the fastest point of the arm, as planned: what the scale refers to.
double SeparationSupervisor::planned_speed_m_s() const {
  const double transit = c_.config.motion.transit_speed_m_s;
  if (!is_loaded(c_.state)) return transit;
  const TaskConfig& task = c_.config.task;
  return std::min(transit,
                  std::max(kPeakOfMean * task.lift_height_m / task.lift_s, task.lift.follow_speed_m_s));
}

std::optional<hal::Vec3> SeparationSupervisor::partner_contact() const {
  if (const auto grasp = c_.session.tracker().grasp()) return grasp->position;
  if (c_.record.decision && c_.record.decision->partner && (is_loaded(c_.state) || c_.arm_moves()))
    return c_.record.decision->partner->position;
  return std::nullopt;
}

void SeparationSupervisor::place_arm(const RobotPosture& posture) {
  links_.clear();
  path_.clear();
  arm_.add_links(posture.q_rad, posture.hand, links_);
  const planner::Trajectory* trajectory = c_.arm.trajectory();
  if (!trajectory || !c_.arm_moves() || is_loaded(c_.state)) return;
  const double at_s = c_.arm.progress() * trajectory->duration_s();
  const double end_s = c_.arm.goes_back() ? 0.0 : trajectory->duration_s();
  if (std::abs(end_s - at_s) > 0.0) arm_.add_path(*trajectory, at_s, end_s, posture.hand, path_);
}

void SeparationSupervisor::look(const hal::DepthFrame& frame) {
  const hal::Timestamp began = c_.stopwatch.now();
  const RobotPosture posture = c_.past.at(frame.exposed_at, c_.posture());
  place_arm(posture);
  const BodySighting seen = c_.session.observe_bodies(frame, posture);
  near_.clear();
  bodies_.clear();
  seen_W_.clear();
  things_W_.clear();
  sort_points(seen);
  note_obstacles(frame);
  c_.bodies_in_view = bodies_.size();
  const double latency_s = hal::seconds(c_.readings.frame_latency);
  monitor_.update(c_.now, c_.arm_moves() && !holds(), near_, latency_s,
                  0.5 * c_.config.monitor.arm_mass_kg + c_.config.monitor.carried_mass_kg);
  MonitorRecord& record = c_.record.monitor;
  ++record.frames;
  record.max_bodies = std::max(record.max_bodies, static_cast<int>(bodies_.size()));
  if (c_.arm_moves())
    for (const Neighbour& n : near_)
      if (n.who != Nearby::PartnerHand && (!record.min_distance_m || n.distance_m < *record.min_distance_m))
        record.min_distance_m = n.distance_m;
  compute_ms_ = 1e3 * hal::seconds(c_.stopwatch.now() - began);
  record.compute_ms += compute_ms_;
}

void SeparationSupervisor::sort_points(const BodySighting& seen) {
  const MonitorConfig& config = c_.config.monitor;
  const auto contact = partner_contact();
  const hal::Vec3 middle = c_.session.analysis().scene.target->obb.center;
  const hal::Vec3 out =
      contact ? hal::Vec3(flat(*contact - middle).normalized()) : hal::Vec3(hal::Vec3::UnitX());
  // who holds the object; then what is beside him and near enough to be his
  hal::Aabb partner_box;
  for (const perception::Body& body : seen.bodies) {
    if (!contact || body.box.exteriorDistance(*contact) > c_.config.monitor.hand_radius_m) continue;
    for (const auto& p : seen.points.subspan(body.first, body.count))
      if ((p.p_W.cast<double>() - *contact).norm() < c_.config.monitor.hand_radius_m) {
        partner_box.extend(body.box);
        break;
      }
  }
  // the object may hide his hand and forearm: then it is who stands behind his grasp, an arm's length away
  double nearest_m = c_.config.monitor.hidden_hand_m;
  const bool hidden = contact && partner_box.isEmpty();
  for (const perception::Body& body : seen.bodies) {
    if (!hidden || body.box.exteriorDistance(*contact) > nearest_m) continue;
    for (const auto& p : seen.points.subspan(body.first, body.count)) {
      const hal::Vec3 off = p.p_W.cast<double>() - *contact;
      if (off.dot(out) < -c_.config.monitor.inward_m || off.norm() > nearest_m) continue;
      nearest_m = off.norm();
      partner_box = body.box;
    }
  }
  for (std::size_t i = 0; i < seen.bodies.size(); ++i) {
    const perception::Body& body = seen.bodies[i];
    const perception::BodyTrack* track = i < seen.tracks.size() ? &seen.tracks[i] : nullptr;
    const bool partner =
        !partner_box.isEmpty() && body.box.exteriorDistance(partner_box) < c_.config.monitor.gap_m;
    // of what is cut off by the image's border nobody knows how high it is; who was seen upright and
    // crouches now is no thing, however still he is
    const bool low = body.whole && track && track->top_m < config.low_m;
    const bool thing = !partner && low && track->still_s >= config.still_s;
    hand_.clear();
    partner_.clear();
    others_.clear();
    for (const auto& p : seen.points.subspan(body.first, body.count)) {
      const hal::Vec3 off = contact ? hal::Vec3(p.p_W.cast<double>() - *contact) : hal::Vec3::Zero();
      if (!partner || flat(off).norm() > config.partner_radius_m)
        others_.push_back(p);
      else if (off.norm() < config.forearm_m && off.dot(out) > -c_.config.monitor.inward_m)
        hand_.push_back(p);
      else
        partner_.push_back(p);
    }
    const std::size_t before = near_.size();
    add_neighbour(Nearby::PartnerHand, hand_, track);
    add_neighbour(Nearby::Partner, partner_, track);
    for (const auto& p : others_) seen_W_.push_back(p.p_W);
    if (thing)
      for (const auto& p : others_) things_W_.push_back(p.p_W);
    add_neighbour(thing ? Nearby::Thing : Nearby::Person, others_, track);
    SeparationStatus::Body view;
    view.id = track ? track->id : 0;
    view.partner = partner;
    view.box = body.box;
    view.center_W = body.center;
    if (track) view.velocity_m_s = track->velocity_m_s;
    for (std::size_t n = before; n < near_.size(); ++n)
      if (!view.distance_m || near_[n].distance_m < *view.distance_m) view.distance_m = near_[n].distance_m;
    bodies_.push_back(view);
  }
}

void SeparationSupervisor::add_neighbour(Nearby who, std::span<const perception::BodyPoint> points,
                                         const perception::BodyTrack* track) {
  perception::Approach to_links, to_path;
  const double within_m = c_.config.monitor.observed_m;
  const bool links = nearest_approach(points, links_, within_m, to_links);
  const bool path = nearest_approach(points, path_, links ? to_links.distance_m : within_m, to_path);
  if (!links && !path) return;
  const bool behind = links && (!path || to_path.distance_m > to_links.distance_m - kComesNearer_m);
  Neighbour n;
  n.who = who;
  n.to_path = path;
  n.distance_m = path ? to_path.distance_m : to_links.distance_m;
  if (who == Nearby::Thing && track) n.distance_m = settled_distance(track->id, n.distance_m);
  n.point_W = path ? to_path.point_W : to_links.point_W;
  n.id = track ? track->id : 0;
  n.behind = behind;
  // until it has been followed for some frames anything may be fast
  n.speed_m_s = track && track->frames > 3 ? track->velocity_m_s.norm() + 2.0 * track->sigma_m_s
                                           : c_.config.monitor.person_speed_m_s;
  near_.push_back(n);
}

double SeparationSupervisor::settled_distance(int id, double distance_m) {
  std::erase_if(things_,
                [&](const ThingDistances& t) { return hal::seconds(c_.now - t.seen_at) > kForget_s; });
  auto thing = std::find_if(things_.begin(), things_.end(), [&](const auto& t) { return t.id == id; });
  if (thing == things_.end()) thing = things_.insert(thing, ThingDistances{id, {}, 0, c_.now});
  thing->last_m[thing->frames++ % thing->last_m.size()] = distance_m;
  thing->seen_at = c_.now;
  auto sorted = thing->last_m;
  const auto count = static_cast<std::ptrdiff_t>(std::min(thing->frames, sorted.size()));
  std::sort(sorted.begin(), sorted.begin() + count);
  return sorted[static_cast<std::size_t>((count - 1) / 2)];
}

std::optional<TaskEvent> SeparationSupervisor::waited_too_long() const {
  const double max_s = c_.config.monitor.max_wait_s;
  if (waited_s_ > max_s) return TaskEvent{may_confirm() ? Event::NotConfirmed : Event::StaysNear, reason_};
  if (!c_.arm_moves() || c_.waited_s <= kWaitsInAll * max_s) return std::nullopt;
  return TaskEvent{
      Event::StaysNear,
      fmt::format("{:.0f} s of waiting and of slowing down in all, for whoever came near again and again{}{}",
                  c_.waited_s, reason_.empty() ? "" : "; now ", reason_)};
}

std::optional<TaskEvent> SeparationSupervisor::path_obstructed() const {
  const SeparationState& state = monitor_.state();
  if (!holds() || !state.limited || may_confirm()) return std::nullopt;
  const MonitorConfig& config = c_.config.monitor;
  const double wait_s = state.nearest.who == Nearby::Thing ? config.obstacle_wait_s : config.person_wait_s;
  if (waited_s_ < wait_s) return std::nullopt;
  return TaskEvent{Event::PathObstructed, fmt::format("{}, for {:.0f} s", reason_, waited_s_)};
}

bool SeparationSupervisor::nobody_within(double distance_m) const {
  const auto is_far = [&](const SeparationStatus::Body& b) {
    return !b.distance_m || *b.distance_m > distance_m;
  };
  return c_.config.monitor.on && !blind_ && std::all_of(bodies_.begin(), bodies_.end(), is_far);
}

void SeparationSupervisor::report(SeparationStatus& out) const {
  out.on = c_.config.monitor.on;
  out.scale = scale_;
  out.waits = holds() && c_.arm_moves();
  out.may_confirm = may_confirm();
  out.reason = reason_;
  if (asked_aside_ && out.waits) out.reason += "; please step aside";
  out.hold_distance_m = c_.config.monitor.hold_distance_m;
  out.slow_distance_m = slow_distance_m();
  out.bodies = bodies_;
  out.compute_ms = compute_ms_;
  out.distance_m.reset();
  for (const SeparationStatus::Body& body : bodies_)
    if (body.distance_m && (!out.distance_m || *body.distance_m < *out.distance_m))
      out.distance_m = body.distance_m;
}

}  // namespace colift::control
