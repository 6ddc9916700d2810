#pragma once

#include <optional>
#include <string>
#include <vector>

#include "control/task/task_context.hpp"

namespace colift::control {

/// Where no grasp is feasible the partner may be able to help: asks him to grasp elsewhere, and knows what he
/// was asked until he does.
class PartnerRequests {
 public:
  explicit PartnerRequests(TaskContext& context) : c_(context) {}

  /// Asks him, if there is a place that helps and he was not asked too often; attempts.failure names the
  /// place either way. `judged`: the scene's candidates, with reach.
  [[nodiscard]] bool ask(const std::vector<planner::GraspCandidate>& judged);

  [[nodiscard]] bool pending() const { return asked_.has_value(); }
  /// He still grasps where he was asked to leave.
  [[nodiscard]] bool stays_where_he_was() const;
  void fulfilled() { asked_.reset(); }

  // of the pending request
  [[nodiscard]] const hal::Vec3& place() const { return asked_->to; }           ///< W, m.
  [[nodiscard]] const std::string& sentence() const { return asked_->reason; }  ///< As it is said to him.
  [[nodiscard]] const std::string& reason() const { return asked_->why; }       ///< The whole reason.

 private:
  struct Asked {
    hal::Vec3 from, to;
    std::string reason, why;
  };

  TaskContext& c_;
  std::optional<Asked> asked_;
  int times_asked_ = 0;
};

}  // namespace colift::control
