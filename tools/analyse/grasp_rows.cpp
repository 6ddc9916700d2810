#include "tools/analyse/grasp_rows.hpp"

#include "planner/grasp/grasp_candidates.hpp"

namespace colift::tools {

std::vector<picture::ReportCandidate> candidate_rows(
    const std::vector<planner::GraspCandidate>& candidates,
    const std::vector<std::optional<planner::ScoredCandidate>>& scores) {
  std::vector<picture::ReportCandidate> rows;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const planner::GraspCandidate& c = candidates[i];
    picture::ReportCandidate row{c.id,    planner::name_of(c.kind), c.verdict, {}, {}, c.stability, c.width,
                                 c.reason};
    if (i < scores.size() && scores[i]) {
      row.share = scores[i]->share;
      row.cost = scores[i]->cost;
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace colift::tools
