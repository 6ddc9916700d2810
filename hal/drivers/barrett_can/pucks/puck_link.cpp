#include "hal/drivers/barrett_can/pucks/puck_link.hpp"

#include <algorithm>
#include <utility>
#include <variant>

namespace colift::hal::barrett {
namespace {

constexpr int kTries = 3;
constexpr Duration kBetweenSettings = std::chrono::microseconds(200);
constexpr Duration kMostServed =
    std::chrono::milliseconds(5);  // between two pumps: the rest was a stall of ours
// After the last try of a question: late answers may come, and 50 ms are promised with the 10 ms between
// questions.
constexpr Duration kGiveUp = std::chrono::milliseconds(36);
constexpr int kMostFrames = 512;  // in one go: a babbling bus must not hold the caller up

std::size_t number(Property property) {
  return static_cast<std::size_t>(property);
}

}  // namespace

PuckLink::PuckLink(CanBus& bus, const Clock& clock, Duration reply, Duration tactile_reply)
    : bus_(bus), clock_(clock), tactile_reply_(tactile_reply), round_trip_(reply) {}

void PuckLink::measure_round_trip(Duration for_how_long) noexcept {
  round_trip_.be_patient(for_how_long, clock_.now());
}

Duration PuckLink::three_tries() const noexcept {
  return std::max(kGiveUp, kTries * round_trip_.deadline(clock_.now()));
}

PuckLink::Question& PuckLink::question(Puck puck, Property property) noexcept {
  return questions_[index(puck)][number(property)];
}

const PuckLink::Question& PuckLink::question(Puck puck, Property property) const noexcept {
  return questions_[index(puck)][number(property)];
}

const Reported& PuckLink::reported(Puck puck, Property property) const noexcept {
  return question(puck, property).reported;
}

bool PuckLink::pending(Puck puck, Property property) const noexcept {
  return open_[index(puck)].test(number(property));
}

bool PuckLink::unanswered(Puck puck, Property property) const noexcept {
  return lost_[index(puck)].test(number(property));
}

bool PuckLink::silent(Puck puck) const noexcept {
  return lost_[index(puck)].any();
}

bool PuckLink::repeats(Puck puck) const noexcept {
  const auto& open = open_[index(puck)];
  for (std::size_t n = 0; open.any() && n < open.size(); ++n)
    if (open.test(n) && questions_[index(puck)][n].tries > 0) return true;
  return false;
}

bool PuckLink::busy() const noexcept {
  return std::any_of(queues_.begin(), queues_.end(), [](const Queue& q) { return q.size > 0; });
}

void PuckLink::forget(Puck puck) noexcept {
  for (Question& q : questions_[index(puck)]) {
    const auto taken = q.taken;
    q = {};
    q.taken = taken;
  }
  open_[index(puck)].reset();
  lost_[index(puck)].reset();
}

void PuckLink::forget_settings(Puck puck) noexcept {
  for (Question& q : questions_[index(puck)]) q.taken.reset();
}

void PuckLink::drop_settings(Puck puck) noexcept {
  Queue& q = queues_[index(puck)];
  q.first = q.size = 0;
  q.tries = 0;
  q.reading_back = false;
}

void PuckLink::drop_all() noexcept {
  ping_.pending = false;
  for (const Puck puck : kAllPucks) {
    drop_settings(puck);
    open_[index(puck)].reset();
    pads_[index(puck)].pending = pads_[index(puck)].to_send = false;
  }
}

std::optional<Property> PuckLink::take_refusal(Puck puck) noexcept {
  return std::exchange(queues_[index(puck)].refused, std::nullopt);
}

void PuckLink::begin(Question& q, Timestamp now) noexcept {
  q.asked_at = now;
  q.sent = false;
}

void PuckLink::sent(Question& q, Timestamp now) noexcept {
  q.sent = true;
  q.asked_at = now;
  q.served = served_;
  if (q.tries > 0) return;
  q.first_asked_at = now;
  q.first_served = served_;
}

// Of a question that was repeated more answers may come than one.
void PuckLink::close(Question& q, Timestamp now) noexcept {
  if (q.tries > 0) q.stale_until = std::max(q.stale_until, now + round_trip_.worst());
}

void PuckLink::ask(Puck puck, Property property) noexcept {
  if (pending(puck, property)) return;
  Question& q = question(puck, property);
  q.tries = 0;
  begin(q, clock_.now());
  open_[index(puck)].set(number(property));
}

void PuckLink::ask_all(Property property) noexcept {
  const Timestamp now = clock_.now();
  const bool together = grouped_ && std::none_of(kAllPucks.begin(), kAllPucks.end(),
                                                 [&](Puck p) { return pending(p, property); });
  const bool together_sent = together && send(encode_get(kToHand, property));
  for (const Puck puck : kAllPucks) {
    if (silent(puck) || pending(puck, property)) continue;
    ask(puck, property);
    if (together_sent) sent(question(puck, property), now);
  }
}

void PuckLink::ask_lost(Puck puck) noexcept {
  const auto& lost = lost_[index(puck)];
  for (std::size_t n = 0; lost.any() && n < lost.size(); ++n)
    if (lost.test(n)) ask(puck, static_cast<Property>(n));
}

void PuckLink::ask_tactile(Puck puck, int format, bool send) noexcept {
  Pad& pad = pads_[index(puck)];
  if (pad.pending) return;
  pad.asked_at = clock_.now();
  pad.full = format == kTactFull;
  pad.rows = 0;
  pad.pending = true;
  pad.to_send = send;
}

void PuckLink::set(Puck puck, Property property, std::int32_t value, bool verify) noexcept {
  Queue& q = queues_[index(puck)];
  if (q.size ==
      q.settings.size()) {  // never by the driver's own doing; a refusal is better than a lost setting
    q.refused = property;
    return;
  }
  q.settings[(q.first + q.size++) % q.settings.size()] = {property, value, verify};
}

void PuckLink::pump(Duration timeout) noexcept {
  CanFrame frame;
  for (int i = 0; i < kMostFrames; ++i) {
    if (bus_.receive(frame, i == 0 ? timeout : Duration::zero()) != CanBus::Received::Frame) break;
    take(frame);
  }
  const Timestamp now = clock_.now();
  served_ += std::min(now - pumped_at_, kMostServed);
  pumped_at_ = now;
  round_trip_.step(now);
  check_deadlines(now);
  stalled_ = false;
  for (const Puck puck : kAllPucks) run_queue(puck, now);
  send_due(now);
}

void PuckLink::take(const CanFrame& frame) noexcept {
  const auto reply = decode_reply(frame);
  if (!reply) {
    ++rejected_;
    if (const auto request = decode_request(frame)) note_foreign(*request, frame.arrived_at);
    return;
  }
  const Timestamp at = frame.arrived_at;
  if (const auto* value = std::get_if<ValueReply>(&*reply)) {
    answer(value->puck, value->property, value->value, at);
  } else if (const auto* position = std::get_if<PositionReply>(&*reply)) {
    // the joint's encoder comes along, nobody asks for it
    if (pending(position->puck, Property::P)) {
      Reported& joint = question(position->puck, Property::Jp).reported;
      joint = {position->joint.value_or(0), at, at, position->joint.has_value()};
    }
    answer(position->puck, Property::P, position->motor, at);
  } else if (const auto* row = std::get_if<TactileRow>(&*reply)) {
    ++(take_row(*row, at) ? accepted_ : rejected_);
  } else if (const auto* top = std::get_if<TactileTop>(&*reply)) {
    ++(take_top(*top, at) ? accepted_ : rejected_);
  }
}

void PuckLink::answer(Puck puck, Property property, std::int32_t value, Timestamp at) noexcept {
  Question& q = question(puck, property);
  const bool waited_for = pending(puck, property) && q.sent;
  if (!waited_for && property == Property::Vers && ping_.pending && ping_.puck == puck) {
    ping_.pending = false;
    round_trip_.note_answer(own_time(ping_.at, ping_.served, at));
    ++accepted_;
    return;
  }
  const Duration age = own_time(q.asked_at, q.served, at);
  // one that was given up, and yet it comes: the link is slow
  const bool overdue = !waited_for && unanswered(puck, property) && at - q.asked_at < RoundTrip::kLatest;
  if (!waited_for && !overdue) {
    // doubled, somebody else's, or late: the answer to a question that was repeated meanwhile
    ++rejected_;
    return;
  }
  ++accepted_;
  if (overdue || age > round_trip_.deadline(at))
    round_trip_.note_late(age, at);
  else if (q.tries == 0 && at >= q.stale_until)
    round_trip_.note_answer(age);
  // to which of several questions it is the answer nobody knows: to the first, at worst
  q.reported = {value, at, q.first_asked_at, true};
  close(q, at);
  open_[index(puck)].reset(number(property));
  lost_[index(puck)].reset(number(property));
}

// How old an answer is, without the time in which nobody pumped: then it waited for us.
Duration PuckLink::own_time(Timestamp since, Duration served, Timestamp at) const noexcept {
  const Duration now_served = served_ + std::clamp(at - pumped_at_, Duration::zero(), kMostServed);
  return std::min(at - since, now_served - served);
}

void PuckLink::ping() noexcept {
  const Timestamp now = clock_.now();
  if (ping_.pending && now - ping_.at < RoundTrip::kLatest) return;
  ping_.pending = false;
  for (int i = 0; i < kPucks; ++i) {
    ping_.puck = kAllPucks[(index(ping_.puck) + 1) % kPucks];
    if (silent(ping_.puck) || pending(ping_.puck, Property::Vers)) continue;
    ping_.pending = send(encode_get(id_to(ping_.puck), Property::Vers));
    ping_.at = now;
    ping_.served = served_;
    return;
  }
}

void PuckLink::note_foreign(const Request& request, Timestamp at) noexcept {
  if (!request.sets) {
    ++foreign_.questions;
    foreign_.asked_at = at;
    return;
  }
  ++foreign_.settings;
  foreign_.last_setting = request;
}

bool PuckLink::take_row(const TactileRow& row, Timestamp at) noexcept {
  Pad& pad = pads_[index(row.puck)];
  const auto bit = static_cast<std::uint8_t>(1u << row.row);
  if (!pad.pending || !pad.full || (pad.rows & bit)) return false;
  for (std::size_t i = 0; i < row.cells.size(); ++i)
    if (const std::size_t cell = 5u * row.row + i; cell < pad.cells.size()) pad.cells[cell] = row.cells[i];
  pad.rows |= bit;
  if (pad.rows == (1u << kTactileRows) - 1) {
    pad.whole = {pad.cells, at, true};
    pad.pending = false;
  }
  return true;
}

bool PuckLink::take_top(const TactileTop& top, Timestamp at) noexcept {
  Pad& pad = pads_[index(top.puck)];
  if (!pad.pending || pad.full) return false;
  pad.whole = {top.cells, at, true};
  pad.pending = false;
  return true;
}

void PuckLink::check_deadlines(Timestamp now) noexcept {
  for (const Puck puck : kAllPucks) {
    auto& open = open_[index(puck)];
    for (std::size_t n = 0; open.any() && n < open.size(); ++n) {
      if (!open.test(n)) continue;
      Question& q = questions_[index(puck)][n];
      if (!q.sent || served_ - q.served < round_trip_.deadline(now)) continue;
      if (q.tries + 1 < kTries) {
        ++q.tries;
        begin(q, now);
      } else if (served_ - q.first_served >= kGiveUp) {
        close(q, now);
        open.reset(n);
        lost_[index(puck)].set(n);
      }
    }
    Pad& pad = pads_[index(puck)];
    // an unfinished scan is nobody's fault: in position mode a puck may send none
    if (pad.pending && now >= pad.asked_at + tactile_reply_) pad.pending = false;
  }
}

void PuckLink::send_due(Timestamp now) noexcept {
  for (const Puck puck : kAllPucks) {
    const auto& open = open_[index(puck)];
    for (std::size_t n = 0; open.any() && n < open.size() && !stalled_; ++n) {
      if (!open.test(n)) continue;
      Question& q = questions_[index(puck)][n];
      if (q.sent) continue;
      q.asked_at = now;
      if (send(encode_get(id_to(puck), static_cast<Property>(n)))) sent(q, now);
    }
    Pad& pad = pads_[index(puck)];
    if (pad.pending && pad.to_send && !stalled_) {
      pad.asked_at = now;
      pad.to_send = !send(encode_get(id_to(puck), Property::Tact));
    }
  }
}

void PuckLink::run_queue(Puck puck, Timestamp now) noexcept {
  Queue& q = queues_[index(puck)];
  if (q.size == 0) return;
  const Setting& s = q.settings[q.first];
  const auto done = [&] {
    q.first = (q.first + 1) % q.settings.size();
    --q.size;
    q.tries = 0;
    q.reading_back = false;
  };
  if (q.reading_back) {
    if (pending(puck, s.property)) return;
    q.reading_back = false;
    const Reported& read_back = reported(puck, s.property);
    if (!unanswered(puck, s.property) && read_back.asked_at >= q.last_sent && read_back.value == s.value) {
      question(puck, s.property).taken = TakenSetting{s.value, now};
      done();
    } else if (unanswered(puck, s.property) || ++q.tries >= kTries) {
      q.refused = s.property;
      drop_settings(puck);
    }
    if (q.size == 0) return;
  }
  const Setting& next = q.settings[q.first];
  if (stalled_ || now < q.last_sent + kBetweenSettings) return;
  // an answer to a question from before the setting would be taken for its reading back
  if (next.verify && (pending(puck, next.property) || now < question(puck, next.property).stale_until))
    return;
  if (!send(encode_set(id_to(puck), next.property, next.value))) return;
  q.last_sent = now;
  question(puck, next.property).taken.reset();
  if (next.property == Property::Cmd) question(puck, Property::E).taken.reset();
  if (next.property == Property::Mode) mode_set_at_[index(puck)] = now;
  if (!next.verify) {
    done();
    return;
  }
  ask(puck, next.property);
  q.reading_back = true;
}

bool PuckLink::send(const CanFrame& frame) noexcept {
  if (stalled_) return false;
  switch (bus_.send(frame)) {
    case CanBus::Sent::Yes:
      full_in_a_row_ = 0;
      return true;
    case CanBus::Sent::Full:
      ++full_in_a_row_;
      break;
    case CanBus::Sent::Down:
      break;
  }
  stalled_ = true;  // nothing more in this turn: what is left keeps its order
  return false;
}

}  // namespace colift::hal::barrett
