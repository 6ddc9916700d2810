#include "hal/drivers/openni2_camera/frame_gate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace colift::hal::openni2 {
namespace {

constexpr double kFits_s = 1.0;   // a delivery may be as late as that
constexpr double kAgree_s = 0.1;  // frames on a clock that was set, among themselves
constexpr double kAgreeFor_s = 0.3;
constexpr std::uint64_t kLargest_us = 3'000'000'000'000'000;  // 95 years: a sum with it does not overflow

}  // namespace

void FrameGate::forget() {
  delay_ = {};
  index_.reset();
  last_.reset();
  set_since_.reset();
}

FrameGate::Times FrameGate::accept(const Seen& frame) {
  last_ = frame;
  index_ = frame.index;  // also one that counts from the beginning again
  set_since_.reset();
  return delay_.note(frame.stamp, frame.arrived);
}

Result<FrameGate::Times> FrameGate::pass(std::uint64_t index, std::uint64_t stamp_us, Timestamp arrived,
                                         std::uint64_t unread) {
  const auto refuse = [](std::uint64_t& count, std::string why) {
    ++count;
    return failure(ErrorCode::BadReply, "openni2.stamp", std::move(why));
  };
  const std::uint64_t gap = index_ && index > *index_ ? index - *index_ - 1 : 0;
  if (gap > unread) counts_.skipped += gap - unread;
  index_ = std::max(index_.value_or(0), index);
  if (stamp_us > kLargest_us)
    return refuse(counts_.misdated, fmt::format("a time stamp of {} us, which no device reaches", stamp_us));
  const Seen frame{index, Timestamp(static_cast<std::int64_t>(stamp_us) * 1000), arrived};
  // how much more the device's clock has gone on than the robot's
  const auto ahead_s = [&](const Seen& since) {
    return seconds(frame.stamp - since.stamp) - seconds(frame.arrived - since.arrived);
  };
  Times times;
  if (!last_) {
    times = accept(frame);
  } else if (const double off_s = ahead_s(*last_); std::abs(off_s) <= kFits_s) {
    if (frame.index == last_->index)
      return refuse(counts_.duplicate, fmt::format("frame {} came twice", frame.index));
    if (frame.stamp <= last_->stamp)
      return refuse(counts_.old, fmt::format("a frame {:.1f} ms older than the one before",
                                             1e3 * seconds(last_->stamp - frame.stamp)));
    times = accept(frame);
  } else {
    if (!set_since_ || std::abs(ahead_s(*set_since_)) > kAgree_s) set_since_ = frame;
    if (seconds(frame.arrived - set_since_->arrived) < kAgreeFor_s)
      return refuse(counts_.misdated,
                    fmt::format("a frame whose time stamp is {:.2f} s {} since the frame before",
                                std::abs(off_s), off_s > 0.0 ? "ahead" : "behind"));
    ++counts_.clock_set;
    delay_ = {};
    times = accept(frame);
  }
  // a process that was started anew, or a clock that was set, does not take the robot's time back
  if (exposed_ && times.exposed <= *exposed_)
    return refuse(counts_.old, fmt::format("a frame {:.1f} ms older than the one before",
                                           1e3 * seconds(*exposed_ - times.exposed)));
  exposed_ = times.exposed;
  return times;
}

}  // namespace colift::hal::openni2
