#pragma once

#include <cstdint>
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

/// A depth frame in the form "x-colift-depth" (docs/telemetry.md): a table of the distinct depths, as a
/// Kinect has at most 1090 of them, and for each pixel its place in the table, predicted from its neighbours
/// and split into bytes, so that a general compressor finds little left to store. Frames with more depths
/// than the table may hold are stored as their floats' bytes. Lossless to the bit, NaNs included.
[[nodiscard]] std::string encode_depth(const NumberedFrame& frame);

/// Errors: BadInput (damaged; a frame of no or more than 8192 x 8192 pixels).
[[nodiscard]] hal::Result<NumberedFrame> decode_depth(std::string_view bytes);

/// Only the frame's number. Errors: BadInput.
[[nodiscard]] hal::Result<std::uint64_t> depth_number(std::string_view bytes);

}  // namespace colift::telemetry
