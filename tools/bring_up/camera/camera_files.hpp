#pragma once

#include <filesystem>
#include <optional>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "perception/noise_fit.hpp"
#include "tools/cli/session.hpp"

namespace colift::tools {

/// A frame as `look`, `decide` and `check` read it: 16-bit PNG in millimetres, camera.json beside it. Errors:
/// BadInput (cannot be written).
[[nodiscard]] hal::Result<> write_depth(const std::filesystem::path& png, const hal::DepthFrame& frame);

/// Says what was measured beside what is configured, and writes it as a configuration into `out` or to
/// stdout. An exit code.
[[nodiscard]] int say_noise(const CommonOptions& common, const std::optional<std::filesystem::path>& out,
                            const hal::Result<perception::MeasuredNoise>& noise,
                            const perception::NoiseModel& configured);

}  // namespace colift::tools
