#pragma once

#include "tools/run/run_parts.hpp"

namespace colift::tools {

/// RunParts::open_recording and RunParts::open_view.
[[nodiscard]] hal::Result<std::unique_ptr<RunRecording>> open_recording(
    const CommonOptions& common, const RunOptions& options, const control::JobOptions& job, Rig& rig,
    Setup& setup, const hal::Clock& wall, const std::vector<telemetry::TelemetrySink*>& watchers);
[[nodiscard]] hal::Result<std::unique_ptr<LiveView>> open_view(const RunOptions& options,
                                                               const std::string& title);

}  // namespace colift::tools
