#pragma once

#include <optional>
#include <vector>

#include "planner/grasp/grasp_decision.hpp"
#include "tools/visualization/report/report.hpp"

namespace colift::tools {

/// Rows of a report's decision table. `scores` may be shorter than the candidates.
[[nodiscard]] std::vector<picture::ReportCandidate> candidate_rows(
    const std::vector<planner::GraspCandidate>& candidates,
    const std::vector<std::optional<planner::ScoredCandidate>>& scores);

}  // namespace colift::tools
