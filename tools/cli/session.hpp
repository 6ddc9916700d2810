#pragma once

#include <memory>
#include <optional>

#include "control/config/resolve_config.hpp"
#include "hal/types/result.hpp"
#include "perception/calibration/calibration_file.hpp"
#include "planner/hand/hand_model.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {

/// Configuration of one call of the program, and what it names: hand and calibration.
struct Setup : control::ResolvedConfig {
  planner::HandModel hand;
  std::optional<perception::CalibrationFile> calibration;     ///< When the configuration names one.
  std::shared_ptr<const planner::HandCollision> hand_tables;  ///< Made once, for every look.
};
/// Reads the files that a configuration names. Errors: BadConfig, with the place.
[[nodiscard]] hal::Result<Setup> load_setup(const hal::Result<control::ResolvedConfig>& resolved);

/// Prints an error to stderr and returns the exit code that belongs to it.
int report_error(const char* command, const hal::Error& error);

}  // namespace colift::tools
