#include "control/task/let_go_monitor.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace colift::control {

bool is_borne_again(double load_n, double before_n, double max_deviation, bool end_is_up) {
  const double gain_n = load_n - before_n, max_n = max_deviation * before_n;
  return gain_n < max_n && (end_is_up || gain_n > -max_n);
}

void LetGoMonitor::start() {
  contact_W_ = c_.record.decision->partner->position;
  X_ = hal::Pose::Identity();
  rise_m_ = 0.0;
  aside_m_ = turned_m_ = Eigen::Vector2d::Zero();
  usual_m2_ = 0.0;
  area_m2_ = NAN;
  frames_ = frames_gone_ = frames_low_ = 0;
  ends_.fill({});
  fall_m_ = 0.0;
  was_in_the_air_ = hand_leaves_ = stopped_ = false;
  hand_motion_.start();
  camera_ = c_.session.leading();
  mean_load_n_ = load_before_n_ = c_.arm.view().load_n;
  gain_n_ = 0.0;
  mean_sideways_n_.reset();
  pull_n_ = 0.0;
  cycles_pulled_ = 0;
  updated_at_ = c_.now;
}

bool LetGoMonitor::in_the_air() const {
  return c_.state == Task::TestLift || c_.state == Task::Lift || c_.state == Task::Hold ||
         c_.state == Task::Lower || c_.state == Task::Pause;
}

double LetGoMonitor::lag_m() const {
  if (!object_.motion()) return NAN;
  return c_.palm().translation().z() - object_.X_WH_grip().translation().z() - object_.partner_rise_m();
}

bool LetGoMonitor::his_end_is_up() const {
  return in_the_air() && object_.motion() && object_.partner_rise_m() > config_.carried_m &&
         lag_m() < 0.5 * c_.config.task.carry.partner_lag_m;
}

void LetGoMonitor::update() {
  update_load();
  if (!c_.readings.frame) return;
  if (in_the_air() && object_.motion()) X_ = object_.motion()->X_WTnow_WTref;
  update_hand();
  const bool low = in_the_air() && lag_m() > c_.config.task.carry.partner_lag_m;
  frames_low_ = low ? frames_low_ + 1 : 0;
  const double rise_m = object_.motion() ? object_.partner_rise_m() : NAN;
  std::shift_right(ends_.begin(), ends_.end(), 1);
  ends_.front() = {c_.now, in_the_air() ? rise_m : NAN, lag_m()};
  fall_m_ = fall_m();
}

double LetGoMonitor::fall_m() const {
  // in one frame it may be the estimate that jumps: it goes on falling, or lies where it fell
  constexpr double kStep_m = 0.001;
  const bool goes_on = ends_[0].lag_m > ends_[1].lag_m + kStep_m && ends_[1].lag_m > ends_[2].lag_m + kStep_m;
  return goes_on ? fallen_m(0) : std::min(fallen_m(0), fallen_m(1));
}

double LetGoMonitor::fallen_m(std::size_t frame) const {
  const End& then = ends_[frame];
  double most_m = 0.0;
  for (std::size_t i = frame + 1; i < ends_.size(); ++i) {
    const End& before = ends_[i];
    if (hal::seconds(then.at - before.at) > config_.fall_s || std::isnan(before.rise_m)) break;
    // a palm that rises past an end that stands still lets nothing fall
    const double sunk_m = before.rise_m - then.rise_m, more_m = then.lag_m - before.lag_m;
    most_m = std::max(most_m, std::min(sunk_m, more_m));
  }
  return most_m;
}

void LetGoMonitor::update_hand() {
  if (camera_ != c_.session.leading()) {
    // another camera sees another side of his hand: it is learned anew
    camera_ = c_.session.leading();
    usual_m2_ = 0.0;
    frames_ = frames_gone_ = 0;
    hand_motion_.start();
  }
  // only up and down: how far a flat or round object went sideways its picture may not show, and an estimate
  // that slides along a face would lose the hand
  hal::Pose X = hal::Pose::Identity();
  if (in_the_air() && object_.motion()) rise_m_ = object_.partner_rise_m();
  X.translation().z() = rise_m_;
  if (in_the_air() && object_.motion()) follow_turn();
  X.translation().head<2>() = aside_m_;
  const auto hand = c_.session.hand_at_grasp(*c_.readings.frame, c_.posture(), X, contact_W_);
  if (!hand) return;
  const perception::PresenceConfig& presence = c_.config.presence;
  area_m2_ = hand->area_m2;
  if (hand_seen().value_or(false)) c_.tracked.partner_W = X * contact_W_;
  if (c_.state != Task::Pause) {
    hand_motion_.update(*hand);
    hand_leaves_ = hand_motion_.leaves() && !his_end_is_up();
  }
  // until here the tracker says whether he holds; what the robot's hand hides of his by now is nothing new
  // after a pause he is known to hold, and what is seen of his hand is learned anew
  if (c_.state == Task::Pause) was_in_the_air_ = false;
  if (c_.state != Task::Pause && in_the_air() && !was_in_the_air_) {
    was_in_the_air_ = true;
    usual_m2_ = 0.0;
    frames_ = frames_gone_ = 0;
  }
  const bool gone =
      frames_ >= config_.hand_frames && !his_end_is_up() && area_m2_ < presence.gone_fraction * usual_m2_;
  frames_gone_ = gone ? frames_gone_ + 1 : 0;
  if (gone || c_.state == Task::Pause) return;
  // slowly after whatever the motion hides or shows of it
  usual_m2_ += std::max(config_.hand_gain, 1.0 / (frames_ + 1)) * (area_m2_ - usual_m2_);
  ++frames_;
}

// As long as feet stand, the object turns about them, and what is high on it goes sideways: the back of a
// chair by up to 16 mm for each degree. How far it turns is seen well, and bounds what its picture says of
// its motion.
Eigen::Vector2d LetGoMonitor::turned_aside() const {
  constexpr double kLeast = 0.007;  // 0.4 degrees: less is noise
  const Eigen::Vector2d lean = (X_.linear() * hal::Vec3::UnitZ()).head<2>();
  const double sine = lean.norm();
  if (!(sine > kLeast)) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d towards = lean / sine;
  const double seen_m = (place() - contact_W_).head<2>().dot(towards);
  return std::clamp(seen_m, 0.0, contact_W_.z() * (sine - kLeast)) * towards;
}

// An end in the air turns about no feet: what it had gone by then stays, so that the hand's place never
// jumps.
void LetGoMonitor::follow_turn() {
  const Eigen::Vector2d turned_m = turned_aside();
  if (!his_end_is_up()) aside_m_ += turned_m - turned_m_;
  turned_m_ = turned_m;
}

void LetGoMonitor::update_load() {
  const double load_n = c_.arm.view().load_n;
  // what a closing hand had pressed down before is no load that somebody bore
  gain_n_ = load_n - std::max(mean_load_n_, 0.0);
  const double dt_s = hal::seconds(c_.now - updated_at_);
  updated_at_ = c_.now;
  mean_load_n_ += dt_s / (config_.load_filter_s + dt_s) * (load_n - mean_load_n_);
  if (c_.state != Task::Pause && in_the_air()) load_before_n_ = mean_load_n_;
  update_pull(dt_s);
}

void LetGoMonitor::update_pull(double dt_s) {
  const auto& wrench_W = c_.arm.view().wrench_W;
  if (!wrench_W) return;
  const Eigen::Vector2d now = wrench_W->force.head<2>();
  if (!mean_sideways_n_) mean_sideways_n_ = now;
  pull_n_ = (now - *mean_sideways_n_).norm();
  cycles_pulled_ = pull_n_ > c_.config.task.carry.pull_n ? cycles_pulled_ + 1 : 0;
  *mean_sideways_n_ += dt_s / (config_.pull_filter_s + dt_s) * (now - *mean_sideways_n_);
}

bool LetGoMonitor::is_steady() const {
  return pull_n_ < config_.steady_fraction * c_.config.task.carry.pull_n;
}

std::optional<bool> LetGoMonitor::hand_seen() const {
  if (frames_ < config_.hand_frames || usual_m2_ < c_.config.presence.min_area_m2 || std::isnan(area_m2_))
    return std::nullopt;
  return area_m2_ > c_.config.presence.back_fraction * usual_m2_;
}

hal::Vec3 LetGoMonitor::place() const {
  return X_ * contact_W_;
}

std::optional<TaskEvent> LetGoMonitor::let_go() const {
  if (stopped_) return std::nullopt;
  const CarryConfig& carry = c_.config.task.carry;
  if (hand_leaves_)
    return TaskEvent{Event::PartnerLetGo,
                     fmt::format("his hand leaves the grasp: it moved {:.0f} mm against the object, {:.1f} "
                                 "standard deviations (camera)",
                                 1e3 * hand_motion_.distance_m(), hand_motion_.score())};
  const int frames = usual_m2_ < config_.small_hand_m2 ? config_.small_hand_frames : 1;
  if (frames_gone_ >= std::max(frames, c_.config.presence.frames) &&
      usual_m2_ >= c_.config.presence.min_area_m2)
    return TaskEvent{Event::PartnerLetGo,
                     fmt::format("his hand left the grasp: {:.0f} cm^2 of it are seen there, {:.0f} before",
                                 1e4 * area_m2_, 1e4 * usual_m2_)};
  if (frames_low_ >= config_.low_frames)
    return TaskEvent{Event::PartnerLetGo,
                     fmt::format("his end is {:.0f} mm lower than the hand (limit {:.0f}; camera)",
                                 1e3 * lag_m(), 1e3 * carry.partner_lag_m)};
  if (in_the_air() && fall_m_ > std::max(config_.fall_m, object_.end_noise_m()))
    return TaskEvent{Event::PartnerLetGo,
                     fmt::format("his end falls: by {:.0f} mm more than the hand at once (limit "
                                 "{:.0f}; camera)",
                                 1e3 * fall_m_, 1e3 * config_.fall_m)};
  if (in_the_air() && gain_n_ > carry.load_gain_n)
    return TaskEvent{Event::PartnerLetGo,
                     fmt::format("sudden gain of load: {:.0f} N more at once (limit {:.0f} N)", gain_n_,
                                 carry.load_gain_n)};
  if (in_the_air() && cycles_pulled_ >= config_.pull_cycles)
    return TaskEvent{
        Event::PartnerPulls,
        fmt::format("the sideways force on the hand changed by {:.0f} N at once (limit {:.0f} N)", pull_n_,
                    carry.pull_n)};
  return std::nullopt;
}

bool LetGoMonitor::holds_again(bool ground_may_bear) const {
  const CarryConfig& carry = c_.config.task.carry;
  if (!(lag_m() < carry.partner_lag_m)) return false;
  if (const auto seen = hand_seen(); seen && !his_end_is_up()) return *seen;
  if (ground_may_bear) return false;
  const double load_n = c_.arm.view().load_n;
  return std::min(load_n, load_before_n_) > config_.min_load_n &&
         is_borne_again(load_n, load_before_n_, carry.regrasp_load_factor, his_end_is_up());
}

bool LetGoMonitor::hand_stays() const {
  return hand_seen().value_or(false) && hand_motion_.score() < c_.config.presence.motion_usual_sigmas;
}

void LetGoMonitor::ask_again() {
  frames_gone_ = frames_low_ = 0;
  ends_.fill({});
  fall_m_ = 0.0;
  hand_leaves_ = false;
  hand_motion_.start();
  mean_load_n_ = c_.arm.view().load_n;
  gain_n_ = 0.0;
  cycles_pulled_ = 0;
}

}  // namespace colift::control
