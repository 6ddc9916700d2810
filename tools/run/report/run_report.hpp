#pragma once

#include <filesystem>
#include <string>

#include "hal/types/result.hpp"
#include "tools/run/run_view.hpp"

namespace colift::tools {

/// The run as one HTML page that needs nothing else: outcome, time line, pictures, decision table, curves,
/// timing, truth against estimate, faults, configuration.
[[nodiscard]] std::string run_report_html(const RunView& view);

/// The same as a file. Errors: BadInput when it cannot be written.
[[nodiscard]] hal::Result<> write_run_report(const std::filesystem::path& html, const RunView& view);

/// The lift as a picture on its own, for a README: the scene at the top from a chosen side. Errors: as above.
[[nodiscard]] hal::Result<> write_lift_picture(const std::filesystem::path& png, const RunView& view);

}  // namespace colift::tools
