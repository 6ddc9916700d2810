#include "tools/live/visitor.hpp"

#include <algorithm>
#include <cctype>

namespace colift::live {
namespace {

/// Without its port: "localhost", "127.0.0.1", "[::1]".
std::string_view name_of(std::string_view host) {
  if (!host.empty() && host.front() == '[') return host.substr(0, host.find(']') + 1);
  return host.substr(0, host.find(':'));
}

/// Names are the same in capitals.
bool same_name(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::tolower(x) == std::tolower(y); });
}

/// An address cannot be bent to this machine: only a name can.
bool is_loopback_or_number(std::string_view name) {
  if (same_name(name, "localhost")) return true;
  if (name.size() > 2 && name.front() == '[') return true;
  return !name.empty() &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) || c == '.'; });
}

}  // namespace

std::optional<std::string> turned_away(const Visitor& visitor, const DoorRules& rules) {
  if (visitor.host.empty()) return "a request needs the header Host";
  const std::string_view name = name_of(visitor.host);
  const auto ours = [&](const std::string& host) { return same_name(name, host); };
  if (!is_loopback_or_number(name) && std::none_of(rules.hosts.begin(), rules.hosts.end(), ours))
    return "the name in Host is none of this machine's; use its address in numbers";
  if (!visitor.origin) return std::nullopt;
  if (*visitor.origin == "http://" + visitor.host) return std::nullopt;
  if (shared_with(visitor, rules)) return std::nullopt;
  return "pages from elsewhere may not connect; allow this one with --allow-origin";
}

std::optional<std::string> shared_with(const Visitor& visitor, const DoorRules& rules) {
  if (!visitor.origin) return std::nullopt;
  const auto allowed = std::find(rules.origins.begin(), rules.origins.end(), *visitor.origin);
  return allowed == rules.origins.end() ? std::nullopt : visitor.origin;
}

bool has_token(std::string_view target, const DoorRules& rules) {
  if (rules.token.empty()) return false;
  const std::size_t query = target.find('?');
  if (query == std::string_view::npos) return false;
  std::string_view rest = target.substr(query + 1);
  while (!rest.empty()) {
    const std::string_view one = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(one.size() + 1, rest.size()));
    if (!one.starts_with("token=")) continue;
    const std::string_view token = one.substr(6);
    if (token.size() != rules.token.size()) return false;
    unsigned char differs = 0;
    for (std::size_t i = 0; i < token.size(); ++i)
      differs = static_cast<unsigned char>(differs | (token[i] ^ rules.token[i]));
    return differs == 0;
  }
  return false;
}

bool TalkLimit::take(double now_s) {
  left_ = std::min(burst_, left_ + std::max(0.0, now_s - last_s_) * per_second_);
  last_s_ = now_s;
  if (left_ < 1.0) return false;
  left_ -= 1.0;
  return true;
}

}  // namespace colift::live
