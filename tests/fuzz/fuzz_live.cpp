// What clients send to the live view: Foxglove's protocol in both forms, a request's target and headers as
// far as we read them ourselves (the rest is Boost.Beast's), and how often they talk.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "tools/live/foxglove_wire.hpp"
#include "tools/live/page_files.hpp"
#include "tools/live/visitor.hpp"

namespace {

using namespace colift::live;

void check(bool holds) {
  if (!holds) std::abort();
}

/// A message is refused in a sentence, or within the limits that its reader relies on.
void check_message(const colift::hal::Result<ClientMessage>& message) {
  if (!message) return check(!message.error().detail.empty());
  if (const auto* s = std::get_if<Subscribe>(&*message)) check(s->subscriptions.size() <= kMostEntries);
  if (const auto* u = std::get_if<Unsubscribe>(&*message)) check(u->ids.size() <= kMostEntries);
}

/// Up to the next line's end, which leaves with it.
std::string line_of(std::string_view& rest) {
  const std::size_t end = std::min(rest.find('\n'), rest.size());
  std::string line(rest.substr(0, end));
  rest.remove_prefix(std::min(end + 1, rest.size()));
  return line;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  check_message(parse_text(bytes));
  check_message(parse_binary(bytes));

  // lines: target, Host, Origin, Sec-WebSocket-Protocol
  std::string_view rest = bytes;
  Visitor visitor;
  visitor.target = line_of(rest);
  visitor.host = line_of(rest);
  if (const std::string origin = line_of(rest); !origin.empty()) visitor.origin = origin;
  if (const auto spoken = chosen_sub_protocol(rest))
    check(*spoken == kSubProtocols[0] || *spoken == kSubProtocols[1]);
  DoorRules rules;
  rules.origins = {"https://app.example.org"};
  rules.token = "0123456789abcdef";
  if (!turned_away(visitor, rules))
    check(!visitor.origin || *visitor.origin == "http://" + visitor.host ||
          *visitor.origin == rules.origins[0]);
  if (has_token(visitor.target, rules))
    check(visitor.target.find("token=" + rules.token) != std::string::npos);
  check(!has_token(visitor.target, {}));
  if (const auto path = clean_path(visitor.target)) {
    check(path->front() == '/' && path->find("/..") == std::string::npos);
    check(path->find('\0') == std::string::npos && path->find('\\') == std::string::npos);
  }
  // a folder that is not there: only what was made is found
  PageFiles files("/nowhere/at/all");
  files.add("/robot.urdf", {"application/xml", "<robot/>"});
  if (const auto document = files.find(visitor.target)) check(!document->body.empty());

  TalkLimit talk(50.0, 200.0);
  int taken = 0;
  for (std::size_t i = 0; i < size; ++i) taken += talk.take(1e-3 * data[i]) ? 1 : 0;
  check(taken <= 200 + static_cast<int>(50 * 0.256 * static_cast<double>(size + 1)));
  return 0;
}
