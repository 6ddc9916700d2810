#pragma once

#include "sim_hal/people/body_region.hpp"

namespace colift::sim_hal {

/// Largest force on a region of the body (N).
struct ForceLimit {
  double quasi_static_n = 0.0;
  double transient_n = 0.0;
};

/// ISO/TS 15066 Annex A as known from secondary sources (read the standard before use): transient contact may
/// be twice the quasi-static one, for head and face not at all. It has no foot and no neck: judged as a lower
/// leg and as a face.
[[nodiscard]] ForceLimit force_limit(BodyRegion region);

}  // namespace colift::sim_hal
