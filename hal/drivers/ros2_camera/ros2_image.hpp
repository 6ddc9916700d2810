#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/lens.hpp"

namespace colift::hal::ros2 {

// Depth images and camera models of ROS 2, checked. Pure functions of untrusted values; views of the caller's
// memory.

/// sensor_msgs/Image.
struct ImageView {
  Timestamp stamp{0};  ///< ROS time.
  std::string_view frame_id, encoding;
  std::uint32_t width = 0, height = 0, step = 0;
  std::uint8_t is_bigendian = 0;
  std::span<const std::uint8_t> data;
};

/// sensor_msgs/CameraInfo.
struct InfoView {
  std::string_view frame_id, distortion_model;
  std::uint32_t width = 0, height = 0;
  std::span<const double> d;
  std::array<double, 9> k{};  ///< Row-major.
  std::uint32_t binning_x = 0, binning_y = 0;
  std::uint32_t roi_x = 0, roi_y = 0, roi_width = 0, roi_height = 0;
};

/// The camera as its driver describes it.
struct CameraModel {
  CameraIntrinsics intrinsics;
  LensDistortion lens;
  bool operator==(const CameraModel& other) const;
};

inline constexpr int kMinSide = 16, kMaxSide = 4096;  ///< Pixels.

/// Errors: BadReply with the figure that cannot be: size, focal length, principal point, skew, a distortion
/// model other than plumb_bob or rational_polynomial, a lens that maps two rays to one pixel, binning or a
/// region of interest.
[[nodiscard]] Result<CameraModel> model_of(const InfoView& info);

/// Depth in metres along Cz, NaN where there is none, of the pinhole camera (REP 118: 16UC1 in millimetres
/// with 0 for none, 32FC1 in metres). Errors: BadReply with what contradicts: size, encoding, step, length of
/// the data.
[[nodiscard]] Result<std::vector<float>> depth_of(const ImageView& image, const CameraModel& camera);

}  // namespace colift::hal::ros2
