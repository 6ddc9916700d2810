#include "control/task/phases/partner_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace colift::control {
namespace {

std::string seconds_text(double s) {
  return fmt::format("{:.1f} s", s);
}

}  // namespace

void PartnerPhase::begin(Task from) {
  c_.attempts.failed = c_.attempts.regrasp = false;
  hidden_since_.reset();
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
      "edge, and your hand if it is there",
      edge->to_right ? "right" : "left", 100.0 * edge->fraction);
  if (!edge->aside_W.isZero()) aside_W_ = edge->aside_W;
  c_.request(asked_);
}

std::optional<TaskEvent> PartnerPhase::await_partner() {
  const auto event = partner_.update();
  ask_to_show_hand();
  if (requests_.pending() && requests_.stays_where_he_was()) {
    c_.doing = requests_.sentence();
  } else if (event && event->kind == perception::PartnerEvent::Kind::Grasped) {
    if (requests_.pending()) {  // what could be borne, could be borne with him elsewhere
      requests_.fulfilled();
      grasps_.forget_bearable();
    }
    return TaskEvent{Event::PartnerGrasped, event->reason};
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
