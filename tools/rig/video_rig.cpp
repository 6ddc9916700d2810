#include "tools/rig/video_rig.hpp"

#include <fmt/format.h>

#include "hal/drivers/recorded/camera_file.hpp"
#include "hal/drivers/v4l2_camera/v4l2_camera.hpp"
#include "hal/os/video_kernel.hpp"

namespace colift::tools {

hal::Result<hal::v4l2::DepthModel> depth_model(const hal::V4l2CameraConfig& config) {
  const auto wrong = [](std::string what) {
    return hal::failure(hal::ErrorCode::BadConfig, "v4l2.intrinsics", std::move(what));
  };
  if (config.intrinsics.empty())
    return wrong("names no file; expected the camera.json of this camera at this size (docs/bring-up.md)");
  const auto bytes = hal::load_file(config.intrinsics);
  if (!bytes) return wrong(bytes.error().text());
  const auto file = hal::parse_camera_json(*bytes, config.intrinsics);
  if (!file) return wrong(file.error().text());
  if (!file->width || !file->height)
    return wrong(
        fmt::format("{} has no width and height; they are what the device is asked for", config.intrinsics));
  hal::v4l2::DepthModel model;
  model.intrinsics = file->intrinsics(*file->width, *file->height);
  model.lens = file->lens;
  model.unit_m = config.depth_unit_m > 0.0 ? config.depth_unit_m : file->depth_scale_m;
  if (auto ok = hal::v4l2::check(model); !ok) return tl::unexpected(ok.error());
  return model;
}

hal::Result<std::unique_ptr<hal::DepthCamera>> make_video_camera(const hal::V4l2CameraConfig& config,
                                                                 const hal::Clock& clock) {
  const auto model = depth_model(config);
  if (!model) return tl::unexpected(model.error());
  return std::make_unique<hal::V4l2Camera>(config, *model, hal::make_video_kernel(), clock);
}

}  // namespace colift::tools
