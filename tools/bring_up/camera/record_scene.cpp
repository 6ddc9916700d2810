#include "tools/bring_up/camera/record_scene.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <thread>

#include "tools/bring_up/bring_up.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/cli/wait_for_person.hpp"
#include "tools/scenes/cmd_scene.hpp"
#include "tools/scenes/depth_file.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;

constexpr double kStill_s = 1.5;  // of each step before the lift
constexpr int kStillImages = 5, kLiftImages = 10;
constexpr double kNoImage_s = 3.0;

const char* what_to_do(SceneStep step) {
  switch (step) {
    case SceneStep::Empty:
      return "leave the place empty: no object, nobody in view; camera and room stay as they are from now on";
    case SceneStep::Object:
      return "put the object down and leave the view";
    case SceneStep::Hand:
      return "take hold of the object where the camera sees your hand, and keep still";
    case SceneStep::Lift:
      return "lift it slowly by some centimetres, and keep it there";
  }
  return "";
}

hal::Result<> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error && std::filesystem::is_directory(folder, error) && std::filesystem::is_empty(folder, error))
    return {};
  return hal::failure(
      hal::ErrorCode::BadInput, folder.string(),
      error ? "cannot be made a folder" : "holds something already; expected a new or empty folder");
}

/// The next image that was exposed at `from` or later. Errors: Timeout, and the camera's.
hal::Result<hal::DepthFrame> image_after(hal::DepthCamera& camera, const hal::Clock& clock,
                                         hal::Timestamp from) {
  const hal::Timestamp end = clock.now() + hal::duration_of(kNoImage_s);
  for (;;) {
    auto frame = camera.next_frame(100ms);
    if (frame && frame->exposed_at >= from) return frame;
    if (!frame && frame.error().code != hal::ErrorCode::Timeout) return frame;
    if (clock.now() > end)
      return hal::failure(hal::ErrorCode::Timeout, "camera",
                          fmt::format("no image for {:.0f} s", kNoImage_s));
  }
}

hal::Result<> check(const HalCameraOptions& o) {
  const auto bad = [](const char* option, std::string why) {
    return hal::failure(hal::ErrorCode::BadInput, option, std::move(why));
  };
  if (o.pause_s && !(*o.pause_s >= 0.0 && *o.pause_s <= 600.0)) return bad("--pause", "expected 0 to 600 s");
  if (o.lifted_m && !(std::abs(*o.lifted_m) <= 2.0)) return bad("--lifted", "expected metres, -2 to 2");
  if (o.hal.for_s && !(*o.hal.for_s >= 1.0 && *o.hal.for_s <= 60.0))
    return bad("--for", "the lift's duration: expected 1 to 60 s");
  return {};
}

hal::Result<SceneFile> record_steps(hal::DepthCamera& camera, const hal::Clock& clock,
                                    const SceneRequest& request, const AskStep& ask) {
  for (const auto step : {&hal::DepthCamera::configure, &hal::DepthCamera::activate})
    if (auto done = (camera.*step)(); !done) return tl::unexpected(done.error());
  SceneFile file{(request.folder / "").parent_path().filename().string(),
                 request.object,
                 request.camera,
                 request.licence,
                 request.lifted_m,
                 {},
                 {},
                 {}};
  for (const SceneStep step : kSceneSteps) {
    if (auto ready = ask(step, what_to_do(step)); !ready) return tl::unexpected(ready.error());
    const bool lift = step == SceneStep::Lift;
    const int images = lift ? kLiftImages : kStillImages;
    const double every_s = (lift ? request.lift_s : kStill_s) / (images - 1);
    const hal::Timestamp from = clock.now();
    for (int k = 0; k < images; ++k) {
      const auto frame = image_after(camera, clock, from + hal::duration_of(k * every_s));
      if (!frame) return tl::unexpected(frame.error());
      std::string name = fmt::format("{}_{}.png", to_string(step), k);
      if (auto done = write_depth(request.folder / name, *frame); !done) return tl::unexpected(done.error());
      file.images[static_cast<std::size_t>(step)].push_back(std::move(name));
    }
  }
  if (auto done = write_scene_file(request.folder, file); !done) return tl::unexpected(done.error());
  return file;
}

}  // namespace

hal::Result<SceneFile> record_scene(hal::DepthCamera& camera, const hal::Clock& clock,
                                    const SceneRequest& request, const AskStep& ask) {
  if (auto made = make_folder(request.folder); !made) return tl::unexpected(made.error());
  auto file = record_steps(camera, clock, request, ask);
  std::error_code ignored;
  if (!file) std::filesystem::remove_all(request.folder, ignored);  // a part of a scene is none
  return file;
}

int cmd_record_scene(const CommonOptions& common, const HalCameraOptions& o, const std::string& source,
                     const std::string& advice, hal::DepthCamera& camera, const hal::Clock& clock) {
  const char* const where = "hal camera record";
  if (auto good = check(o); !good) return report_error(where, good.error());
  const InterruptGuard signals;
  const SceneRequest request{o.folder, o.object, source, o.licence, o.lifted_m, o.hal.for_s.value_or(4.0)};
  const auto file = record_scene(camera, clock, request, [&](SceneStep step, const std::string& words) {
    std::fprintf(stderr, "%-7s %s%s\n", to_string(step), words.c_str(),
                 o.pause_s ? fmt::format(" ({:.0f} s)", *o.pause_s).c_str() : "; then press Enter");
    return wait_for_person(o.pause_s);
  });
  if (!file) {
    if (InterruptGuard::asked()) return kInterrupted;
    const auto code = file.error().code;
    if (code == hal::ErrorCode::BadInput || code == hal::ErrorCode::BadConfig)
      return report_error(where, file.error());
    report_failure("camera", o.hal.verb, file.error().text(), fmt::format("next: {}\n", advice));
    return kDeviceFailed;
  }
  const auto checked = check_recorded_scene(common, o.folder, "fast", o.folder / "scene.png");
  if (!checked) return report_error(where, checked.error());
  if (common.json)
    std::puts(scenes_document({*checked}).c_str());
  else
    std::fputs(scene_text(*checked).c_str(), stdout);
  std::fflush(stdout);
  if (!checked->reason.empty()) return kNoGoal;
  if (!common.quiet)
    std::fprintf(stderr, "recorded: %s; look at scene.png, then: colift scene %s\n", o.folder.c_str(),
                 o.folder.c_str());
  return kDone;
}

}  // namespace colift::tools
