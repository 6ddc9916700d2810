#include "tools/scenes/depth_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "perception/calibration/grey_png.hpp"
#include "tools/visualization/file_output.hpp"

namespace colift::tools {

hal::Result<> write_depth(const std::filesystem::path& png, const hal::DepthFrame& frame) {
  if (auto ready = picture::prepare_output(png); !ready) return ready;
  std::vector<std::uint16_t> mm;
  mm.reserve(frame.depth_m.size());
  for (const float z : frame.depth_m)
    mm.push_back(z > 0.0f && z < 65.0f ? static_cast<std::uint16_t>(std::lround(1000.0f * z)) : 0);
  const hal::CameraIntrinsics& k = frame.intrinsics;
  if (auto done = perception::write_grey_png(png, k.width, k.height, mm); !done) return done;
  const std::string camera = fmt::format(
      "{{\"width\": {}, \"height\": {}, \"fx\": {}, \"fy\": {}, \"cx\": {}, \"cy\": {}, "
      "\"depth_scale_m\": 0.001, \"invalid_depth\": 0}}\n",
      k.width, k.height, k.fx, k.fy, k.cx, k.cy);
  return picture::write_file(png.parent_path() / "camera.json",
                             {reinterpret_cast<const std::uint8_t*>(camera.data()), camera.size()});
}

}  // namespace colift::tools
