#pragma once

#include <span>

#include "perception/calibration/emitter_model.hpp"

namespace colift::perception {

/// Camera pose and emitter without a guess, from these samples: an image of points at one common depth gives
/// the first rotation (scaled orthography); then rotation (Horn 1987) and, with
/// the rotation known, translation and emitter (linear least squares of the distances from the rays) in
/// turn, after Lu, Hager and Mjolsness 2000. The emitter is kept near `model.p_H` by `emitter_prior_m`.
/// Writes R, t and p of `model`, whose intrinsics are used. False when the samples give none (fewer than 4,
/// all alike, or behind the camera).
[[nodiscard]] bool start_value(std::span<const EmitterSample> samples, std::span<const int> use,
                               double emitter_prior_m, int rounds, EmitterModel& model);

}  // namespace colift::perception
