// libFuzzer: whatever the bytes, the parser of `colift rank` answers with a problem or with an error that has
// a place and a sentence, and the ranking of an accepted problem has one entry per candidate and prints as
// JSON.
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

#include "planner/load_sharing/rank.hpp"
#include "tools/analyse/rank_json.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto problem = colift::tools::parse_rank_problem(text, "fuzz");
  if (!problem) {
    if (problem.error().where.rfind("fuzz:", 0) != 0 || problem.error().detail.empty()) std::abort();
    return 0;
  }
  const auto ranked = colift::planner::rank(*problem);
  if (!ranked) return 0;
  if (ranked->ranking.size() != problem->candidates.size()) std::abort();
  const std::string printed = colift::tools::rank_to_json(*ranked);
  if (printed.find("nan") != std::string::npos || printed.find("inf,") != std::string::npos) std::abort();
  return 0;
}
