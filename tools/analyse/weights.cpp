#include "tools/analyse/weights.hpp"

#include <fmt/format.h>

#include "control/session/method.hpp"
#include "tools/cli/numbers.hpp"

namespace colift::tools {

hal::Result<control::Method> parse_method(const std::string& text, const control::Config& config) {
  const std::string& method = text.empty() ? config.method : text;
  if (method == "fast") return control::Method::Fast;
  if (method == "thesis") return control::Method::Thesis;
  return hal::failure(hal::ErrorCode::BadInput, "--method",
                      fmt::format("\"{}\" is not known, expected fast or thesis", method));
}

hal::Result<> set_weights(control::Method method, const std::string& share, const std::string& epsilon,
                          control::Config& config) {
  control::use_method(method, config);
  if (!share.empty() && !epsilon.empty())
    return hal::failure(hal::ErrorCode::BadInput, "--share",
                        "goes without --epsilon: either one says how the load is shared");
  if (!epsilon.empty()) {
    const auto n = parse_numbers(epsilon, 1, "--epsilon");
    if (!n) return tl::unexpected(n.error());
    if (n->front() <= 0.0)
      return hal::failure(hal::ErrorCode::BadInput, "--epsilon",
                          fmt::format("{} has to be greater than 0", n->front()));
    config.decision.weights.epsilon = n->front();
  }
  if (!share.empty()) {
    const auto n = parse_numbers(share, 1, "--share");
    if (!n) return tl::unexpected(n.error());
    const auto wanted = planner::epsilon_for_share(n->front());
    if (!wanted) return hal::failure(hal::ErrorCode::BadInput, "--share", wanted.error().detail);
    config.decision.weights.epsilon = *wanted;
  }
  return {};
}

}  // namespace colift::tools
