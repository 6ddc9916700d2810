#include "tools/analyse/recorded_scene.hpp"

#include "tools/cli/numbers.hpp"

namespace colift::tools {

hal::Result<Seen> look_at_file(const LookOptions& options, const Setup& setup) {
  Seen seen;
  control::SceneAnalysisInput input;
  if (!options.camera_pose.empty()) {
    const auto pose = parse_pose(options.camera_pose, "--camera-pose");
    if (!pose) return tl::unexpected(pose.error());
    seen.X_WF = *pose;
    input.base_frame_known = true;
  } else if (setup.calibration) {
    seen.X_WF = setup.calibration->X_BC();
    input.base_frame_known = true;
  }
  if (!options.at.empty()) {
    if (setup.method == control::Method::Thesis)
      return hal::failure(hal::ErrorCode::BadInput, "--at",
                          "goes with --method fast: the thesis takes the largest cluster");
    const auto at = parse_point(options.at, "--at");
    if (!at) return tl::unexpected(at.error());
    input.at_W = *at;
  }
  auto file = hal::read_frame(options.cloud, options.camera);
  if (!file) return tl::unexpected(file.error());
  seen.file = std::move(*file);
  input.X_WC = seen.X_WF * seen.file.X_FC;
  input.frame = std::move(seen.file.frame);

  auto analysis = control::analyse_scene(std::move(input), setup.method, setup.config, setup.hand,
                                         hal::SteadyClock(), setup.hand_tables);
  if (!analysis) return tl::unexpected(analysis.error());
  seen.analysis = std::move(*analysis);
  return seen;
}

hal::Result<hal::DepthFrame> read_depth(const std::filesystem::path& file,
                                        const std::optional<std::filesystem::path>& camera) {
  auto read = hal::read_frame(file, camera);
  if (!read) return tl::unexpected(read.error());
  return std::move(read->frame);
}

}  // namespace colift::tools
