#include "tools/cli/session.hpp"

#include <fmt/format.h>

#include <cstdio>

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
    case ErrorCode::NotReady:
      return kDeviceFailed;
    case ErrorCode::LimitExceeded:
      return kInternal;
  }
  return kInternal;
}

}  // namespace colift::tools
