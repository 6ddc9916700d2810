#pragma once

#include <fmt/format.h>

#include <optional>

#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::hal::v4l2 {

/// Lets the times of images through that can be: not in the future, not too old, each newer than the one
/// before. For .cpp files only.
class StampGate {
 public:
  StampGate(double max_age_s, double future_s) : max_age_s_(max_age_s), future_s_(future_s) {}

  /// When the light of an image was measured. One that lies ahead by no more than `future_s` is taken as of
  /// now. Errors: BadReply with the figure.
  [[nodiscard]] Result<Timestamp> pass(Timestamp stamp, Timestamp now) {
    const auto wrong = [](std::string what) {
      return failure(ErrorCode::BadReply, "v4l2.stamp", std::move(what));
    };
    const double age_s = seconds(now - stamp);
    if (age_s < -future_s_)
      return wrong(
          fmt::format("the stamp of an image lies {:.3f} s in the future (limit {} s)", -age_s, future_s_));
    if (age_s > max_age_s_)
      return wrong(fmt::format("an image is {:.3f} s old by its stamp (limit {} s)", age_s, max_age_s_));
    const Timestamp at = std::min(stamp, now);
    if (last_ && at <= *last_)
      return wrong(
          fmt::format("an image is {:.1f} ms older than the one before", 1e3 * seconds(*last_ - at)));
    last_ = at;
    return at;
  }

 private:
  double max_age_s_, future_s_;
  std::optional<Timestamp> last_;
};

}  // namespace colift::hal::v4l2
