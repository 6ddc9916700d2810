#pragma once

#include <vector>

#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// The seen part of an image. Registered frames have empty margins (up to 43 columns and 29 rows), so an
/// object that leaves the view ends at the seen part's rim and not at the image's.
struct ImageBorder {
  std::vector<int> left, right;  ///< First and last column in view, per row.
  std::vector<int> top, bottom;  ///< First and last row in view, per column.
};

[[nodiscard]] ImageBorder find_image_border(const OrganisedCloud& cloud);

}  // namespace colift::perception
