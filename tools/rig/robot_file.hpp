#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/drivers/barrett_can/hand_config.hpp"
#include "hal/drivers/kinect/kinect_config.hpp"
#include "hal/drivers/kuka_fri/fri_config.hpp"
#include "hal/drivers/openni2_camera/openni2_config.hpp"
#include "hal/drivers/ros2_camera/ros2_camera_config.hpp"
#include "hal/drivers/v4l2_camera/v4l2_camera_config.hpp"
#include "hal/types/result.hpp"

namespace colift::tools {

/// A camera beside the first, and how it is reached.
struct MoreCamera {
  std::string camera = "kinect";
  std::string calibration;
  hal::KinectConfig kinect;
  hal::Ros2CameraConfig ros2;
  hal::V4l2CameraConfig v4l2;
  hal::Openni2CameraConfig openni2;

  template <class Visitor>
  void visit(Visitor& v) {
    v("camera", camera, hal::Choices{"kinect", "ros2", "v4l2", "openni2"}, "Back end of the camera.");
    v("calibration", calibration, "Result of colift calibrate for this camera: where it is.");
    v("kinect", kinect, "How the Kinect is reached and treated; several on USB need their serial numbers.");
    v("ros2", ros2, "Where a camera with a driver for ROS 2 is found.");
    v("v4l2", v4l2, "The video device of a depth camera that the kernel serves.");
    v("openni2", openni2, "How a depth camera with a driver for OpenNI2 is reached and treated.");
  }
};

/// Which devices a rig has, and how they are reached: the file behind --robot.
struct RobotFile {
  std::string arm = "simulated", hand = "simulated", camera = "simulated";
  std::string model;
  std::string calibration;
  double arm_period_ms = 5.0;
  hal::FriConfig fri;
  hal::BarrettHandConfig barrett;
  hal::KinectConfig kinect;
  hal::Ros2CameraConfig ros2;
  hal::V4l2CameraConfig v4l2;
  hal::Openni2CameraConfig openni2;
  std::vector<MoreCamera> more_cameras;
  std::string emulator = "never";

  template <class Visitor>
  void visit(Visitor& v) {
    v("arm", arm, hal::Choices{"simulated", "fri"}, "Back end of the arm.");
    v("hand", hand, hal::Choices{"simulated", "barrett"}, "Back end of the hand.");
    v("camera", camera, hal::Choices{"simulated", "kinect", "ros2", "v4l2", "openni2"},
      "Back end of the camera.");
    v("model", model, "URDF of arm and hand; empty: the built-in LWR 4+ with BarrettHand.");
    v("calibration", calibration,
      "Result of colift calibrate: where the camera is; empty: as the configuration or the scenario says.");
    v("arm_period_ms", arm_period_ms, hal::Range{1, 20},
      "Time between two commands of the simulated arm (ms).");
    v("fri", fri, "How the KRC is reached and treated.");
    v("barrett", barrett, "How the BarrettHand is reached and treated.");
    v("kinect", kinect, "How the Kinect is reached and treated.");
    v("ros2", ros2, "Where a camera with a driver for ROS 2 is found.");
    v("v4l2", v4l2, "The video device of a depth camera that the kernel serves.");
    v("openni2", openni2, "How a depth camera with a driver for OpenNI2 is reached and treated.");
    v("more_cameras", more_cameras,
      "Other cameras that look at the same scene, up to three; those of a simulated or emulated rig stand in "
      "the scenario.");
    v("emulator", emulator, hal::Choices{"never", "always", "auto"},
      "The far ends of the wires, in this program, on the scenario's world, for machines without a robot; "
      "auto: unless colift emulate rig serves them in another program.");
  }
};

/// Reads the file; none: the simulated rig. A device may name its back end and how it is reached in one
/// group, `camera: {driver: ros2, image: /depth}` for `camera: ros2` and `ros2: {image: /depth}`. Errors:
/// BadConfig with the place.
[[nodiscard]] hal::Result<RobotFile> read_robot_file(const std::optional<std::filesystem::path>& file);

}  // namespace colift::tools
