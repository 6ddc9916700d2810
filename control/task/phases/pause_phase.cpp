#include "control/task/phases/pause_phase.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "control/task/grip_quality.hpp"

namespace colift::control {

void PausePhase::begin(Task from, Event event, std::string why) {
  from_ = from;
  obstructed_ = event == Event::Obstructed;
  pulled_ = event == Event::PartnerPulls;
  why_ = std::move(why);
  not_since_ = hangs_at_ = c_.now;
  load_at_start_n_ = c_.arm.view().load_n;
  began_nearly_down_ = is_nearly_down();
  c_.arm.pause();
  partner_.ask_again();
  if (!obstructed_) ++pauses_;
  if (from == Task::TestLift) {
    // what was measured until now says nothing: it is set down, and measured anew
    c_.attempts.failed = c_.attempts.regrasp = true;
    c_.attempts.failure =
        pulled_ ? "the partner pulled during the test lift" : "the partner let go during the test lift";
  }
  c_.record.asked.push_back({c_.now - c_.began, partner_.place(), request()});
}

const char* PausePhase::request() const {
  if (obstructed_) return "asks to lift the object off what is under it, and to clear that away";
  if (pulled_) return "asks the partner to stand still";
  return "asks the partner to grasp again where he held, and to lift his end";
}

std::optional<hal::Vec3> PausePhase::asked_place() const {
  if (obstructed_ || pulled_) return std::nullopt;
  return partner_.place();
}

void PausePhase::lowering_confirmed() {
  if (obstructed_) return;  // he still carries
  partner_.stop();
  c_.attempts.lifted = c_.attempts.failed = true;
  c_.attempts.regrasp = false;
  c_.attempts.failure = pulled_ ? "the partner pulled; set down when a person confirmed it"
                                : "the partner let go; set down when a person confirmed it";
}

bool PausePhase::goes_on() const {
  if (!obstructed_) return is_nearly_down() || (holds_again() && (!pulled_ || partner_.is_steady()));
  // it was the ground, and the newest picture shows it
  if (object_.seen_askew()) return true;
  // what stood on something hangs in the hand again
  const CarryConfig& carry = c_.config.task.carry;
  const double load_n = c_.arm.view().load_n;
  return load_n > carry.standing_load_n && load_n > load_at_start_n_ + carry.standing_load_n;
}

bool PausePhase::is_nearly_down() const {
  return from_ == Task::Lower && !obstructed_ && !pulled_ && object_.motion() && object_.seen_down();
}

bool PausePhase::holds_again() const {
  return partner_.holds_again(is_nearly_down());
}

bool PausePhase::stands() const {
  return !obstructed_ && object_.seen_down() && c_.arm.view().load_n < c_.config.task.let_go.min_load_n;
}

TaskEvent PausePhase::put_down() {
  partner_.stop();
  if (from_ != Task::TestLift) {
    // a limit that had ended the lift before is the cause
    if (!std::exchange(c_.attempts.failed, true))
      c_.attempts.failure = fmt::format("the object stands; not known whether the partner {}: {}",
                                        from_ == Task::Lower ? "set it down" : "lifted it", why_);
    c_.attempts.regrasp = false;
  }
  return {Event::OnGround,
          fmt::format("both ends are seen where they stood, {:.1f} N in the hand", c_.arm.view().load_n)};
}

TaskEvent PausePhase::go_on() {
  const CarryConfig& carry = c_.config.task.carry;
  const std::string how_long = fmt::format("for {:.1f} s", carry.regrasp_s);
  if (from_ != Task::Lift && from_ != Task::Hold) {
    // lowering that is interrupted without end is no lowering
    if (pauses_ > 2 * carry.max_regrasps + 1)
      return {Event::TimeOut, fmt::format("interrupted {} times", pauses_)};
    // what was nearly down goes on without him. Whether he holds again is not known then: beside an object
    // that has turned a little, the picture shows a hand that has left
    if (began_nearly_down_ || (is_nearly_down() && !holds_again())) {
      partner_.stop();
      c_.attempts.regrasp = false;
      if (!std::exchange(c_.attempts.failed, true))
        c_.attempts.failure = "the partner let go before the object stood: " + why_;
    }
    return {Event::HoldOver, how_long};
  }
  if (pauses_ <= carry.max_regrasps) return {Event::PartnerBack, how_long};
  c_.attempts.failed = true;
  c_.attempts.regrasp = false;
  c_.attempts.failure = fmt::format("the lift was interrupted {}, the last time because {}",
                                    pauses_ == 1 ? "once" : fmt::format("{} times", pauses_),
                                    pulled_ ? "somebody pulled" : "the partner let go");
  return {Event::HoldOver, c_.attempts.failure};
}

std::optional<TaskEvent> PausePhase::pause() {
  object_.update();
  partner_.update();
  const CarryConfig& carry = c_.config.task.carry;
  c_.doing =
      pulled_ ? "holds: somebody pulled at the object; please stand still, or confirm lowering"
      : obstructed_
          ? "something is under the object: lift it off and clear it away, or confirm lowering"
          : "holds: please grasp the object again where you held it, and lift your end; or confirm lowering";
  c_.done = c_.in_state_s() / carry.regrasp_timeout_s;
  const hal::HandState& hand = c_.readings.hand;
  if (!hand.held) return TaskEvent{Event::HandEmpty, "the hand has lost the object"};
  if (hand.slips) return TaskEvent{Event::HandUnfit, slip_words(hand)};
  if (!goes_on()) not_since_ = c_.now;
  if (!stands()) hangs_at_ = c_.now;
  if (hal::seconds(c_.now - not_since_) >= carry.regrasp_s) return go_on();
  const bool asked_in_vain = c_.in_state_s() > carry.regrasp_timeout_s;
  // on its way up he is asked first
  const bool was_to_stand = from_ == Task::Lower || from_ == Task::TestLift;
  if (hal::seconds(c_.now - hangs_at_) >= carry.regrasp_s && (was_to_stand || asked_in_vain))
    return put_down();
  if (asked_in_vain) return TaskEvent{Event::TimeOut, fmt::format("asked for {:.0f} s", c_.in_state_s())};
  return std::nullopt;
}

}  // namespace colift::control
