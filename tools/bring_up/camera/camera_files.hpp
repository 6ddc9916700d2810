#pragma once

#include <filesystem>
#include <optional>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "perception/noise_fit.hpp"
#include "tools/cli/session.hpp"

namespace colift::tools {

/// Says what was measured beside what is configured, and writes it as a configuration into `out` or to
/// stdout. An exit code.
[[nodiscard]] int say_noise(const CommonOptions& common, const std::optional<std::filesystem::path>& out,
                            const hal::Result<perception::MeasuredNoise>& noise,
                            const perception::NoiseModel& configured);

}  // namespace colift::tools
