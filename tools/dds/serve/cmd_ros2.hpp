#pragma once

#include "tools/cli/options.hpp"

namespace colift::tools {

struct Ros2ServeOptions {
  Ros2Options ros2;
  std::optional<int> count;  ///< Ends after so many answers; unset: when it is interrupted.
};

/// Answers requests for decisions of ROS 2 nodes. Exit codes: kDone after `count` answers, kInterrupted,
/// kBadInput.
int cmd_ros2(const CommonOptions& common, const Ros2ServeOptions& options);

}  // namespace colift::tools
