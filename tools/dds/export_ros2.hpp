#pragma once

#include <filesystem>

#include "hal/types/result.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/replay/export.hpp"

namespace colift::ros2 {

/// A recording as a bag of ROS 2: bag_0.mcap (profile "ros2": messages in CDR, definitions beside them) and
/// metadata.yaml, as `ros2 bag` writes them. The topics are those of a run with `--ros2`; stamps and log
/// times are the robot's clock moved to the date at which the run was started. Messages that cannot be
/// converted are counted in a note, channels without a message of ROS 2 are named in one. Errors: BadInput
/// (the folder cannot be written, no message of the recording has a topic of ROS 2).
[[nodiscard]] hal::Result<telemetry::Exported> export_ros2(const telemetry::McapReader& file,
                                                           const std::filesystem::path& folder);

}  // namespace colift::ros2
