#include "control/task/lift_evidence.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace colift::control {
void LiftEvidence::start_lift() {
  seen_ = cycles_ = 0;
  load_n_ = 0.0;
  best_ = {};
  stands_ = false;
  hand_at_end_.reset();
}

void LiftEvidence::update() {
  if (c_.arm.view().height_m < config_.top_fraction * c_.config.task.lift_height_m) return;
  ++cycles_;
  load_n_ += c_.arm.view().load_n;
  if (!c_.readings.frame || !object_.motion()) return;
  last_[static_cast<std::size_t>(seen_ % kMean)] = {
      object_.motion()->rise(object_.X_WH_grip().translation(), hal::Vec3::UnitZ()),
      object_.partner_rise_m()};
  ++seen_;
  // the partner may come later than the robot: a third of a second counts, not the mean of all
  const int n = std::min(seen_, kMean);
  Ends mean;
  for (int i = 0; i < n; ++i) {
    mean.robot_m += last_[static_cast<std::size_t>(i)].robot_m / n;
    mean.partner_m += last_[static_cast<std::size_t>(i)].partner_m / n;
  }
  const auto lower = [](const Ends& e) { return std::min(e.robot_m, e.partner_m); };
  if (n < kMean || lower(mean) > lower(best_)) best_ = mean;
}

void LiftEvidence::standing() {
  stands_ = true;
  hand_at_end_ = partner_.hand_seen();
}

std::string LiftEvidence::against() const {
  if (cycles_ == 0) return "not lifted: it was never held at its height";
  if (seen_ == 0) return "not known whether it was lifted: no picture of the object while it was held";
  const double wanted_m = config_.min_rise_fraction * c_.config.task.lift_height_m;
  if (best_.robot_m < wanted_m || best_.partner_m < wanted_m)
    return fmt::format(
        "not lifted: the robot's end was seen {:.0f} mm up, the partner's {:.0f} mm, of {:.0f}",
        1e3 * best_.robot_m, 1e3 * best_.partner_m, 1e3 * c_.config.task.lift_height_m);
  if (load_n_ / cycles_ < config_.min_load_n)
    return fmt::format("not known whether it was lifted: the hand carried {:.1f} N", load_n_ / cycles_);
  if (!stands_) return "not known whether the object stands";
  if (hand_at_end_ && !*hand_at_end_) return "the partner did not hold to the end of lowering";
  return {};
}

}  // namespace colift::control
