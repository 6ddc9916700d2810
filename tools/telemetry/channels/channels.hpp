#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "hal/types/time.hpp"

namespace colift::telemetry {

/// Everything that a run can be watched or recorded by. One description for both (channels()).
enum class Topic : std::uint8_t {
  Transforms,   ///< foxglove.FrameTransforms: every link of arm and hand, and the camera, in "world".
  Joints,       ///< foxglove.JointStates: arm and hand.
  Calibration,  ///< foxglove.CameraCalibration.
  Preview,      ///< foxglove.RawImage: depth in millimetres, half as wide and high, twice a second.
  Cloud,        ///< foxglove.PointCloud: every fourth pixel in both directions, once a second.
  Scene,        ///< foxglove.SceneUpdate: ground, target, surfaces, candidates, partner, grasp, path.
  Map,          ///< foxglove.SceneUpdate: the collision world's cells near the robot, once it is made.
  Bodies,       ///< foxglove.SceneUpdate: everybody near the arm, with distance and velocity.
  Log,          ///< foxglove.Log.
  Status,       ///< colift.TaskStatus, 30 a second.
  Intent,       ///< colift.Intent: what will move, before it does; requests to people.
  Change,       ///< colift.TaskChange, for each change of state.
  Decision,     ///< colift.Decision: the choice, and every candidate with its verdict.
  Plan,         ///< colift.Plan: the path's duration and its postures.
  Devices,      ///< colift.DeviceHealth: all devices, twice a second.
  Timing,       ///< colift.CycleTiming: the arm's cycle, ten times a second.
  Stages,       ///< colift.StageTiming: computing times, for each decision.
  Load,         ///< colift.Load: force and torque at the palm, share, height, tilt, slip.
  Tactile,      ///< colift.Tactile: every cell of the hand's tactile arrays, 20 a second where it has any.
  Truth,        ///< colift.Truth: what only a simulation knows.
  Tracked,  ///< foxglove.FrameTransforms: "object" and "partner" in "world", of each frame that shows them.
  Description,  ///< std_msgs/msg/String: the robot's URDF, once.
  Depth,        ///< sensor_msgs/msg/Image: the depth of every frame, lossless (image_message.hpp).
  Colour,       ///< sensor_msgs/msg/Image: its colour, where the camera has any.
  Frame,        ///< colift.CameraFrame: number, camera model and gravity of every frame (recorded_frame.hpp).
  MoreDepth,    ///< As Depth, of the cameras beside the first; its frame says which: "camera2" ...
  MoreFrame,    ///< As Frame, of these.
  Inputs,       ///< colift.CycleInputs: everything that the task was handed in one of its cycles, for replay.
};
inline constexpr int kTopics = static_cast<int>(Topic::Inputs) + 1;

/// How a topic is announced: in the file as an MCAP channel with its schema, live as a Foxglove channel.
struct ChannelInfo {
  Topic id = Topic::Log;
  std::string topic;            ///< "/task/status"
  std::string encoding;         ///< Of messages: "json", or "cdr" for those of ROS 2.
  std::string schema_name;      ///< "foxglove.Log"
  std::string schema_encoding;  ///< "jsonschema" or "ros2msg".
  std::string schema;
};

/// All of them, in the order of Topic.
[[nodiscard]] std::span<const ChannelInfo> channels();
[[nodiscard]] inline const ChannelInfo& channel_of(Topic topic) {
  return channels()[static_cast<std::size_t>(topic)];
}

/// What a message of this topic says holds until the next one, which may never come: whoever missed it would
/// miss it for the rest of the run.
[[nodiscard]] constexpr bool is_lasting(Topic topic) {
  switch (topic) {
    case Topic::Scene:
    case Topic::Map:
    case Topic::Change:
    case Topic::Decision:
    case Topic::Plan:
    case Topic::Stages:
    case Topic::Description:
      return true;
    default:
      return false;
  }
}

/// One message on its way to whoever wants it. It is made only then, and in that one's thread: `encode` owns
/// copies of all it needs and may be called any number of times.
struct Publication {
  Topic topic = Topic::Log;
  hal::Timestamp at{0};  ///< Of the robot's clock.
  std::function<std::string()> encode;
  std::size_t bytes = 1024;  ///< About how much memory it holds until it is encoded.
};

/// Whoever takes messages: the recorder, the live view, a test.
class TelemetrySink {
 public:
  virtual ~TelemetrySink() = default;
  /// From the task's thread. Must not wait for a disk or a network, unless the robot's time stands still
  /// meanwhile.
  virtual void publish(const Publication& publication) = 0;
};

}  // namespace colift::telemetry
