#pragma once

#include <string>

#include "hal/config/range.hpp"

namespace colift::hal {

/// The Kinect v1 and the process that reads it.
struct KinectConfig {
  std::string source = "usb";
  std::string program;
  bool motor = false;

  double fx = 575.8, fy = 575.8;
  double cx = 320.0, cy = 240.0;
  double latency_ms = 50.0;
  bool drop_suspect = true;
  int infrared_brightness = 0;

  double open_s = 6.0;
  double silent_s = 0.2;
  double heartbeat_s = 0.6;
  double frames_s = 3.0;
  double kill_s = 1.0;
  double first_pause_s = 0.25;
  double max_pause_s = 2.0;

  template <class Visitor>
  void visit(Visitor& v) {
    constexpr Range kDeadline{0.05, 60.0};
    v("source", source,
      "Where frames come from: usb, usb:SERIAL, fakenect:DIR for a recording, emulated:ADDRESS for an "
      "emulator.");
    v("program", program, "The capture process; empty: colift-kinect beside this program.");
    v("motor", motor,
      "Whether motor and accelerometer are used; models after the first need firmware for it.");
    v("fx", fx, Range{100, 2000}, "Focal length of the depth image (px); nominal 575.8.");
    v("fy", fy, Range{100, 2000}, "The same down the image (px).");
    v("cx", cx, Range{0, 640}, "Principal point (px).");
    v("cy", cy, Range{0, 480}, "The same down the image (px).");
    v("latency_ms", latency_ms, Range{0, 500},
      "From the exposure to the quickest delivery; to be measured (ms).");
    v("drop_suspect", drop_suspect, "Whether a frame with lost USB packets is dropped.");
    v("infrared_brightness", infrared_brightness, Range{0, 50},
      "Of infrared images, 1 to 50, as low as still shows the emitter; 0: as the device has it.");
    v("open_s", open_s, kDeadline, "Timeout from the start of the process to its first frame (s).");
    v("silent_s", silent_s, kDeadline, "Without a frame for this long the camera is lost (s).");
    v("heartbeat_s", heartbeat_s, kDeadline, "A process without sign of life for this long is ended (s).");
    v("frames_s", frames_s, kDeadline, "A process that lives but has no frames for this long is ended (s).");
    v("kill_s", kill_s, kDeadline, "A killed process that is still there after this is left alone (s).");
    v("first_pause_s", first_pause_s, kDeadline,
      "Pause before a process is started anew; grows by half (s).");
    v("max_pause_s", max_pause_s, kDeadline, "Longest such pause, and that without a device (s).");
    v.renamed("most_pause_s", "max_pause_s");
  }
};

}  // namespace colift::hal
