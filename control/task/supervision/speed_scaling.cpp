#include "control/task/supervision/speed_scaling.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace colift::control {
// in the mean, so that what comes late counts, and what comes seldom
void SpeedScaling::update_image_age() {
  const SupervisionConfig& limits = c_.config.task.supervision;
  const double age_s = std::max(0.0, hal::seconds(c_.now - c_.readings.frame_at));
  const double passed_s = std::max(0.0, hal::seconds(c_.now - updated_at_));
  updated_at_ = c_.now;
  if (c_.readings.camera_lost) {  // more than old; what comes after it is judged anew
    image_age_s_ = 0.0;
    images_old_ = false;
    return;
  }
  image_age_s_ += (age_s - image_age_s_) * std::min(1.0, passed_s / limits.image_age_filter_s);
  if (image_age_s_ > limits.slow_image_age_s) images_old_ = true;
  if (image_age_s_ < limits.full_speed_image_age_s) images_old_ = false;
}

void SpeedScaling::update(const std::string& hand_warning) {
  update_image_age();
  std::string why;
  if (!hand_warning.empty())
    why = "the hand: " + hand_warning;
  else if (!is_moving(c_.state))
    why = "";  // nothing moves that could be slower
  else if (c_.readings.camera_lost && !next(c_.state, Event::CameraLost))  // where a rule stops it, it stops
    why = "no camera image: a person nearby cannot be observed";
  else if (c_.state == Task::TestLift && c_.test_lifts.said() == Raise::Slowly)
    why = "the object turns";
  else if (images_old_)
    why = fmt::format("the camera's pictures are {:.0f} ms old in the mean", 1e3 * image_age_s_);
  if (why.empty() == reason_.empty()) return;
  reason_ = std::move(why);
  c_.arm.go_slow(!reason_.empty());
}

}  // namespace colift::control
