#pragma once

#include <string>

#include "hal/config/range.hpp"
#include "hal/drivers/capture_link/capture_times.hpp"

namespace colift::hal {

/// The Kinect v1 and the process that reads it.
struct KinectConfig : capture::CaptureTimes {
  std::string source = "usb";
  std::string program;
  bool motor = false;

  double fx = 575.8, fy = 575.8;
  double cx = 320.0, cy = 240.0;
  double latency_ms = 50.0;
  bool drop_suspect = true;
  int infrared_brightness = 0;

  template <class Visitor>
  void visit(Visitor& v) {
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
    visit_times(v);
    v.renamed("most_pause_s", "max_pause_s");
  }
};

}  // namespace colift::hal
