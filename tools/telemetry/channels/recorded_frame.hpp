#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"

namespace colift::telemetry {

/// A depth frame of a recording: every bit of it, and which one it was.
struct NumberedFrame {
  std::uint64_t number = 0;  ///< Counts the frames of the run from 0.
  hal::DepthFrame frame;
};

/// colift.CameraFrame: what an image does not say of a frame (number, camera model, gravity). Precedes the
/// frame's images in a recording.
[[nodiscard]] std::string frame_message(std::uint64_t number, const hal::DepthFrame& frame);

/// A frame as it lies in a recording: found there, not yet decoded.
struct EncodedFrame {
  std::uint64_t number = 0;
  std::string about;   ///< Message of /camera/frame; empty in old recordings.
  std::string colour;  ///< Message of /camera/color; empty where the camera has none.
  std::string depth;   ///< Message of /camera/depth.
};
/// Errors: BadInput (damaged; the parts disagree; a frame of no or more than 8192 x 8192 pixels).
[[nodiscard]] hal::Result<NumberedFrame> decode_frame(const EncodedFrame& encoded);

/// Joins the messages of a frame, given in the order of the file. A frame whose description is lost is left
/// out: its image alone does not say which frame it is.
class FrameJoiner {
 public:
  /// Of a message on /camera/frame, /camera/color or /camera/depth, or of /more_cameras: the whole frame,
  /// with its last message.
  [[nodiscard]] std::optional<EncodedFrame> add(std::string_view topic, std::string_view message);

 private:
  std::optional<EncodedFrame> next_, next_of_others_;
};

}  // namespace colift::telemetry
