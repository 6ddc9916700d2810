#pragma once

#include <optional>

#include "hal/config/range.hpp"
#include "hal/types/time.hpp"
#include "perception/motion/object_motion.hpp"
#include "perception/scene.hpp"

namespace colift::perception {

/// When an end of the object that rises behind somebody's body is held by him. SI units.
struct RaiseConfig {
  double min_rise_m = 0.003;
  double min_sigmas = 4.0;
  int frames = 3;
  int base_frames = 10;
  double rest_s = 0.3;
  double max_shift_m = 0.2;

  template <class Visitor>
  void visit(Visitor& v) {
    v("min_rise_m", min_rise_m, hal::Range{0.001, 0.1},
      "Min rise of the object's hidden edge that only a hand can cause (m) ...");
    v("min_sigmas", min_sigmas, hal::Range{1, 20}, "... and min rise in its standard deviations.");
    v("frames", frames, hal::Range{1, 100}, "Min number of consecutive frames that show it raised.");
    v("base_frames", base_frames, hal::Range{1, 100},
      "Number of frames with him before the object, before it rises, that tell how it stands.");
    v("rest_s", rest_s, hal::Range{0, 10}, "How long it has to stand again before he holds it (s).");
    v("max_shift_m", max_shift_m, hal::Range{0.01, 1},
      "Max distance between where his hand may be later and where it was estimated; beyond, he has left "
      "(m).");
  }
};

/// A grasp that no camera sees: somebody's body hides an edge of the object, the object rises there, and
/// stands again. A leg that bumps into it, or somebody who leans on it, moves it to the side or not at all.
class RaisedEnd {
 public:
  struct Grasp {
    PartnerGrasp grasp;  ///< Where the hand most likely is, with the covariance of that.
    double rise_m = 0.0;
  };

  explicit RaisedEnd(const RaiseConfig& config) : config_(config) {}

  /// A frame, measured at `at`, in which a body hides an edge. Set once, when the object stands again.
  ///
  /// \param hidden  Where a hand behind that body most likely is (HiddenEdge::grasp).
  /// \param motion  The object against the reference, in the same frame.
  /// \param up_W    Normal of the ground.
  std::optional<Grasp> update(hal::Timestamp at, const PartnerGrasp& hidden, const ObjectMotion& motion,
                              const Vec3& up_W);

  /// Nothing is hidden, or a hand is seen.
  void forget() { *this = RaisedEnd(config_); }

  /// How far the edge has risen in the last frame (m).
  [[nodiscard]] double rise_m() const { return rise_m_; }
  /// It does not stand as it did, by the last frame: what is seen of it is not what the reference shows.
  [[nodiscard]] bool moves() const { return moves_; }
  /// It was raised, and does not stand again yet.
  [[nodiscard]] bool raised() const { return highest_m_ > 0.0; }

 private:
  void add_to_base(double rise_m);
  void add_high_frame(const PartnerGrasp& hidden);

  RaiseConfig config_;
  int frames_ = 0;  ///< That tell how it stands.
  /// Mean and scatter of its rise in these: what the follower says of an object at rest.
  double base_m_ = 0.0, variance_m2_ = 0.0;
  double rise_m_ = 0.0, highest_m_ = 0.0;
  int high_frames_ = 0;
  bool moves_ = false;
  PartnerGrasp grasp_;  ///< Mean over the frames that showed it raised.
  std::optional<hal::Timestamp> stands_since_, unsettled_since_;
  hal::Timestamp raised_at_{0};
};

}  // namespace colift::perception
