#pragma once

#include "perception/partner/grasp_presence.hpp"

namespace colift::perception {

/// Whether a hand leaves its grasp, long before it is gone: centroid and visible area of what is at the
/// contact deviate from their recent means by many standard deviations, which are learned while he holds. A
/// place that flickers in the picture so needs a larger motion than a quiet one.
class HandMotion {
 public:
  explicit HandMotion(const PresenceConfig& config) : config_(config) {}

  /// Learns anew.
  void start() { *this = HandMotion(config_); }
  /// One frame.
  void update(const HandSighting& sighting);
  [[nodiscard]] bool leaves() const;
  /// Of the last frame, in standard deviations; 0 while too little is known.
  [[nodiscard]] double score() const { return score_; }
  /// Of the centroid against its mean (m).
  [[nodiscard]] double distance_m() const { return distance_m_; }

 private:
  PresenceConfig config_;
  hal::Vec3 mean_m_ = hal::Vec3::Zero();
  double mean_m2_ = 0.0;
  double variance_m2_ = 0.0, variance_of_fraction_ = 0.0;
  double score_ = 0.0, score_before_ = 0.0, distance_m_ = 0.0;
  int frames_ = 0;
};

}  // namespace colift::perception
