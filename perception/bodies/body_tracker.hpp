#pragma once

#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/types/time.hpp"
#include "perception/bodies/body_finder.hpp"

namespace colift::perception {

/// How bodies are followed from frame to frame. SI units.
struct BodyTrackConfig {
  double max_step_m = 0.4;
  double max_gap_s = 0.5;
  double velocity_filter_s = 0.15;
  double still_m_s = 0.05;
  int max_tracks = 16;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_step_m", max_step_m, hal::Range{0.01, 5},
      "Max distance between a body and where it was expected for it to be the same (m).");
    v("max_gap_s", max_gap_s, hal::Range{0.03, 10}, "A body that is not seen for longer is a new one (s).");
    v("velocity_filter_s", velocity_filter_s, hal::Range{0.01, 5}, "Time constant of its velocity (s).");
    v("still_m_s", still_m_s, hal::Range{0, 1}, "A slower body is at rest (m/s).");
    v("max_tracks", max_tracks, hal::Range{1, 100}, "Max number of bodies that are followed; the largest.");
  }
};

/// One body over time.
struct BodyTrack {
  int id = 0;
  hal::Vec3 center = hal::Vec3::Zero(), velocity_m_s = hal::Vec3::Zero();
  double sigma_m_s = 1.0;  ///< Standard deviation of the velocity, from how well it predicted.
  int frames = 0;          ///< In which it was seen.
  double still_s = 0.0;    ///< For so long it has been at rest.
  hal::Timestamp seen_at{0};
  double area_m2 = 0.0;
  double top_m = 0.0;  ///< Highest that it was ever seen (W); infinite once the image's upper border cut it.
};

/// Follows bodies over frames by their centres. One thread; does not allocate after the first calls.
class BodyTracker {
 public:
  explicit BodyTracker(const BodyTrackConfig& config = {});

  /// Bodies of one frame; returns a track for each, in their order; nothing for those beyond max_tracks.
  /// Valid until the next call.
  std::span<const BodyTrack> update(hal::Timestamp exposed_at, std::span<const Body> bodies);

 private:
  void follow(BodyTrack& track, hal::Timestamp at, const Body& body) const;
  static void see_top(BodyTrack& track, const Body& body);

  BodyTrackConfig config_;
  int next_id_ = 1;
  std::vector<BodyTrack> tracks_, now_;
  std::vector<std::uint8_t> taken_;
};

}  // namespace colift::perception
