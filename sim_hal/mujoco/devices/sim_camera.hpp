#pragma once

#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/synthetic/ray_caster.hpp"

namespace colift::sim_hal {

/// Exposure of frame n, counted from 0, in a world that moves in whole milliseconds: the first millisecond
/// that is not before n / 30 s.
[[nodiscard]] hal::Timestamp exposure_due(std::uint64_t frame);

/// What the camera of the scenario sees right now, without noise and with truth for every pixel. For tests
/// and reports.
[[nodiscard]] Rendering render_truth(const SimWorld& world);

}  // namespace colift::sim_hal
