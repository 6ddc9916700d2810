#pragma once

#include <filesystem>
#include <optional>
#include <string>

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

/// The document colift.hal.camera/1 with what was measured as its entry "noise"; as it was when there is
/// nothing.
[[nodiscard]] std::string with_noise(const std::string& document,
                                     const std::optional<perception::MeasuredNoise>& noise);

}  // namespace colift::tools
