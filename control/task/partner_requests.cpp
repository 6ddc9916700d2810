#include "control/task/partner_requests.hpp"

#include <algorithm>

#include "control/session/suggest.hpp"
#include "control/test_lift/partner_request.hpp"

namespace colift::control {
namespace {

// a partner who is seen so near to where he was has not left: his grasp is seen to 2 cm at the 90th
// percentile, and a hand is some 8 cm wide
constexpr double kSamePlace_m = 0.06;

}  // namespace

bool PartnerRequests::ask(const std::vector<planner::GraspCandidate>& judged) {
  if (!c_.record.decision || !c_.record.decision->partner) return false;
  const hal::Vec3 from = c_.record.decision->partner->position;
  const auto& test_lift = c_.test_lifts.known();
  hal::Vec3 to;
  std::string request;
  if (test_lift) {
    std::vector<hal::Vec3> held{from};
    for (const MeasuredLift& t : c_.test_lifts.measured()) held.push_back(t.partner);
    const auto place = next_partner_place(judged, judged, held, test_lift->belief, c_.config.test_lift);
    if (!place) return false;
    to = place->position, request = place->reason;
  } else {
    const SceneAnalysis& analysis = c_.session.analysis();
    const auto better =
        suggest_to_partner(*c_.record.decision, analysis.candidates, analysis.scene.target->cog,
                           hal::Vec3::UnitZ(), c_.config.decision);
    if (!better) return false;
    to = better->position, request = better->reason;
  }
  c_.attempts.failure += "; " + request;
  const int max_requests = test_lift ? c_.config.test_lift.asks : c_.config.task.asks;
  if (c_.options.dry_run || times_asked_ >= max_requests) return false;
  ++times_asked_;
  asked_ = {from, to, request, c_.attempts.failure};
  c_.record.asked.push_back({c_.now - c_.began, to, request});
  return true;
}

bool PartnerRequests::stays_where_he_was() const {
  const auto grasp = c_.session.tracker().grasp();
  const double near_m = std::min(kSamePlace_m, 0.5 * (asked_->to - asked_->from).norm());
  return grasp && (grasp->position - asked_->from).norm() < near_m;
}

}  // namespace colift::control
