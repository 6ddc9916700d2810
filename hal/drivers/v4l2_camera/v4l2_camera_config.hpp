#pragma once

#include <string>

#include "hal/config/range.hpp"

namespace colift::hal {

/// A depth camera that the kernel serves as a video device, and what it cannot say of itself.
struct V4l2CameraConfig {
  std::string device = "/dev/video0";
  std::string intrinsics;
  double depth_unit_m = 0.0;
  double rate_hz = 30.0;
  double min_depth_m = 0.15, max_depth_m = 10.0;
  std::string time = "kernel";
  double latency_ms = 0.0;
  int buffers = 4;

  double open_s = 6.0;
  double silent_s = 0.2;
  double frames_s = 3.0;
  double max_age_s = 0.3;
  double future_s = 0.01;
  double first_pause_s = 0.25;
  double max_pause_s = 2.0;

  template <class Visitor>
  void visit(Visitor& v) {
    constexpr Range kDeadline{0.05, 60.0};
    v("device", device,
      "The video device that gives depth; a link under /dev/v4l/by-id stays the same after plugging.");
    v("intrinsics", intrinsics,
      "Its camera.json: fx, fy, cx, cy, width, height, depth_scale_m and, where there is any, distortion.");
    v("depth_unit_m", depth_unit_m, Range{0.0, 0.1},
      "Depth of one unit of the image (m); 0: depth_scale_m of the intrinsics.");
    v("rate_hz", rate_hz, Range{0.0, 300.0}, "Images a second that are asked for (Hz); 0: the device's own.");
    v("min_depth_m", min_depth_m, Range{0.0, 5.0}, "Nearer pixels count as not measured (m).");
    v("max_depth_m", max_depth_m, Range{0.5, 29.0}, "Farther pixels count as not measured (m).");
    v("time", time, Choices{"kernel", "arrival"},
      "When an image was taken: as the kernel stamped it, on its monotonic clock; or when it came, for a "
      "device whose stamps are none.");
    v("latency_ms", latency_ms, Range{0, 500},
      "From the exposure to that time (ms); to be measured, subtracted from it.");
    v("buffers", buffers, Range{2, 32}, "Images that the kernel may fill before one is read.");
    v("open_s", open_s, kDeadline, "Timeout for the first frame (s).");
    v("silent_s", silent_s, kDeadline, "Without a good frame for this long the camera is lost (s).");
    v("frames_s", frames_s, kDeadline, "A device without a good frame for this long is opened anew (s).");
    v("max_age_s", max_age_s, Range{0.01, 10.0}, "Images that are older when they come are dropped (s).");
    v("future_s", future_s, Range{0.0, 1.0}, "Images whose stamp is further ahead are dropped (s).");
    v("first_pause_s", first_pause_s, kDeadline, "Pause before a device is opened anew; grows by half (s).");
    v("max_pause_s", max_pause_s, kDeadline, "Longest such pause (s).");
  }
};

}  // namespace colift::hal
