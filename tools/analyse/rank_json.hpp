#pragma once

#include <string>
#include <string_view>

#include "planner/load_sharing/rank.hpp"

namespace colift::tools {

/// Reads the document of `colift rank` strictly: every key but `limits` and its parts is required, no other
/// key is known, no key comes twice, every number is finite. `name` is what errors call the document. Errors:
/// BadInput; where = "name:line:column", detail = the place by its keys, what was found and what was
/// expected.
[[nodiscard]] hal::Result<planner::RankProblem> parse_rank_problem(std::string_view text,
                                                                   const std::string& name);

/// The document colift.rank/1 on one line. Numbers read back to the same bits.
[[nodiscard]] std::string rank_to_json(const planner::RankResult& result);

/// The same as a table for people, best first, with a clear last line.
[[nodiscard]] std::string rank_to_table(const planner::RankProblem& problem,
                                        const planner::RankResult& result);

}  // namespace colift::tools
