#include "hal/drivers/barrett_can/replay/recorded_pucks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

namespace colift::hal::barrett {
namespace {

// Periods up to 0.4 s whose phase no two sessions share; and a thread that is late once.
constexpr Duration kNear = std::chrono::milliseconds(500);
// Of questions: settings and marks are asked for once a second in turn.
constexpr Duration kAskedNear = std::chrono::milliseconds(1500);
constexpr std::size_t kMostDifferences = 200;

Duration apart(Timestamp a, Timestamp b) {
  return a > b ? a - b : b - a;
}

// Of an answer: the low byte first, behind the property and its array byte.
void set_value(CanFrame& answer, std::int32_t value) {
  for (std::size_t i = 2; i < answer.length; ++i)
    answer.data[i] = static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> 8 * (i - 2));
}

}  // namespace

RecordedPucks::RecordedPucks(const std::vector<CandumpFrame>& frames, Duration shift, ManualClock& clock)
    : frames_(frames), shift_(shift), clock_(clock), session_(read_puck_session(frames)) {
  for (std::size_t r = 0; r < session_.requests.size(); ++r) {
    const PuckRequest& request = session_.requests[r];
    if (request.says.sets) {
      settings_[frames_[request.frame].frame.id].push_back(r);
      for (const Puck puck : kAllPucks)
        if (!request.says.puck || *request.says.puck == puck)
          of_property_[{puck, request.says.property}].frames.push_back(request.frame);
    } else {
      for (std::size_t k = 0; k < request.answers.size(); ++k)
        questions_[{request.answers[k].puck, request.says.property}].recorded.push_back({r, k});
    }
  }
  for (const std::uint32_t i : session_.unasked)
    note_difference(frames_[i].line, "an answer to what the recording does not ask");
  for (const std::uint32_t i : session_.others) post(frames_[i].frame, frames_[i].frame.arrived_at + shift_);
}

Result<> RecordedPucks::open() {
  open_ = true;
  health_.state = CanHealth::State::Active;
  return {};
}

void RecordedPucks::post(CanFrame frame, Timestamp due) {
  const auto after = std::upper_bound(queue_.begin(), queue_.end(), due,
                                      [](Timestamp t, const Letter& l) { return t < l.due; });
  queue_.insert(after, {due, frame});
}

CanBus::Received RecordedPucks::receive(CanFrame& into, Duration timeout) noexcept {
  if (!open_) return Received::Down;
  const Timestamp until = clock_.now() + timeout;
  for (;;) {
    const Timestamp now = clock_.now();
    if (!queue_.empty() && queue_.front().due <= now) {
      into = queue_.front().frame;
      into.arrived_at = queue_.front().due;
      queue_.pop_front();
      ++health_.received;
      return Received::Frame;
    }
    if (now >= until) return Received::Nothing;
    clock_.advance((queue_.empty() ? until : std::min(until, queue_.front().due)) - now);
  }
}

CanBus::Sent RecordedPucks::send(const CanFrame& frame) noexcept {
  if (!open_) return Sent::Down;
  ++health_.sent;
  const auto says = decode_request(frame);
  const Timestamp now = clock_.now();
  if (!says)
    note_difference(
        0, fmt::format("the driver sends {:03X} with {} bytes, which is neither question nor setting",
                       frame.id, frame.length));
  else if (says->sets)
    hear_setting(frame, *says, now);
  else
    hear_question(*says, now);
  return Sent::Yes;
}

Timestamp RecordedPucks::at(std::size_t request) const {
  return line(request).frame.arrived_at + shift_;
}

const CandumpFrame& RecordedPucks::line(std::size_t request) const {
  return frames_[session_.requests[request].frame];
}

// DS holds the second in which the puck was switched on, by our clock: a later poll rounds it otherwise.
bool RecordedPucks::alike(const CanFrame& said, std::size_t request) const {
  if (said == line(request).frame) return true;
  const Request& then = session_.requests[request].says;
  const auto now = decode_request(said);
  return now && said.id == line(request).frame.id && said.length == line(request).frame.length &&
         now->property == then.property && now->sets == then.sets && then.property == Property::Ds &&
         std::abs(static_cast<long>(now->value) - then.value) <= 1;
}

// A puck that was given another second then reports that second now: what was set is read back.
void RecordedPucks::keep_power_on(const CanFrame& said, std::size_t request) {
  const Request& then = session_.requests[request].says;
  const auto now = decode_request(said);
  if (!now || !then.sets || then.property != Property::Ds) return;
  for (const Puck puck : kAllPucks)
    if (!then.puck || *then.puck == puck) power_on_later_s_[puck] = now->value - then.value;
}

// The same as the one before it: a renewal, a wake-up or a repeat, whose number depends on the time.
bool RecordedPucks::repeated(const std::vector<std::size_t>& list, std::size_t i) const {
  return i > 0 && i < list.size() && line(list[i]).frame == line(list[i - 1]).frame;
}

void RecordedPucks::take(std::size_t request, Timestamp now) {
  const Request& says = session_.requests[request].says;
  if (apart(now, at(request)) > kNear)
    note_difference(line(request).line,
                    fmt::format("{} is said {:.2f} s {} than recorded", describe(says),
                                seconds(apart(now, at(request))), now > at(request) ? "later" : "earlier"));
  for (const Puck puck : kAllPucks) {
    if (says.puck && *says.puck != puck) continue;
    Settings& of = of_property_[{puck, says.property}];
    while (of.said < of.frames.size() && of.frames[of.said] <= session_.requests[request].frame) ++of.said;
  }
  for (const PuckAnswer& a : session_.requests[request].answers) answer(a, at(request), now);
}

void RecordedPucks::hear_setting(const CanFrame& frame, const Request& says, Timestamp now) {
  ++findings_.settings;
  const auto& list = settings_[frame.id];
  std::size_t& next = next_setting_[frame.id];
  if (next < list.size() && alike(frame, list[next])) {
    keep_power_on(frame, list[next]);
    take(list[next++], now);
    return;
  }
  if (next > 0 && alike(frame, list[next - 1])) {
    keep_power_on(frame, list[next - 1]);
    ++findings_.repeats;
    return;
  }
  std::size_t later = next;
  while (later < list.size() && !alike(frame, list[later]) && at(list[later]) < now + kNear) ++later;
  if (later < list.size() && alike(frame, list[later])) {
    for (; next < later; ++next) {
      if (repeated(list, next))
        ++findings_.repeats;
      else
        note_difference(line(list[next]).line, fmt::format("recorded {}: the driver does not say it",
                                                           describe(session_.requests[list[next]].says)));
    }
    take(list[next++], now);
    return;
  }
  const bool other_value = next < list.size() && session_.requests[list[next]].says.property == says.property;
  if (next >= list.size()) {
    note_difference(list.empty() ? 0 : line(list.back()).line,
                    fmt::format("after this the driver says {}, which is not recorded", describe(says)));
    return;
  }
  note_difference(line(list[next]).line,
                  fmt::format("recorded {}: the driver says {}", describe(session_.requests[list[next]].says),
                              describe(says)));
  if (other_value) take(list[next++], now);
}

void RecordedPucks::hear_question(const Request& says, Timestamp now) {
  ++findings_.questions;
  for (const Puck puck : kAllPucks) {
    if (says.puck && *says.puck != puck) continue;
    const Key key{puck, says.property};
    questions_[key].now.push_back(now);
    if (const auto then = nearest(key, now))
      answer(session_.requests[then->request].answers[then->answer], at(then->request), now);
  }
}

std::optional<RecordedPucks::Exchange> RecordedPucks::nearest(const Key& key, Timestamp now) const {
  const auto& list = questions_.at(key).recorded;
  if (list.empty()) return std::nullopt;
  std::uint32_t since = 0, until = static_cast<std::uint32_t>(frames_.size());
  if (const auto found = of_property_.find(key); found != of_property_.end()) {
    const auto& [frames, said] = found->second;
    if (said > 0) since = frames[said - 1];
    if (said < frames.size()) until = frames[said];
  }
  const auto before = [&](std::uint32_t frame) {
    return std::partition_point(list.begin(), list.end(), [&](const Exchange& e) {
      return session_.requests[e.request].frame < frame;
    });
  };
  auto begin = before(since), end = before(until);
  if (begin >= end) begin = list.begin(), end = list.end();  // not asked in between
  const auto after = std::partition_point(begin, end, [&](const Exchange& e) { return at(e.request) < now; });
  if (after == begin) return *begin;
  if (after == end) return *std::prev(end);
  return now - at(std::prev(after)->request) <= at(after->request) - now ? *std::prev(after) : *after;
}

void RecordedPucks::answer(const PuckAnswer& with, Timestamp then, Timestamp now) {
  for (std::size_t i = 0; i < with.count; ++i) {
    CanFrame frame = frames_[with.frames[i]].frame;
    if (const auto says = read_answer(frame); says && says->property == Property::Ds && says->value)
      if (const auto later = power_on_later_s_.find(with.puck); later != power_on_later_s_.end())
        set_value(frame, *says->value + later->second);
    post(frame, now + std::max(frame.arrived_at + shift_ - then, Duration(1)));
  }
}

Timestamp RecordedPucks::end() const {
  return frames_.empty() ? clock_.now() : frames_.back().frame.arrived_at + shift_;
}

void RecordedPucks::note_difference(std::uint32_t line, std::string words) {
  if (findings_.differences.size() < kMostDifferences)
    findings_.differences.push_back({line, std::move(words)});
  else
    ++findings_.more;
}

ReplayFindings RecordedPucks::finish() {
  for (const auto& [id, list] : settings_)
    for (std::size_t i = next_setting_[id]; i < list.size(); ++i) {
      if (repeated(list, i))
        ++findings_.repeats;
      else
        note_difference(line(list[i]).line, fmt::format("recorded {}: the driver does not say it",
                                                        describe(session_.requests[list[i]].says)));
    }
  for (const auto& [key, asked] : questions_) {
    const std::string what = fmt::format("{}: {}?", name(key.first), property_word(key.second));
    std::size_t near = 0;
    std::uint32_t told = 0;
    for (const Exchange& e : asked.recorded) {
      const std::size_t r = e.request;
      while (near < asked.now.size() && asked.now[near] + kAskedNear < at(r)) ++near;
      if (near < asked.now.size() && apart(asked.now[near], at(r)) <= kAskedNear) continue;
      if (line(r).line != told)
        note_difference(line(r).line, fmt::format("recorded {}: the driver does not ask that within {:.1f} s",
                                                  what, seconds(kAskedNear)));
      told = line(r).line;
    }
    near = 0;
    for (const Timestamp now : asked.now) {
      while (near < asked.recorded.size() && at(asked.recorded[near].request) + kAskedNear < now) ++near;
      if (near < asked.recorded.size() && apart(at(asked.recorded[near].request), now) <= kAskedNear)
        continue;
      const auto before = std::partition_point(frames_.begin(), frames_.end(), [&](const CandumpFrame& f) {
        return f.frame.arrived_at + shift_ <= now;
      });
      note_difference(before == frames_.begin() ? 0 : std::prev(before)->line,
                      fmt::format("here the driver asks {} The recording does not within {:.1f} s", what,
                                  seconds(kAskedNear)));
      break;  // once for each kind of question
    }
  }
  std::stable_sort(findings_.differences.begin(), findings_.differences.end(),
                   [](const auto& a, const auto& b) { return a.line < b.line; });
  return std::move(findings_);
}

}  // namespace colift::hal::barrett
