#include "tools/bring_up/camera/openni2_command.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

#include "tools/bring_up/bring_up.hpp"
#include "tools/bring_up/camera/depth_camera_watch.hpp"
#include "tools/bring_up/camera/record_scene.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/openni2_rig.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;

constexpr std::string_view kPrefix = "openni2:";
constexpr auto kWhole = 10s;  // for OpenNI2 to write the end of a recording

std::string advice_for(const std::string& source) {
  if (source.starts_with("emulated:"))
    return "is the emulator there? colift emulate camera --live prints the address that belongs behind "
           "\"emulated:\"";
  if (source.starts_with("file:"))
    return "a recording is a file that OpenNI2 wrote: colift hal camera record NAME.oni, NiViewer2";
  return "colift doctor --robot FILE names the devices that OpenNI2 finds; its drivers are the files "
         "lib*.so.0 in OpenNI2/Drivers beside libOpenNI2.so.0";
}

}  // namespace

std::optional<hal::Openni2CameraConfig> openni2_of(const HalCameraOptions& o) {
  const bool named = o.source.starts_with(kPrefix);
  hal::Openni2CameraConfig config;
  if (o.hal.robot) {
    const auto file = read_robot_file(o.hal.robot);
    if (!file || (file->camera != "openni2" && !named)) return std::nullopt;
    config = file->openni2;
  } else if (!named) {
    return std::nullopt;
  }
  if (!o.source.empty()) config.source = named ? o.source.substr(kPrefix.size()) : o.source;
  return config;
}

int openni2_command(const CommonOptions& common, const HalCameraOptions& o,
                    const hal::Openni2CameraConfig& config, double for_s,
                    const perception::NoiseModel& configured) {
  const std::string where = fmt::format("hal camera {}", o.hal.verb);
  const hal::SteadyClock clock;
  auto made = make_openni2_camera(config, clock);
  if (!made) return report_error(where.c_str(), made.error());
  hal::Openni2Camera& camera = **made;
  const std::string source = "openni2 " + config.source, advice = advice_for(config.source);
  if (o.scene) return cmd_record_scene(common, o, source, advice, camera, clock);
  const bool records = o.hal.verb == "record";
  if (records) {
    std::error_code none;
    if (o.folder.extension() != ".oni" || std::filesystem::exists(o.folder, none))
      return report_error(where.c_str(), {hal::ErrorCode::BadInput, o.folder.string(),
                                          "expected the name of a new recording, NAME.oni"});
    camera.record_to(o.folder);
  }
  const int code = watch_depth_camera(common, o, {camera, source, advice, [&] { return camera.report(); }},
                                      clock, for_s, configured);
  if (!records || (code != kDone && code != kInterrupted)) return code;
  if (auto whole = camera.finish_recording(kWhole); !whole) {
    report_failure("camera", o.hal.verb, whole.error().text(), std::nullopt);
    return kDeviceFailed;
  }
  std::error_code none;
  if (!common.quiet)
    std::fprintf(stderr, "recorded: %s, %.1f MB\n", o.folder.c_str(),
                 static_cast<double>(std::filesystem::file_size(o.folder, none)) / 1e6);
  return code;
}

}  // namespace colift::tools
