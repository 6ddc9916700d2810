#include "tools/cli/session.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "tools/cli/numbers.hpp"

namespace colift::tools {

hal::Result<Setup> load_setup(const hal::Result<control::ResolvedConfig>& resolved) {
  if (!resolved) return tl::unexpected(resolved.error());
  Setup setup{*resolved, {}, {}, {}};
  if (!setup.config.hand_file.empty()) {
    auto hand = planner::load_hand(setup.config.hand_file);
    if (!hand) return tl::unexpected(hand.error());
    setup.hand = std::move(*hand);
  }
  if (!setup.config.calibration_file.empty()) {
    auto calibration = perception::load_calibration(setup.config.calibration_file, setup.config.calibration);
    if (!calibration) return tl::unexpected(calibration.error());
    setup.calibration = std::move(*calibration);
  }
  setup.hand_tables = std::make_shared<planner::HandCollision>(setup.hand, setup.config.candidates.collision);
  return setup;
}

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

  auto analysis = control::analyse_scene(std::move(input), setup.method, setup.config, setup.hand, hal::SteadyClock(),
                            setup.hand_tables);
  if (!analysis) return tl::unexpected(analysis.error());
  seen.analysis = std::move(*analysis);
  return seen;
}

int report_error(const char* command, const hal::Error& error) {
  std::fputs(fmt::format("colift {}: {}\n", command, error.text()).c_str(), stderr);
  using hal::ErrorCode;
  switch (error.code) {
    case ErrorCode::BadConfig:
    case ErrorCode::BadInput:
      return kBadInput;
    case ErrorCode::NotFound:
      return kNoGoal;
    case ErrorCode::Timeout:
    case ErrorCode::LinkLost:
    case ErrorCode::BadReply:
    case ErrorCode::DeviceFault:
      return kDeviceFailed;
    case ErrorCode::LimitExceeded:
    case ErrorCode::NotReady:
      return kInternal;
  }
  return kInternal;
}

}  // namespace colift::tools
