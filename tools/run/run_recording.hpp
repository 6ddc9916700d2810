#pragma once

#include "tools/run/run_parts.hpp"

namespace colift::tools {

/// RunParts::open_recording, RunParts::open_view and RunParts::open_ros2.
[[nodiscard]] hal::Result<std::unique_ptr<RunRecording>> open_recording(
    const CommonOptions& common, const RunOptions& options, const control::JobOptions& job, Rig& rig,
    Setup& setup, const hal::Clock& wall, const std::vector<telemetry::TelemetrySink*>& watchers);
[[nodiscard]] hal::Result<std::unique_ptr<LiveView>> open_view(const RunOptions& options,
                                                               const std::string& title);
[[nodiscard]] hal::Result<std::unique_ptr<Ros2View>> open_ros2(const RunOptions& options);

}  // namespace colift::tools
