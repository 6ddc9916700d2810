#pragma once

// What the exports share, the bag of ROS 2 in tools/dds among them. For .cpp files of exports only.

#include <filesystem>
#include <functional>
#include <string_view>

#include "hal/types/result.hpp"
#include "tools/telemetry/channels/recorded_frame.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/replay/export.hpp"

namespace colift::telemetry {

[[nodiscard]] hal::Result<> make_folder(const std::filesystem::path& folder);
[[nodiscard]] hal::Result<> write_whole(const std::filesystem::path& file, std::string_view bytes);
[[nodiscard]] tl::unexpected<hal::Error> cannot_write(const std::filesystem::path& file);

/// Goes through all depth frames of a recording. Frames that are damaged, or whose pixels are not as many as
/// their size says, are counted in a note. Errors: BadInput when there is none.
[[nodiscard]] hal::Result<> for_each_frame(const McapReader& file, Exported& out,
                                           const std::function<hal::Result<>(const NumberedFrame&)>& take);

}  // namespace colift::telemetry
