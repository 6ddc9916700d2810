#pragma once

#include <string>

#include "hal/drivers/recorded/cloud_files/point_file.hpp"
#include "hal/drivers/recorded/file_bytes.hpp"

namespace colift::hal {

/// Parses the vertices of a PLY file: ascii, binary_little_endian or binary_big_endian 1.0, the vertex
/// element anywhere among others, scalar and list properties, colours from red, green, blue. The file is
/// organised when the header says so (obj_info num_cols and num_rows) or an element `camera` does (viewportx,
/// viewporty); that element's view_p and axes are the viewpoint. `name` stands in error messages. Errors:
/// BadInput, with the line or the byte. Allocates no more than the bytes can fill. Source: G. Turk, "The PLY
/// Polygon File Format", 1994; the camera element is the one that PCL writes.
[[nodiscard]] Result<PointFile> parse_ply(Bytes bytes, const std::string& name);

}  // namespace colift::hal
