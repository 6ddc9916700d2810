#pragma once

#include "perception/organised_cloud.hpp"
#include "perception/target/regions/components.hpp"
#include "perception/target/regions/fragments.hpp"
#include "perception/target/regions/silhouette.hpp"

namespace colift::perception {

/// How thick the parts of an object are across the view (m): at each of its pixels the length of the run of
/// its own pixels along the row or the column, whichever is shorter, at the pixel's depth; the median of all.
/// A bar that lies askew in the image looks up to 1.4 times as thick.
[[nodiscard]] double median_thickness(const OrganisedCloud& cloud, const Components& components,
                                      const Fragment& object);

/// The same within a window of the object's silhouette, where a run also ends at a jump in depth: what shows
/// behind an edge is another part. A few missing pixels do not end one.
[[nodiscard]] double median_thickness(const OrganisedCloud& cloud, const Components& components,
                                      const Fragment& object, const DepthJump& jump,
                                      const Silhouette& silhouette, const Silhouette::Window& window);

}  // namespace colift::perception
