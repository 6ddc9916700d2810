#include "hal/drivers/barrett_can/replay/puck_session.hpp"

#include <fmt/format.h>

#include <deque>
#include <map>
#include <utility>

namespace colift::hal::barrett {
namespace {

constexpr Duration kLatest = std::chrono::milliseconds(500);

struct Open {
  std::size_t request = 0, answer = 0;
  Timestamp at{0};
};

bool starts_scan(const Request& r) {
  return r.property == Property::Tact && r.sets && (r.value == kTactTop10 || r.value == kTactFull);
}

}  // namespace

std::optional<AnswerValue> read_answer(const CanFrame& frame) {
  const auto reply = decode_reply(frame);
  if (!reply) return std::nullopt;
  if (const auto* value = std::get_if<ValueReply>(&*reply))
    return AnswerValue{value->puck, value->property, value->value};
  if (const auto* position = std::get_if<PositionReply>(&*reply))
    return AnswerValue{position->puck, Property::P, position->motor};
  if (const auto* row = std::get_if<TactileRow>(&*reply))
    return AnswerValue{row->puck, Property::Tact, std::nullopt, row->row == 0, row->row + 1 == kTactileRows};
  return AnswerValue{std::get<TactileTop>(*reply).puck, Property::Tact, std::nullopt};
}

PuckSession read_puck_session(const std::vector<CandumpFrame>& frames) {
  using Direction = CandumpFrame::Direction;
  PuckSession session;
  std::map<std::pair<Puck, Property>, std::deque<Open>> open;
  for (std::uint32_t i = 0; i < frames.size(); ++i) {
    const CanFrame& frame = frames[i].frame;
    const auto request = decode_request(frame);
    const bool ours = request && request->from == 0 && frames[i].direction != Direction::Received;
    if (ours) {
      PuckRequest said{i, *request, {}};
      if (!request->sets || starts_scan(*request))
        for (const Puck puck : kAllPucks) {
          if (request->puck && *request->puck != puck) continue;
          open[{puck, request->property}].push_back(
              {session.requests.size(), said.answers.size(), frame.arrived_at});
          said.answers.push_back({puck, {}, 0});
        }
      session.requests.push_back(std::move(said));
      continue;
    }
    const auto answer = request ? std::nullopt : read_answer(frame);
    if (!answer) {
      session.others.push_back(i);
      continue;
    }
    auto& waiting = open[{answer->puck, answer->property}];
    const auto begun = [&](const Open& o) { return session.requests[o.request].answers[o.answer].count > 0; };
    // a scan that was cut off gets nothing of the next; one that has begun in time is not divided
    while (!waiting.empty() &&
           (begun(waiting.front()) ? answer->begins_scan : frame.arrived_at - waiting.front().at > kLatest))
      waiting.pop_front();
    if (waiting.empty()) {
      session.unasked.push_back(i);
      continue;
    }
    PuckAnswer& to = session.requests[waiting.front().request].answers[waiting.front().answer];
    to.frames[to.count++] = i;
    if (answer->ends_scan || to.count == to.frames.size()) waiting.pop_front();
  }
  return session;
}

std::string property_word(Property property) {
  const PropertyInfo* info = property_info(static_cast<std::uint8_t>(property));
  return info != nullptr ? std::string(info->name) : fmt::format("property {}", static_cast<int>(property));
}

std::string describe(const Request& request) {
  const std::string_view to = request.puck ? name(*request.puck) : std::string_view("hand");
  if (!request.sets) return fmt::format("{}: {}?", to, property_word(request.property));
  return fmt::format("{}: {} = {}", to, property_word(request.property), request.value);
}

}  // namespace colift::hal::barrett
