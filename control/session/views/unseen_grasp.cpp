#include "control/session/views/unseen_grasp.hpp"

#include <fmt/format.h>

#include <cmath>

namespace colift::control {
namespace {

using perception::PartnerEvent;

constexpr double kMaxAway_s = 1.0;  // a frame or two in which less of the edge is hidden

}  // namespace

std::optional<PartnerEvent> UnseenGrasp::update(hal::Timestamp at,
                                                const std::optional<perception::ObjectMotion>& motion,
                                                const hal::Vec3& up_W, perception::PartnerObservation& seen,
                                                perception::PartnerTracker& tracker) {
  if (motion && behind_body_)
    if (auto event = raised(at, *motion, up_W, seen, tracker)) return event;
  return still_there(at, seen, tracker);
}

std::optional<PartnerEvent> UnseenGrasp::raised(hal::Timestamp at, const perception::ObjectMotion& motion,
                                                const hal::Vec3& up_W, perception::PartnerObservation& seen,
                                                perception::PartnerTracker& tracker) {
  const auto held = raised_end_.update(at, *behind_body_, motion, up_W);
  if (raised_end_.moves())
    seen.reason =
        fmt::format("the object rises by {:.0f} mm behind somebody's body", 1e3 * raised_end_.rise_m());
  if (!held) return std::nullopt;
  const hal::Vec3& at_W = held->grasp.position;
  before_ = held->grasp;
  return tracker.hold_unseen(
      at, held->grasp,
      fmt::format(
          "the object rose by {:.0f} mm behind his body, and stands again: he holds it about ({:.2f}, "
          "{:.2f}, {:.2f}) m, +- {:.0f} mm; his hand is not seen",
          1e3 * held->rise_m, at_W.x(), at_W.y(), at_W.z(),
          1e3 * std::sqrt(held->grasp.covariance.trace() / 3.0)));
}

std::optional<PartnerEvent> UnseenGrasp::still_there(hal::Timestamp at,
                                                     const perception::PartnerObservation& seen,
                                                     perception::PartnerTracker& tracker) {
  if (!before_) return std::nullopt;
  if (!hides(seen, before_)) {
    if (!away_since_) away_since_ = at;
    there_since_.reset();
    if (seen.kind == perception::PartnerKind::Grasp || hal::seconds(at - *away_since_) > kMaxAway_s)
      before_.reset();
    return std::nullopt;
  }
  away_since_.reset();
  if (!there_since_) there_since_ = at;
  if (hal::seconds(at - *there_since_) < dwell_s_) return std::nullopt;
  return tracker.hold_unseen(
      at, *before_, "he still stands before the place at which he raised the object; his hand is not seen");
}

bool UnseenGrasp::hides(const perception::PartnerObservation& seen,
                        const std::optional<perception::PartnerGrasp>& grasp) const {
  return grasp && seen.kind != perception::PartnerKind::Grasp && seen.hidden_edge &&
         (seen.hidden_edge->grasp.position - grasp->position).norm() <= max_shift_m_;
}

void UnseenGrasp::forget_motion() {
  there_since_.reset();
  away_since_.reset();
  raised_end_.forget();
  behind_body_.reset();
}

}  // namespace colift::control
