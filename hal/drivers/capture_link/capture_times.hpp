#pragma once

#include "hal/config/range.hpp"

namespace colift::hal::capture {

/// Deadlines of a capture process: the config struct of a camera derives from it.
struct CaptureTimes {
  double open_s = 6.0;
  double silent_s = 0.2;
  double heartbeat_s = 0.6;
  double frames_s = 3.0;
  double kill_s = 1.0;
  double first_pause_s = 0.25;
  double max_pause_s = 2.0;

 protected:
  template <class Visitor>
  void visit_times(Visitor& v) {
    constexpr Range kDeadline{0.05, 60.0};
    v("open_s", open_s, kDeadline, "Timeout from the start of the process to its first frame (s).");
    v("silent_s", silent_s, kDeadline, "Without a frame for this long the camera is lost (s).");
    v("heartbeat_s", heartbeat_s, kDeadline, "A process without sign of life for this long is ended (s).");
    v("frames_s", frames_s, kDeadline, "A process that lives but has no frames for this long is ended (s).");
    v("kill_s", kill_s, kDeadline, "A killed process that is still there after this is left alone (s).");
    v("first_pause_s", first_pause_s, kDeadline,
      "Pause before a process is started anew; grows by half (s).");
    v("max_pause_s", max_pause_s, kDeadline, "Longest such pause, and that without a device (s).");
  }
};

}  // namespace colift::hal::capture
