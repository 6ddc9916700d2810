#pragma once

#include <string>

#include "hal/drivers/recorded/cloud_files/point_file.hpp"
#include "hal/drivers/recorded/file_bytes.hpp"

namespace colift::hal {

/// Parses a PCD file, versions .5 to .7: DATA ascii, binary or binary_compressed; x, y, z of any numeric type
/// in any order among any other fields; colours from a packed field rgb or rgba. The header may leave out
/// VERSION, COUNT, VIEWPOINT and either POINTS or WIDTH and HEIGHT. `name` stands in error messages. Errors:
/// BadInput, with the line, the header key or the byte. Allocates no more than the bytes can fill. Source:
/// the format's description in PCL's documentation, "The PCD (Point Cloud Data) file format".
[[nodiscard]] Result<PointFile> parse_pcd(Bytes bytes, const std::string& name);

}  // namespace colift::hal
