#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace colift::live {

/// Who may connect, and what for.
struct DoorRules {
  std::vector<std::string> origins;  ///< Allowed besides the server's own ("https://app.example.org").
  std::vector<std::string> hosts;    ///< Names of this machine besides "localhost"; addresses need none.
  std::string token;                 ///< An operator's; empty: nobody operates.
};

/// Whether a request may come in, by its headers. A browser sends the page's origin; a page from elsewhere
/// must not talk to a robot through its visitor's browser. A foreign Host is a name that was bent to this
/// address (DNS rebinding).
struct Visitor {
  std::string host;                   ///< Header Host.
  std::optional<std::string> origin;  ///< Header Origin; programs send none.
  std::string target;                 ///< Path and query.
};
/// nullopt: welcome; else the sentence for the answer 403.
[[nodiscard]] std::optional<std::string> turned_away(const Visitor& visitor, const DoorRules& rules);

/// Whether the query holds the operator's token ("/?token=..."). Compared in constant time.
[[nodiscard]] bool has_token(std::string_view target, const DoorRules& rules);

/// The origin whose pages may read what is served: the visitor's own, where it was allowed (Fetch standard,
/// Access-Control-Allow-Origin). nullopt: programs, our own page, and pages from elsewhere.
[[nodiscard]] std::optional<std::string> shared_with(const Visitor& visitor, const DoorRules& rules);

/// How much a client may say: `burst` messages at once, then `per_second`.
class TalkLimit {
 public:
  TalkLimit(double per_second, double burst) : per_second_(per_second), burst_(burst), left_(burst) {}
  /// One more message at `now_s`; false: too many.
  [[nodiscard]] bool take(double now_s);

 private:
  double per_second_, burst_, left_, last_s_ = 0.0;
};

}  // namespace colift::live
