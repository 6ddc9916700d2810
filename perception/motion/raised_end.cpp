#include "perception/motion/raised_end.hpp"

#include <algorithm>
#include <cmath>

namespace colift::perception {
namespace {

constexpr int kMaxBaseFrames = 30;  // a second: what drifts slower is no hand
// What the view does not hold stays where it was, so a frame's deviation is far above what it scatters; the
// scatter alone would not see that all points share an error.
constexpr double kSharedPart = 0.25;
constexpr double kMaxUnsettled_s = 1.0;  // so long what is half a rise may be one
constexpr double kMaxRaised_s = 10.0;    // what stays up for longer stands so, or was not raised

}  // namespace

void RaisedEnd::add_to_base(double rise_m) {
  frames_ = std::min(frames_ + 1, kMaxBaseFrames);
  const double d = rise_m - base_m_;
  base_m_ += d / frames_;
  variance_m2_ += (d * d - variance_m2_) / frames_;
}

std::optional<RaisedEnd::Grasp> RaisedEnd::update(hal::Timestamp at, const PartnerGrasp& hidden,
                                                  const ObjectMotion& motion, const Vec3& up_W) {
  const double rise_m = motion.rise(hidden.position, up_W);
  if (frames_ < config_.base_frames) {
    add_to_base(rise_m);
    return std::nullopt;
  }
  rise_m_ = rise_m - base_m_;
  const double sigma_m =
      std::max(std::sqrt(variance_m2_), kSharedPart * motion.rise_sigma(hidden.position, up_W));
  const double limit_m = std::max(config_.min_rise_m, config_.min_sigmas * sigma_m);
  // what is below half of it may be noise that changes with his body's outline
  moves_ = rise_m_ >= 0.5 * (raised() ? highest_m_ : limit_m);
  if (rise_m_ >= limit_m && !raised()) {
    add_high_frame(hidden);
    raised_at_ = at;
    return std::nullopt;
  }
  if (!raised()) {
    high_frames_ = 0;
    if (moves_ && !unsettled_since_) unsettled_since_ = at;
    if (moves_ && hal::seconds(at - *unsettled_since_) < kMaxUnsettled_s) return std::nullopt;
    if (!moves_) unsettled_since_.reset();
    add_to_base(rise_m);
    return std::nullopt;
  }
  if (hal::seconds(at - raised_at_) > kMaxRaised_s) {
    forget();
    return std::nullopt;
  }
  if (moves_) {
    add_high_frame(hidden);
    return std::nullopt;
  }
  if (!stands_since_) stands_since_ = at;
  if (hal::seconds(at - *stands_since_) < config_.rest_s) return std::nullopt;
  Grasp out{grasp_, highest_m_};
  forget();
  return out;
}

void RaisedEnd::add_high_frame(const PartnerGrasp& hidden) {
  stands_since_.reset();
  if (high_frames_ == 0) grasp_ = hidden;
  ++high_frames_;
  grasp_.position += (hidden.position - grasp_.position) / high_frames_;
  grasp_.covariance += (hidden.covariance - grasp_.covariance) / high_frames_;
  if (high_frames_ >= config_.frames) highest_m_ = std::max(highest_m_, rise_m_);
}

}  // namespace colift::perception
