#pragma once

#include <filesystem>
#include <functional>
#include <optional>

#include "control/config/resolve_config.hpp"
#include "hal/depth_camera.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {

struct RunParts;

// One function per command; each returns the exit code and prints its result to stdout, errors to stderr.

/// Perception of one recorded frame. 0 a target was seen, 1 none, 2 bad input or configuration.
[[nodiscard]] int cmd_look(const CommonOptions& common, const LookOptions& options);

/// look, then the decision for a partner's grasp. 0 a grasp was chosen, 1 none, 2 bad input or configuration.
[[nodiscard]] int cmd_decide(const CommonOptions& common, const DecideOptions& options);

/// The whole job on the robot or the simulated rig. 0 lifted (or a dry run found its way), 1 refused or
/// aborted, 2 bad input or configuration, 3 a device failed, 130 interrupted. `parts`: what this program can
/// do beyond a simulated run (tools/run/run_parts.hpp).
[[nodiscard]] int cmd_run(const CommonOptions& common, const RunOptions& options, const RunParts& parts);

/// Where a calibration comes from beside the configuration, and a picture that it is tried on.
struct CheckedCamera {
  std::optional<std::filesystem::path> robot;   ///< Whose calibration and driver.
  std::optional<std::filesystem::path> frame;   ///< Depth image, PCD or PLY.
  std::optional<std::filesystem::path> camera;  ///< camera.json of a PNG; unset: beside it.
  /// Reads `frame`; set where a frame can be asked for.
  std::function<hal::Result<hal::DepthFrame>()> read_frame;
};
/// Reads the configuration that `config` makes, hand and calibration, and prints what would be used, or draws
/// the rules of the job. 0 usable, 1 the ground of `frame` is not where the calibration has it, 2 not usable.
[[nodiscard]] int cmd_check(const CommonOptions& common, const CheckOptions& options,
                            const CheckedCamera& camera,
                            const std::function<hal::Result<control::ResolvedConfig>()>& config);

}  // namespace colift::tools
