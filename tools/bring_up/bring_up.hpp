#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "control/config/config.hpp"
#include "hal/types/result.hpp"
#include "tools/bring_up/cmd_hal.hpp"
#include "tools/bring_up/hal_screen.hpp"
#include "tools/rig/robot_file.hpp"

namespace colift::tools {

// What the bring-up commands of all devices have in common.

/// A device on a wire, as a robot file names it.
struct WiredDevice {
  const char* name;
  std::string RobotFile::*kind;
  const char* driver;  ///< What `kind` has to be.
};
inline constexpr WiredDevice kWiredArm{"arm", &RobotFile::arm, "fri"};
inline constexpr WiredDevice kWiredHand{"hand", &RobotFile::hand, "barrett"};
inline constexpr WiredDevice kWiredCamera{"camera", &RobotFile::camera, "kinect"};

/// The robot file of the call, or the drivers' defaults without one. Errors: BadConfig (the file, or its
/// device is not on a wire).
[[nodiscard]] hal::Result<RobotFile> read_wired(const HalOptions& options, const WiredDevice& device);

/// The configuration of a `hal` command, warnings of which are printed as of `command`. Errors: BadConfig
/// with the place.
[[nodiscard]] hal::Result<control::Config> read_config(const char* command, const CommonOptions& common);

/// Errors: BadInput (a time that is not more than 0).
[[nodiscard]] hal::Result<> check_time(const HalOptions& options);

/// Progress to stdout, or to stderr when stdout is for JSON; silent with --quiet and for a verb that only
/// prints once.
[[nodiscard]] LiveScreen progress_screen(const CommonOptions& common, const HalOptions& options,
                                         std::string_view printing_verb);

/// Says on stderr why a verb failed and, with `next` (lines, may be empty), what to do about it.
void report_failure(const char* device, const std::string& verb, const std::string& reason,
                    const std::optional<std::string>& next);

}  // namespace colift::tools
