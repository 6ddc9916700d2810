#include "hal/drivers/openni2_camera/openni2_source.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

#include "hal/drivers/capture_link/beside_program.hpp"

namespace colift::hal::openni2 {
namespace {

namespace fs = std::filesystem;

constexpr auto kProgram = "colift-openni2";
constexpr auto kEmulated = "openni2-emulated";
constexpr auto kLibrary = "libOpenNI2.so.0";

tl::unexpected<Error> bad(std::string reason) {
  return failure(ErrorCode::BadConfig, "openni2.source", std::move(reason));
}

bool is_file(const fs::path& path) {
  std::error_code none;
  return fs::is_regular_file(path, none);
}

/// The library is taken from this folder, and with it its drivers.
std::string library_path(const fs::path& folder) {
  std::error_code none;
  const char* const before = std::getenv("LD_LIBRARY_PATH");
  return fmt::format("LD_LIBRARY_PATH={}{}", fs::absolute(folder, none).string(),
                     before == nullptr || *before == '\0' ? "" : fmt::format(":{}", before));
}

Result<capture::CaptureCall> call_of(const Openni2CameraConfig& config) {
  capture::CaptureCall call;
  const fs::path program =
      config.program.empty() ? fs::path(capture::own_folder()) / kProgram : fs::path(config.program);
  if (!is_file(program))
    return bad(
        config.program.empty()
            ? fmt::format("{} is not beside this program ({}): was it built with -DCOLIFT_OPENNI2=OFF?",
                          kProgram, capture::own_folder())
            : fmt::format("program {} is not there", config.program));
  call.program = program.string();
  const auto add = [&](const char* name, int value) {
    if (value == 0) return;
    call.arguments.emplace_back(name);
    call.arguments.push_back(std::to_string(value));
  };
  add("--width", config.width);
  add("--height", config.height);
  add("--rate", config.rate_hz);
  add("--unit-um", config.unit == "1mm" ? 1000 : config.unit == "100um" ? 100 : 0);
  if (config.library.empty()) return call;
  if (!is_file(fs::path(config.library) / kLibrary))
    return bad(fmt::format("library {} has no {}", config.library, kLibrary));
  call.environment.push_back(library_path(config.library));
  return call;
}

}  // namespace

Result<Source> find_source(const Openni2CameraConfig& config) {
  auto call = call_of(config);
  if (!call) return tl::unexpected(call.error());
  Source source;
  source.call = std::move(*call);
  const std::size_t colon = config.source.find(':');
  const std::string kind = config.source.substr(0, colon);
  const std::string what = colon == std::string::npos ? "" : config.source.substr(colon + 1);
  if (config.source == "any") return source;
  if (kind == "uri" && !what.empty()) {
    source.call.arguments.insert(source.call.arguments.end(), {"--device", what});
    return source;
  }
  if (kind == "file" && !what.empty()) {
    source.kind = Source::Kind::File;
    if (!is_file(what)) return bad(fmt::format("there is no recording {}", what));
    std::error_code none;
    source.call.arguments.insert(source.call.arguments.end(), {"--file", fs::absolute(what, none).string()});
    return source;
  }
  if (kind == "emulated" && !what.empty()) {
    source.kind = Source::Kind::Emulated;
    const fs::path here = capture::own_folder();
    for (const fs::path& folder : {here / kEmulated, here / "../lib/colift" / kEmulated}) {
      if (!is_file(folder / kLibrary)) continue;
      source.call.environment = {fmt::format("COLIFT_KINECT_EMULATOR={}", what), library_path(folder)};
      return source;
    }
    return bad(fmt::format("{} is neither in {} nor in ../lib/colift", kEmulated, here.string()));
  }
  return bad(fmt::format("\"{}\" is no source; expected any, uri:URI, file:NAME.oni or emulated:ADDRESS",
                         config.source));
}

}  // namespace colift::hal::openni2
