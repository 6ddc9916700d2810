#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "hal/types/time.hpp"

namespace colift::telemetry {

// Images as ROS 2 has them: sensor_msgs/msg/Image in CDR (OMG's common data representation, little endian),
// which Foxglove and every ROS tool read. Lossless.

/// The type of these messages, as it stands in a recording: name, and definition in ROS's language
/// ("ros2msg").
inline constexpr const char* kImageType = "sensor_msgs/msg/Image";
[[nodiscard]] std::string image_definition();

/// Depth in whole millimetres, 16 bit (`16UC1`), 0 where there is none. A frame with a depth that is no whole
/// number of millimetres, as a Kinect has none, is written as floats in metres instead (`32FC1`), with its
/// NaNs. A frame with other than width x height pixels is one row of what it has.
[[nodiscard]] std::string depth_image(const hal::DepthFrame& frame);
/// The same of another camera: `frame_id` is its frame.
[[nodiscard]] std::string depth_image(const hal::DepthFrame& frame, std::string_view frame_id);
/// Its colour (`rgb8`; what is not three bytes for each pixel is one row of bytes, `8UC1`).
[[nodiscard]] std::string colour_image(const hal::DepthFrame& frame);

/// One of these messages, read. `data` lies in the message's bytes.
struct ImageView {
  hal::Timestamp stamp{0};
  std::uint32_t width = 0, height = 0, step = 0;
  std::string_view frame_id, encoding, data;
};
/// Errors: BadInput (cut, or big endian).
[[nodiscard]] hal::Result<ImageView> parse_image(std::string_view bytes);

/// Metres, NaN where there is none: what depth_image() was given, to the bit, but for a NaN's payload in
/// `16UC1`. Errors: BadInput (another encoding).
[[nodiscard]] hal::Result<std::vector<float>> depth_of(const ImageView& image);

}  // namespace colift::telemetry
