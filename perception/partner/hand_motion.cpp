#include "perception/partner/hand_motion.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
void HandMotion::update(const HandSighting& sighting) {
  if (frames_ == 0) {
    mean_m_ = sighting.centroid_m;
    mean_m2_ = sighting.motion_area_m2;
  }
  score_before_ = score_;
  score_ = 0.0;
  if (mean_m2_ < config_.min_area_m2) {
    frames_ = sighting.motion_area_m2 < config_.min_area_m2 ? 1 : 0;
    mean_m2_ = sighting.motion_area_m2;
    return;
  }
  const double fraction = sighting.motion_area_m2 / mean_m2_;
  // of nothing there is no centroid
  distance_m_ = sighting.motion_area_m2 > 0.0 ? (sighting.centroid_m - mean_m_).norm() : distance_m_;
  const double sigma_m = std::max(config_.motion_floor_m, std::sqrt(variance_m2_));
  const double sigma_fraction = std::max(config_.motion_floor_fraction, std::sqrt(variance_of_fraction_));
  const double score = std::hypot(distance_m_ / sigma_m, std::max(0.0, 1.0 - fraction) / sigma_fraction);
  if (frames_ >= config_.motion_frames && fraction < config_.motion_max_growth) score_ = score;
  if (score < config_.motion_usual_sigmas || frames_ < config_.motion_frames) {
    variance_m2_ += config_.motion_variance_gain * (distance_m_ * distance_m_ - variance_m2_);
    variance_of_fraction_ +=
        config_.motion_variance_gain * ((1.0 - fraction) * (1.0 - fraction) - variance_of_fraction_);
  }
  const double part = std::max(config_.motion_gain, 1.0 / (frames_ + 1));
  if (sighting.motion_area_m2 > 0.0) mean_m_ += part * (sighting.centroid_m - mean_m_);
  mean_m2_ += part * (sighting.motion_area_m2 - mean_m2_);
  ++frames_;
}

bool HandMotion::leaves() const {
  return score_ >= config_.motion_sigmas || std::min(score_, score_before_) >= config_.motion_sigmas_twice;
}

}  // namespace colift::perception
