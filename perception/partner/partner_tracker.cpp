#include "perception/partner/partner_tracker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace colift::perception {
namespace {

std::string place(const Vec3& p) {
  return fmt::format("({:.2f}, {:.2f}, {:.2f}) m", p.x(), p.y(), p.z());
}

// Standard deviation of the distance between two estimates, along the line between them (m).
double sigma_along(const Eigen::Matrix3d& covariance, const Vec3& difference) {
  const double length = difference.norm();
  if (length == 0.0) return 0.0;
  const Vec3 along = difference / length;
  return std::sqrt(std::max(0.0, along.dot(covariance * along)));
}

// A hand before its own body looks like a leg in one frame and like a hand in the next; of a hand behind an
// edge the part that touches may be too small in every other frame.
bool is_unclear(const PartnerObservation& seen, const Vec3& hand_W, double moved_m) {
  constexpr double kNear_m = 0.05;  // a hand that has left is farther away within the shortest let_go_s
  return (seen.legs.empty() && seen.kind == PartnerKind::Near &&
          seen.nearest_m.value_or(kNear_m) < kNear_m) ||
         std::any_of(seen.legs.begin(), seen.legs.end(),
                     [&](const Vec3& leg) { return (leg - hand_W).norm() < moved_m; });
}

}  // namespace

std::optional<PartnerGrasp> PartnerTracker::grasp() const {
  if (state_ == State::Away) return std::nullopt;
  PartnerGrasp grasp;
  grasp.position = mean_;
  grasp.covariance = mean_covariance_ * (config_.common_error + (1.0 - config_.common_error) / samples_);
  if (hidden_since_)
    grasp.covariance += config_.hidden_sigma_m * config_.hidden_sigma_m * Eigen::Matrix3d::Identity();
  grasp.points = points_;
  grasp.skin = skin_;
  return grasp;
}

void PartnerTracker::start(hal::Timestamp at, const PartnerGrasp& seen) {
  state_ = State::Touching;
  since_ = last_contact_ = at;
  hidden_since_.reset();
  unseen_ = false;
  samples_ = 1;
  elsewhere_in_a_row_ = 0;
  mean_ = seen.position;
  mean_covariance_ = seen.covariance;
  points_ = seen.points;
  skin_ = seen.skin;
}

void PartnerTracker::add(hal::Timestamp at, const PartnerGrasp& seen) {
  last_contact_ = at;
  hidden_since_.reset();
  elsewhere_in_a_row_ = 0;
  ++samples_;
  mean_ += (seen.position - mean_) / samples_;
  mean_covariance_ += (seen.covariance - mean_covariance_) / samples_;
  points_ = seen.points;
  if (skin_ && seen.skin) *skin_ += (*seen.skin - *skin_) / samples_;
}

bool PartnerTracker::elsewhere(const PartnerGrasp& seen) const {
  // a hand that hides its contact leaves two places to choose from; while its skin stays, only the choice has
  // changed
  if (skin_ && seen.skin && (*seen.skin - *skin_).norm() < config_.moved_m) return false;
  const Vec3 difference = seen.position - mean_;
  // what all frames share cannot move the hand; only the rest can look like a movement
  const Eigen::Matrix3d random =
      (1.0 - config_.common_error) * (seen.covariance + mean_covariance_ / std::max(1, samples_));
  return difference.norm() >
         std::max(config_.moved_m, config_.moved_sigmas * sigma_along(random, difference));
}

bool PartnerTracker::strays(const PartnerGrasp& seen) const {
  return skin_ && seen.skin && (*seen.skin - *skin_).norm() > config_.rest_m &&
         (seen.position - mean_).norm() > config_.rest_m;
}

// The last frames were no outliers: it rests there since the first of them that shows it where the last one
// does.
void PartnerTracker::go_elsewhere(int frames) {
  const auto& seen = elsewhere_;
  const auto last = static_cast<std::size_t>(frames - 1);
  std::size_t first = last;
  while (first > 0 && (seen[first - 1].seen.position - seen[last].seen.position).norm() <= config_.rest_m)
    --first;
  start(seen[first].at, seen[first].seen);
  for (std::size_t i = first + 1; i <= last; ++i) add(seen[i].at, seen[i].seen);
}

std::optional<PartnerEvent> PartnerTracker::lose_contact(hal::Timestamp at, const std::string& seen_instead) {
  const bool held = state_ == State::Holding;
  state_ = State::Away;
  hidden_since_.reset();
  unseen_ = false;
  if (!held) return std::nullopt;
  return PartnerEvent{PartnerEvent::Kind::LetGo, at,
                      fmt::format("no contact for {:.2f} s (limit {:.2f} s): {}", untouched_s(at),
                                  config_.let_go_s, seen_instead)};
}

std::optional<PartnerEvent> PartnerTracker::confirm(hal::Timestamp at) {
  const double rested_s = hal::seconds(at - since_);
  if (state_ != State::Touching || rested_s < config_.dwell_s) return std::nullopt;
  state_ = State::Holding;
  return PartnerEvent{PartnerEvent::Kind::Grasped, at,
                      fmt::format("the hand rests at {} for {:.2f} s (dwell {:.2f} s, {} frames)",
                                  place(mean_), rested_s, config_.dwell_s, samples_)};
}

std::optional<PartnerEvent> PartnerTracker::update_hidden(hal::Timestamp at) {
  if (last_frame_ && at <= *last_frame_) return std::nullopt;
  last_frame_ = at;
  if (state_ == State::Away) return std::nullopt;
  if (hal::seconds(at - last_contact_) > config_.let_go_s)
    return lose_contact(at, "the frames between are missing");
  if (!hidden_since_) hidden_since_ = at;
  const double hidden_s = hal::seconds(at - *hidden_since_);
  if (hidden_s > config_.max_hidden_s)
    return lose_contact(at, fmt::format("his body has hidden it from the camera for {:.0f} s", hidden_s));
  last_contact_ = at;  // nobody knows better
  if (state_ != State::Touching || hidden_s < config_.hidden_dwell_s) return std::nullopt;
  state_ = State::Holding;
  return PartnerEvent{
      PartnerEvent::Kind::Grasped, at,
      fmt::format("the hand touched the object at {} in {} frames, and his body has hidden it "
                  "for {:.1f} s since (limit {:.1f} s)",
                  place(mean_), samples_, hidden_s, config_.hidden_dwell_s)};
}

std::optional<PartnerEvent> PartnerTracker::hold_unseen(hal::Timestamp at, const PartnerGrasp& estimate,
                                                        std::string reason) {
  if (state_ == State::Holding) return std::nullopt;
  start(at, estimate);
  skin_.reset();
  state_ = State::Holding;
  hidden_since_ = at;
  unseen_ = true;
  return PartnerEvent{PartnerEvent::Kind::Grasped, at, std::move(reason)};
}

std::optional<PartnerEvent> PartnerTracker::tick(hal::Timestamp now) {
  if (state_ == State::Away || untouched_s(now) <= config_.let_go_s) return std::nullopt;
  return lose_contact(now, "no frame since shows it");
}

std::optional<PartnerEvent> PartnerTracker::update(hal::Timestamp at, const PartnerObservation& observation) {
  if (last_frame_ && at <= *last_frame_) return std::nullopt;
  last_frame_ = at;

  const bool contact = observation.kind == PartnerKind::Grasp && observation.grasp.has_value();
  if (state_ == State::Holding && is_unclear(observation, mean_, config_.moved_m) &&
      hal::seconds(at - last_contact_) <= config_.unclear_s)
    last_touch_ = at;
  if (state_ != State::Away && untouched_s(at) > config_.let_go_s) {
    // what happened in the gap is unknown, so a contact after it begins a new dwell
    auto event = lose_contact(at, contact ? "the frames between are missing" : observation.reason);
    if (contact) start(at, *observation.grasp);
    return event;
  }
  if (!contact) return std::nullopt;
  if (unseen_ && !elsewhere(*observation.grasp)) {
    start(at, *observation.grasp);
    state_ = State::Holding;
    return std::nullopt;
  }
  if (state_ == State::Away) {
    start(at, *observation.grasp);
    return confirm(at);
  }
  // a hand that is still on its way does not dwell; one frame that shows less of it is no way
  if (state_ == State::Touching && strays(*observation.grasp)) {
    last_contact_ = at;
    elsewhere_[static_cast<std::size_t>(elsewhere_in_a_row_)] = {at, *observation.grasp};
    if (++elsewhere_in_a_row_ < config_.moved_frames) return std::nullopt;
    start(at, *observation.grasp);
    return confirm(at);
  }
  if (!elsewhere(*observation.grasp)) {
    add(at, *observation.grasp);
    return confirm(at);
  }

  // some frames beside the others are outliers, but contacts all the same
  last_contact_ = at;
  const bool held = state_ == State::Holding;
  elsewhere_[static_cast<std::size_t>(elsewhere_in_a_row_)] = {at, *observation.grasp};
  const int streak = ++elsewhere_in_a_row_;
  if (streak < (held ? config_.moved_held_frames : config_.moved_frames)) return std::nullopt;
  const Vec3 before = mean_;
  go_elsewhere(streak);
  if (!held) return confirm(at);
  return PartnerEvent{
      PartnerEvent::Kind::Moved, at,
      fmt::format("the hand moved {:.0f} mm (limit {:.0f} mm), from {} to {}",
                  1000.0 * (mean_ - before).norm(), 1000.0 * config_.moved_m, place(before), place(mean_))};
}

}  // namespace colift::perception
