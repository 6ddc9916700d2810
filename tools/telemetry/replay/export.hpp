#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "hal/types/result.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::telemetry {

/// What an export wrote.
struct Exported {
  std::vector<std::filesystem::path> files;  ///< The first ones; `count` has all.
  std::uint64_t count = 0;
  std::vector<std::string> notes;  ///< What is not as it was, with numbers.
};

// All make the folder. Errors: BadInput (the folder cannot be written, no such messages in the recording).

/// One table for each JSON channel (RFC 4180): a row per message, a column per number and text in it, times
/// in seconds first. Lists of at most 16 entries get a column each; longer ones, texts beyond 1000 bytes and
/// pictures are left out.
[[nodiscard]] hal::Result<Exported> export_csv(const McapReader& file, const std::filesystem::path& folder);

/// depth_000000.png ... in 16-bit grey, one unit a millimetre, 0 where nothing was seen; camera.json beside
/// them, as `colift look` reads it, and frames.csv with number and time of each.
[[nodiscard]] hal::Result<Exported> export_png(const McapReader& file, const std::filesystem::path& folder);

/// A folder that libfreenect's fakenect plays: the depths as the codes of a Kinect v1, with nominal
/// constants.
[[nodiscard]] hal::Result<Exported> export_fakenect(const McapReader& file,
                                                    const std::filesystem::path& folder);

/// The code of a depth (m) by z = 345.4894 / (1089.408 - code); 2047 for none.
[[nodiscard]] std::uint16_t kinect_code(float depth_m);

}  // namespace colift::telemetry
