#include "tools/scenes/cmd_scene.hpp"

#include <algorithm>
#include <cstdio>

#include "tools/cli/config_of.hpp"
#include "tools/cli/session.hpp"

namespace colift::tools {
namespace {

namespace fs = std::filesystem;

/// The scenes in the folders that were named: each itself, or what is in it.
hal::Result<std::vector<fs::path>> scenes_in(const std::vector<fs::path>& folders) {
  std::vector<fs::path> scenes;
  for (const fs::path& folder : folders) {
    std::error_code error;
    if (fs::exists(folder / "scene.json", error)) {
      scenes.push_back(folder);
      continue;
    }
    const std::size_t before = scenes.size();
    for (const auto& entry : fs::directory_iterator(folder, error))
      if (fs::exists(entry.path() / "scene.json", error)) scenes.push_back(entry.path());
    if (scenes.size() == before)
      return hal::failure(hal::ErrorCode::BadInput, folder.string(),
                          "holds no recorded scene; colift hal camera record --scene FOLDER makes one");
    std::sort(scenes.begin() + static_cast<std::ptrdiff_t>(before), scenes.end());
  }
  return scenes;
}

}  // namespace

hal::Result<CheckedScene> check_recorded_scene(const CommonOptions& common, const fs::path& folder,
                                               const std::string& method,
                                               const std::optional<fs::path>& png) {
  auto scene = read_scene(folder);
  if (!scene) return tl::unexpected(scene.error());
  CheckedScene checked{folder, scene->file, {}, {}};
  std::vector<std::string> methods{method};
  if (method == "both") methods = {"fast", "thesis"};
  std::optional<SceneTruth> truth;
  for (const std::string& name : methods) {
    LookOptions look;
    look.method = name;
    const auto setup = load_setup(config_of_look(common, look));
    if (!setup) return tl::unexpected(setup.error());
    show_warnings("scene", common, *setup);
    if (!truth) {
      auto found = scene_truth(*scene, setup->config.noise);
      if (!found) {
        checked.reason = found.error().text();
        return checked;
      }
      truth = std::move(*found);
    }
    auto rows = check_scene(*scene, *truth, *setup);
    if (!rows) return tl::unexpected(rows.error());
    checked.rows.insert(checked.rows.end(), rows->begin(), rows->end());
  }
  if (png)
    if (auto written = scene_picture(*scene, *truth).write_png(*png); !written)
      return tl::unexpected(written.error());
  return checked;
}

int cmd_scene(const CommonOptions& common, const SceneOptions& options) {
  const auto folders = scenes_in(options.folders);
  if (!folders) return report_error("scene", folders.error());
  if (options.png && folders->size() != 1)
    return report_error("scene", {hal::ErrorCode::BadInput, "--png", "is for one scene"});
  std::vector<CheckedScene> all;
  for (const fs::path& folder : *folders) {
    auto checked = check_recorded_scene(common, folder, options.method, options.png);
    if (!checked) return report_error("scene", checked.error());
    if (!common.json && (!common.quiet || !checked->accepted()))
      std::fputs(scene_text(*checked).c_str(), stdout);
    all.push_back(std::move(*checked));
  }
  if (common.json) std::puts(scenes_document(all).c_str());
  const bool accepted =
      std::all_of(all.begin(), all.end(), [](const CheckedScene& c) { return c.accepted(); });
  if (!common.json && !common.quiet)
    std::puts(accepted ? "every answer is right, or known not to be" : "not every answer is right");
  std::fflush(stdout);
  return accepted ? kDone : kNoGoal;
}

}  // namespace colift::tools
