#pragma once

#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// Whether the rays of a frame through a point (W) and to its four sides, `half_m` away, were all measured,
/// and go on beyond it to something clearly farther: nothing is there any more. `X_CW`: of the frame.
[[nodiscard]] bool looks_past(const OrganisedCloud& cloud, const hal::Pose& X_CW, const hal::Vec3& p_W,
                              double half_m);

/// Whether a frame says nothing of a point (W): something is before it, nothing was measured there, or it is
/// outside of the image.
[[nodiscard]] bool is_hidden(const OrganisedCloud& cloud, const hal::Pose& X_CW, const hal::Vec3& p_W);

}  // namespace colift::perception
