#pragma once

#include <string>

#include "hal/depth_camera.hpp"
#include "hal/drivers/recorded/cloud_files/point_file.hpp"

namespace colift::hal {

/// Unorganised points as one camera would see them.
struct VirtualView {
  DepthFrame frame;
  Pose X_FC = Pose::Identity();  ///< The virtual camera in the file's frame F.
  double visible = 0.0;          ///< Part of the finite points that the frame shows, 0 to 1.
  std::string note;              ///< Where the camera was put and why, for people.
};

/// Draws the points of a file into a depth image. The camera stands at the file's viewpoint or origin, along
/// the file's own z axis if the points look like an optical frame, else towards their middle. When the points
/// came from a pixel grid, that grid is found again; else about one point falls in a pixel. Nearest point
/// wins; single empty pixels between neighbours that agree are filled. At most 1280 x 960 pixels.
/// Deterministic. Errors: BadInput, when fewer than 60 % of the points can be seen (a map of several views),
/// when they surround the camera, lie in one plane with it, or are fewer than 200. `name` stands in error
/// messages.
[[nodiscard]] Result<VirtualView> view_points(const PointFile& file, const std::string& name);

}  // namespace colift::hal
