#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/recorded/cloud_files/point_file.hpp"
#include "hal/types/result.hpp"

namespace colift::hal {

/// One recorded frame, whatever kind of file it came from. Points of the depth image in the file's own frame
/// F are X_FC * (points in the optical frame C).
struct RecordedFrame {
  DepthFrame frame;
  Pose X_FC = Pose::Identity();
  std::size_t points = 0;        ///< Pixels of the image or points of the file, with data or without.
  std::size_t valid_points = 0;  ///< Those with data.
  bool organised = true;         ///< False when the points had no image order and a virtual camera drew them.
  std::string note;              ///< What was done to make a depth image of the file, in words.
};

/// Reads a 16-bit depth PNG, a PCD or a PLY file. What the file is, its content says; an extension .png, .pcd
/// or .ply that says otherwise is refused. A PNG needs a camera: `camera_json`, or camera.json beside it. An
/// organised cloud becomes the depth image that it was; other points are drawn by a virtual camera
/// (hal/drivers/recorded/virtual_camera.hpp). Errors: BadInput with the file and the place in it.
[[nodiscard]] Result<RecordedFrame> read_frame(
    const std::filesystem::path& file,
    const std::optional<std::filesystem::path>& camera_json = std::nullopt);

/// The same for points that are already in memory; `name` stands in error messages.
[[nodiscard]] Result<RecordedFrame> frame_from_points(const PointFile& file, const std::string& name);

}  // namespace colift::hal
