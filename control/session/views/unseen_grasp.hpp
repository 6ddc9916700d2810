#pragma once

#include <optional>

#include "perception/motion/raised_end.hpp"
#include "perception/partner/partner_tracker.hpp"
#include "perception/scene.hpp"

namespace colift::control {

/// Whoever holds the object where no camera sees his hand, because his body hides it: the object rises behind
/// him and stands again. Tells the tracker (docs/decisions/0017-a-hand-that-is-hidden.md).
class UnseenGrasp {
 public:
  /// \param dwell_s  How long he has to stand where he stood to hold it still, after the robot came back.
  UnseenGrasp(const perception::RaiseConfig& config, double dwell_s)
      : raised_end_(config), max_shift_m_(config.max_shift_m), dwell_s_(dwell_s) {}

  /// Before update(): where a hand may be that this frame hides.
  void look(const perception::PartnerObservation& seen) {
    if (seen.hidden_edge) behind_body_ = seen.hidden_edge->grasp;
  }
  /// Somebody hides an edge, or did: the object's motion tells whether he holds it.
  [[nodiscard]] bool needs_motion() const { return behind_body_.has_value(); }

  /// A frame, measured at `at`, in which nobody is known to hold the object.
  ///
  /// \param motion  Of the object against the reference, in the same frame; unset: not known.
  /// \param up_W    Normal of the ground.
  /// \param seen    Gets a reason while the object rises.
  std::optional<perception::PartnerEvent> update(hal::Timestamp at,
                                                 const std::optional<perception::ObjectMotion>& motion,
                                                 const hal::Vec3& up_W, perception::PartnerObservation& seen,
                                                 perception::PartnerTracker& tracker);

  /// The object does not stand as it did: what is seen of its edge is nearer than it was, like a hand.
  [[nodiscard]] bool moves() const { return raised_end_.moves(); }

  /// His body stands before that place. Of a hand that was never seen no pixels are known that could show
  /// that it is gone.
  [[nodiscard]] bool hides(const perception::PartnerObservation& seen,
                           const std::optional<perception::PartnerGrasp>& grasp) const;

  /// The robot comes back from an attempt: whoever still stands there need not raise the object again.
  void forget_motion();
  /// There is another scene: nobody stands where he stood.
  void forget_place() { before_.reset(); }

 private:
  std::optional<perception::PartnerEvent> raised(hal::Timestamp at, const perception::ObjectMotion& motion,
                                                 const hal::Vec3& up_W, perception::PartnerObservation& seen,
                                                 perception::PartnerTracker& tracker);
  std::optional<perception::PartnerEvent> still_there(hal::Timestamp at,
                                                      const perception::PartnerObservation& seen,
                                                      perception::PartnerTracker& tracker);

  perception::RaisedEnd raised_end_;
  double max_shift_m_, dwell_s_;
  std::optional<perception::PartnerGrasp> behind_body_;  ///< Where a hand may be that was not seen.
  /// Where he held it before the robot did something else; since when he stands there again, or does not.
  std::optional<perception::PartnerGrasp> before_;
  std::optional<hal::Timestamp> there_since_, away_since_;
};

}  // namespace colift::control
