#pragma once

#include <string>

#include "hal/config/range.hpp"

namespace colift::hal {

/// A depth camera behind a driver of ROS 2, and how it is reached.
struct Ros2CameraConfig {
  std::string image = "/camera/depth/image_rect_raw";
  std::string info = "/camera/depth/camera_info";
  std::string frame;
  std::string time = "system";
  int domain = -1;
  std::string interface = "lo";
  double open_s = 5.0;
  double silent_s = 0.3;
  double max_age_s = 0.3;
  double future_s = 0.01;

  template <class Visitor>
  void visit(Visitor& v) {
    v("image", image, "Topic of the depth image (sensor_msgs/Image, 16UC1 or 32FC1).");
    v("info", info, "Topic of its sensor_msgs/CameraInfo.");
    v("frame", frame, "Frame id that images have to have; empty: that of the first image.");
    v("time", time, Choices{"system", "clock"},
      "What stamps of images count from: system: the system's clock, which the camera's computer shares; "
      "clock: the topic /clock of a simulation.");
    v("domain", domain, Range{-1, 101}, "DDS domain; -1: ROS_DOMAIN_ID, else 0.");
    v("interface", interface, "Network interface; lo: this machine alone.");
    v("open_s", open_s, Range{0.1, 60.0}, "Timeout for the first frame (s).");
    v("silent_s", silent_s, Range{0.05, 60.0}, "Without a good frame for this long the camera is lost (s).");
    v("max_age_s", max_age_s, Range{0.01, 10.0}, "Images that are older when they come are dropped (s).");
    v("future_s", future_s, Range{0.0, 1.0}, "Images whose stamp is further ahead are dropped (s).");
  }
};

}  // namespace colift::hal
