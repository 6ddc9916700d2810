#pragma once

#include <string>

#include "control/config/resolve_config.hpp"
#include "tools/cli/options.hpp"

namespace colift::tools {

// The configuration that a command works with, of its options: used by the command itself and by
// `colift check --for`. Errors: BadConfig and BadInput, with the place. Those of `experiment` and `log
// replay` stand beside these commands.

[[nodiscard]] hal::Result<control::ResolvedConfig> config_of_run(const CommonOptions& common,
                                                                 const RunOptions& options);
[[nodiscard]] hal::Result<control::ResolvedConfig> config_of_look(const CommonOptions& common,
                                                                  const LookOptions& options);
[[nodiscard]] hal::Result<control::ResolvedConfig> config_of_decide(const CommonOptions& common,
                                                                    const DecideOptions& options);
/// Of a command whose other options say nothing about it: calibrate, hal.
[[nodiscard]] hal::Result<control::ResolvedConfig> config_of(const CommonOptions& common,
                                                             control::Command command);

/// Shows what was accepted and should be looked at on stderr, unless --quiet was given.
void show_warnings(const char* command, const CommonOptions& common, const control::ResolvedConfig& resolved);

}  // namespace colift::tools
