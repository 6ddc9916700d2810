#include "tools/rig/openni2_rig.hpp"

#include <fmt/format.h>

#include <utility>

#include "hal/drivers/recorded/camera_file.hpp"

namespace colift::tools {

hal::Result<std::unique_ptr<hal::Openni2Camera>> make_openni2_camera(hal::Openni2CameraConfig config,
                                                                     const hal::Clock& clock) {
  const auto wrong = [](std::string what) {
    return hal::failure(hal::ErrorCode::BadConfig, "openni2.intrinsics", std::move(what));
  };
  std::optional<hal::openni2::PinholeModel> model;
  if (!config.intrinsics.empty()) {
    const auto bytes = hal::load_file(config.intrinsics);
    if (!bytes) return wrong(bytes.error().text());
    const auto file = hal::parse_camera_json(*bytes, config.intrinsics);
    if (!file) return wrong(file.error().text());
    if (!file->width || !file->height)
      return wrong(fmt::format("{} has no width and height; they are what the device is asked for",
                               config.intrinsics));
    model.emplace(hal::openni2::PinholeModel{file->intrinsics(*file->width, *file->height), file->lens});
    if (auto ok = check(*model); !ok) return tl::unexpected(ok.error());
    for (const auto& [asked, has] :
         {std::pair(&config.width, *file->width), {&config.height, *file->height}}) {
      if (*asked != 0 && *asked != has)
        return wrong(
            fmt::format("{} is of {} x {} pixels; expected those of openni2.width and height, {} x {}",
                        config.intrinsics, *file->width, *file->height, config.width, config.height));
      *asked = has;
    }
  }
  return std::make_unique<hal::Openni2Camera>(std::move(config), model, clock);
}

}  // namespace colift::tools
