#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>

#include "hal/config/range.hpp"
#include "hal/types/time.hpp"
#include "perception/partner/contact_cover.hpp"
#include "perception/partner/partner_grasp.hpp"

namespace colift::perception {

/// How long and how steadily a hand has to be seen before it counts as a grasp.
struct TrackerConfig {
  static constexpr int kMaxMovedFrames = 16;
  double dwell_s = 0.3;       ///< A touch becomes a grasp when it stays this long at one place.
  double rest_m = 0.012;      ///< A hand whose skin strays no farther than this from its mean rests.
  double let_go_s = 0.15;     ///< No contact for longer than this: let go. Shorter gaps are drop-outs.
  double unclear_s = 0.6;     ///< So long what touches there may look like a leg.
  double moved_m = 0.03;      ///< The hand is elsewhere when it is farther from its place than this ...
  double moved_sigmas = 3.0;  ///< ... and than this many standard deviations of the difference.
  int moved_frames = 2;       ///< Frames in a row that have to say so ...
  int moved_held_frames = 5;  ///< ... of a hand that held: what is seen of it may change from frame to frame.
  double common_error =
      0.6;  ///< Part of the covariance that all frames share, so that averaging does not shrink it.
  HiddenConfig hidden = {};
  double max_hidden_s = 60.0;    ///< So long a grasp that cannot be observed counts as one.
  double hidden_dwell_s = 0.5;   ///< A touch that was seen and then hidden for so long is a grasp.
  double hidden_sigma_m = 0.03;  ///< How far a hand may have slid along the object meanwhile.

  template <class Visitor>
  void visit(Visitor& v) {
    v("dwell_s", dwell_s, hal::Range{0.0, 10.0},
      "Min time for which a touch stays in one place to be a grasp (s).");
    v("rest_m", rest_m, hal::Range{0.0, 1.0},
      "Max movement of a hand at rest, during which its dwell counts (m).");
    v("let_go_s", let_go_s, hal::Range{0.0, 10.0},
      "Timeout without contact after which the partner has let go (s).");
    v("unclear_s", unclear_s, hal::Range{0.0, 10.0},
      "The same where something still touches the object at that place, but looks like a leg or a trunk: the "
      "body behind a hand (s).");
    v("moved_m", moved_m, hal::Range{0.0, 1.0}, "Min distance of a hand that has moved (m).");
    v("moved_sigmas", moved_sigmas, hal::Range{0.0, 20.0},
      "The same, in standard deviations of the difference.");
    v("moved_frames", moved_frames, hal::Range{1, kMaxMovedFrames},
      "Min number of consecutive frames that show the hand elsewhere ...");
    v("moved_held_frames", moved_held_frames, hal::Range{1, kMaxMovedFrames},
      "... after it held the object. Its rest counts from the first of them.");
    v("common_error", common_error, hal::kFraction,
      "Fraction of the covariance that is common to all frames, so that averaging does not reduce it.");
    v("hidden", hidden, "When the partner's body or the robot hides his contact from the camera.");
    v("max_hidden_s", max_hidden_s, hal::Range{0.0, 600.0},
      "Max time for which a grasp that is hidden from the camera still counts; 0: not at all (s).");
    v("hidden_dwell_s", hidden_dwell_s, hal::Range{0.0, 10.0},
      "Time after which a touch that was observed and is hidden since is a grasp (s).");
    v("hidden_sigma_m", hidden_sigma_m, hal::Range{0.0, 0.3},
      "Standard deviation that a grasp gains while it is hidden (m).");
  }
};

/// A change of the partner's grasp.
struct PartnerEvent {
  enum class Kind {
    Grasped,  ///< The partner holds the object; grasp() is where.
    Moved,    ///< He held it and now touches it elsewhere; a new dwell has begun.
    LetGo,    ///< He held it and does not any more.
  };
  Kind kind;
  hal::Timestamp at{0};
  std::string reason;  ///< In a person's words, with numbers.
};

/// Follows one partner over frames. Pure: its answers depend only on what it was handed, times included.
///
///   Away -- contact --> Touching -- dwell at one place --> Holding
///   Touching -- no contact, or elsewhere --> Away or a new dwell, without an event: it never was a grasp
///   Holding -- elsewhere --> Touching (Moved);  Holding -- no contact --> Away (LetGo)
///
/// A contact that his own body hides from the camera is neither seen nor gone: the state stays, for
/// max_hidden_s at most, with a larger covariance.
class PartnerTracker {
 public:
  enum class State { Away, Touching, Holding };

  explicit PartnerTracker(const TrackerConfig& config) : config_(config) {}

  /// A frame measured at `at`. A frame that is not newer than the last one is ignored.
  std::optional<PartnerEvent> update(hal::Timestamp at, const PartnerObservation& observation);

  /// A frame measured at `at` in which the contact is hidden (HandPixels::hidden()) and no other is seen.
  std::optional<PartnerEvent> update_hidden(hal::Timestamp at);

  /// He holds it where no camera sees: his body hides the place, and the object moved there (RaisedEnd).
  /// Ignored where he holds it already. A hand that is seen there later replaces the estimate.
  std::optional<PartnerEvent> hold_unseen(hal::Timestamp at, const PartnerGrasp& estimate,
                                          std::string reason);

  /// No frame came, and it is `now`: a camera that fell silent must not keep a grasp alive.
  std::optional<PartnerEvent> tick(hal::Timestamp now);

  /// Nobody looked for so long: that time does not count as a hand that was not seen.
  void looked_away(hal::Duration how_long) {
    last_contact_ += how_long;
    last_touch_ += how_long;
  }

  [[nodiscard]] State state() const { return state_; }

  /// The contact cannot be observed; what grasp() says is from before.
  [[nodiscard]] bool is_hidden() const { return hidden_since_.has_value(); }

  /// The contact was never observed (hold_unseen()).
  [[nodiscard]] bool is_unseen() const { return unseen_; }

  /// Filtered contact: recursive mean since the hand rests there. Set while Touching or Holding.
  [[nodiscard]] std::optional<PartnerGrasp> grasp() const;

  /// When the hand came to rest where it is. Meaningless while Away.
  [[nodiscard]] hal::Timestamp since() const { return since_; }

 private:
  void start(hal::Timestamp at, const PartnerGrasp& seen);
  void add(hal::Timestamp at, const PartnerGrasp& seen);
  void go_elsewhere(int frames);
  [[nodiscard]] bool strays(const PartnerGrasp& seen) const;
  [[nodiscard]] bool elsewhere(const PartnerGrasp& seen) const;
  /// For how long nothing has touched the object at the contact (s).
  [[nodiscard]] double untouched_s(hal::Timestamp now) const {
    return hal::seconds(now - std::max(last_contact_, last_touch_));
  }
  std::optional<PartnerEvent> lose_contact(hal::Timestamp at, const std::string& seen_instead);
  std::optional<PartnerEvent> confirm(hal::Timestamp at);

  TrackerConfig config_;
  State state_ = State::Away;
  std::optional<hal::Timestamp> last_frame_;
  hal::Timestamp since_{0}, last_contact_{0}, last_touch_{0};
  std::optional<hal::Timestamp> hidden_since_;
  bool unseen_ = false;
  int samples_ = 0;
  /// The frames in a row that show it elsewhere.
  struct Elsewhere {
    hal::Timestamp at{0};
    PartnerGrasp seen;
  };
  std::array<Elsewhere, TrackerConfig::kMaxMovedFrames> elsewhere_{};
  int elsewhere_in_a_row_ = 0;
  Vec3 mean_ = Vec3::Zero();
  Eigen::Matrix3d mean_covariance_ = Eigen::Matrix3d::Zero();
  std::size_t points_ = 0;
  std::optional<Vec3> skin_;  ///< Mean, as mean_.
};

}  // namespace colift::perception
