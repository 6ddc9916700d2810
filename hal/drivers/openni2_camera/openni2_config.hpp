#pragma once

#include <string>

#include "hal/config/range.hpp"
#include "hal/drivers/capture_link/capture_times.hpp"

namespace colift::hal {

/// A depth camera behind OpenNI2 and the process that reads it.
struct Openni2CameraConfig : capture::CaptureTimes {
  std::string source = "any";
  std::string library;
  std::string program;

  std::string intrinsics;
  int width = 0, height = 0;
  int rate_hz = 0;
  std::string unit = "any";
  double min_depth_m = 0.15, max_depth_m = 10.0;
  double latency_ms = 30.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("source", source,
      "Where frames come from: any for the first device, uri:URI, file:NAME.oni for a recording, "
      "emulated:ADDRESS for an emulator.");
    v("library", library,
      "Folder of another OpenNI2, with libOpenNI2.so.0 and its OpenNI2/Drivers, as a vendor ships it; empty: "
      "the distribution's.");
    v("program", program, "The capture process; empty: colift-openni2 beside this program.");
    v("intrinsics", intrinsics,
      "Its camera.json: fx, fy, cx, cy, width, height and, where there is any, distortion; empty: from the "
      "field of view that the device reports.");
    v("width", width, Range{0, 4096}, "Of the image (px); 0: 640 where the device has it, else the nearest.");
    v("height", height, Range{0, 4096}, "The same down the image (px); 0: 480, likewise.");
    v("rate_hz", rate_hz, Range{0, 300}, "Images a second (Hz); 0: 30 where the device has it.");
    v("unit", unit, Choices{"any", "1mm", "100um"},
      "Depth of one unit of the image; any: 1mm where the device has it. 100um ends at 6.5 m.");
    v("min_depth_m", min_depth_m, Range{0.0, 5.0}, "Nearer pixels count as not measured (m).");
    v("max_depth_m", max_depth_m, Range{0.5, 29.0}, "Farther pixels count as not measured (m).");
    v("latency_ms", latency_ms, Range{0, 500},
      "From the exposure to the quickest delivery; to be measured (ms).");
    visit_times(v);
  }
};

}  // namespace colift::hal
