#pragma once

#include <array>
#include <cstddef>

#include "control/session/rig_view.hpp"
#include "hal/types/time.hpp"

namespace colift::control {

/// Where the robot was in the last second or so: a frame shows it as it was when the frame was exposed.
class PostureHistory {
 public:
  void add(hal::Timestamp at, const RobotPosture& posture) {
    past_[remembered_++ % past_.size()] = {at, posture};
  }
  /// Of the two remembered postures around a time, in between; the newest for a time after it, the oldest for
  /// one before. `now` where nothing is remembered.
  [[nodiscard]] RobotPosture at(hal::Timestamp at, const RobotPosture& now) const;

 private:
  struct Entry {
    hal::Timestamp at{0};
    RobotPosture posture;
  };
  std::array<Entry, 256> past_{};
  std::size_t remembered_ = 0;
};

}  // namespace colift::control
