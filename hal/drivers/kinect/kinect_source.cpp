#include "hal/drivers/kinect/kinect_source.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <optional>
#include <vector>

#include "hal/drivers/capture_link/beside_program.hpp"

#ifndef COLIFT_FAKENECT_LIBRARY
#define COLIFT_FAKENECT_LIBRARY ""
#endif

namespace colift::hal::kinect {
namespace {

namespace fs = std::filesystem;

constexpr auto kProgram = "colift-kinect";
constexpr auto kEmulated = "libcolift-freenect.so";

tl::unexpected<Error> bad(std::string reason) {
  return failure(ErrorCode::BadConfig, "kinect.source", std::move(reason));
}

std::optional<std::string> first_of(const std::vector<fs::path>& places) {
  std::error_code none;
  for (const fs::path& p : places)
    if (!p.empty() && fs::is_regular_file(p, none)) return p.string();
  return std::nullopt;
}

/// Where a distribution may have it, when this program was built on another machine.
std::vector<fs::path> fakenect_places() {
  std::vector<fs::path> places{COLIFT_FAKENECT_LIBRARY};
  std::error_code none;
  for (const auto& folder : fs::directory_iterator("/usr/lib", none))
    if (folder.is_directory(none)) places.push_back(folder.path() / "fakenect/libfreenect.so.0.5");
  return places;
}

Result<capture::CaptureCall> call_of(const KinectConfig& config) {
  capture::CaptureCall call;
  if (config.program.empty()) {
    const auto found = first_of({fs::path(capture::own_folder()) / kProgram});
    if (!found)
      return bad(fmt::format("{} is not beside this program ({}): was it built with -DCOLIFT_KINECT=OFF?",
                             kProgram, capture::own_folder()));
    call.program = *found;
  } else {
    if (!first_of({config.program})) return bad(fmt::format("program {} is not there", config.program));
    call.program = config.program;
  }
  if (config.motor) call.arguments.emplace_back("--motor");
  return call;
}

}  // namespace

Result<KinectSource> kinect_source(const KinectConfig& config) {
  auto call = call_of(config);
  if (!call) return tl::unexpected(call.error());
  KinectSource source;
  source.call = std::move(*call);
  const std::size_t colon = config.source.find(':');
  const std::string kind = config.source.substr(0, colon);
  source.what = colon == std::string::npos ? "" : config.source.substr(colon + 1);
  std::error_code none;
  if (kind == "usb" && (colon == std::string::npos || !source.what.empty())) {
    if (!source.what.empty()) {
      source.call.arguments.emplace_back("--serial");
      source.call.arguments.push_back(source.what);
    }
    return source;
  }
  if (kind == "fakenect" && !source.what.empty()) {
    source.kind = KinectSource::Kind::Fakenect;
    // the library ends the whole process without a word when it does not find its files
    if (!fs::is_regular_file(fs::path(source.what) / "INDEX.txt", none))
      return bad(fmt::format("{} is no fakenect recording: it has no INDEX.txt", source.what));
    const auto library = first_of(fakenect_places());
    if (!library) return bad("there is no fakenect library here: sudo apt install libfreenect0.5");
    source.call.environment = {fmt::format("FAKENECT_PATH={}", fs::absolute(source.what, none).string()),
                               fmt::format("LD_PRELOAD={}", *library)};
    return source;
  }
  if (kind == "emulated" && !source.what.empty()) {
    source.kind = KinectSource::Kind::Emulated;
    const fs::path here = capture::own_folder();
    const auto library = first_of({here / kEmulated, here / "../lib/colift" / kEmulated});
    if (!library)
      return bad(fmt::format("{} is neither in {} nor in ../lib/colift", kEmulated, here.string()));
    source.call.environment = {fmt::format("COLIFT_KINECT_EMULATOR={}", source.what),
                               fmt::format("LD_PRELOAD={}", *library)};
    return source;
  }
  return bad(fmt::format("\"{}\" is no source; expected usb, usb:SERIAL, fakenect:DIR or emulated:ADDRESS",
                         config.source));
}

}  // namespace colift::hal::kinect
