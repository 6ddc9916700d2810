#include "control/task/phases/partner_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>

namespace colift::control {
namespace {

constexpr double kChanged_s = 1.0;  // somebody who carries things about does not do it all at once
constexpr int kMaxLooks = 5;        // after that the partner's timeout ends the wait

std::string seconds_text(double s) {
  return fmt::format("{:.1f} s", s);
}

}  // namespace

void PartnerPhase::begin(Task from) {
  c_.attempts.failed = c_.attempts.regrasp = c_.attempts.touched = false;
  hidden_since_.reset();
  changed_since_.reset();
  asked_.clear();
  if (from != Task::Observe) c_.session.forget_partner();
}

void PartnerPhase::ask_to_show_hand() {
  const auto& edge = partner_.hidden_edge();
  if (!edge || c_.session.tracker().state() != perception::PartnerTracker::State::Away) {
    hidden_since_.reset();
    return;
  }
  if (!hidden_since_) hidden_since_ = c_.now;
  if (!asked_.empty() || hal::seconds(c_.now - *hidden_since_) < c_.config.task.hidden_hand_s) return;
  asked_ = fmt::format(
      "please step to the {}, as the camera sees it: your body hides {:.0f} % of the object's "
      "edge, and your hand if it is there; or raise the object there by a centimetre, and put it down again",
      edge->to_right ? "right" : "left", 100.0 * edge->fraction);
  if (!edge->aside_W.isZero()) aside_W_ = edge->aside_W;
  c_.request(asked_);
}

bool PartnerPhase::has_to_look_again() {
  // who is in view would be taken for a part of the scene; unset: nobody looks for bodies
  if (!partner_.scene_changed() || c_.bodies_in_view != 0) {
    changed_since_.reset();
    return false;
  }
  if (!changed_since_) changed_since_ = c_.now;
  if (hal::seconds(c_.now - *changed_since_) < kChanged_s || looked_again_ >= kMaxLooks) return false;
  ++looked_again_;
  return true;
}

std::optional<TaskEvent> PartnerPhase::await_partner() {
  const auto event = partner_.await_grasp();
  if (has_to_look_again()) {
    c_.session.forget_partner();
    return TaskEvent{Event::SceneChanged, c_.partner_note};
  }
  ask_to_show_hand();
  if (requests_.pending() && requests_.stays_where_he_was()) {
    c_.doing = requests_.sentence();
  } else if (event && event->kind == perception::PartnerEvent::Kind::Grasped) {
    if (requests_.pending()) {  // what could be borne, could be borne with him elsewhere
      requests_.fulfilled();
      grasps_.forget_bearable();
    }
    std::string reason = event->reason;
    if (const std::size_t freed = c_.renew_map(); freed > 0)
      reason += fmt::format("; {} cells of the map are free again: what stood there was carried off", freed);
    return TaskEvent{Event::PartnerGrasped, std::move(reason)};
  } else {
    c_.doing = c_.partner_note;
  }
  const double first_s = c_.config.task.partner_timeout_s;
  const double second_s = c_.config.task.attempts.second_partner_timeout_s;
  const bool was_there = c_.attempts.approaches > 0 && !requests_.pending();
  const double waited_s = c_.in_state_s();
  if (waited_s <= (was_there ? std::min(second_s, first_s) : first_s)) return std::nullopt;
  if (requests_.pending())
    return TaskEvent{Event::NobodyCame, fmt::format("not where he was asked to, within {}: {}",
                                                    seconds_text(waited_s), requests_.reason())};
  return TaskEvent{Event::NobodyCame,
                   fmt::format("timeout: no partner grasped the object within {}{}{}", seconds_text(waited_s),
                               c_.partner_note.empty() ? "" : "; last seen: ", c_.partner_note) +
                       (asked_.empty() ? "" : "; asked: " + asked_)};
}

}  // namespace colift::control
