#pragma once

#include <cstddef>
#include <cstdint>

namespace colift::sim_hal::kinect_rows {

// What is done to every pixel of a row, in plain loops: compiled for AVX2 too, with the same bits. Rows are
// as long as the width, rounded up to a multiple of four; inverse depth in 1 / m, NaN where there is none.

void invert(const float* from, std::size_t n, float* to);

/// inverse_depth += sigma * grain, with the sigma of a Kinect at this depth and angle less what rounding to
/// codes adds of its own. `grain` in standard deviations times 1 / `grain_unit`.
void shake(const std::int16_t* grain, float grain_unit, const float* cosine, bool rounded, std::size_t n,
           float* inverse_depth);

/// Depth (m) of the nearest code, as in kinect_depths_m() to the bit; NaN where there is none.
void read_codes(const float* inverse_depth, std::size_t n, float* depth_m);

/// What one surface has to send back to be seen for certain.
struct Light {
  float nearest, farthest;  ///< Limits of inverse depth.
  float reflectivity, bright, facing;
};

/// Whether all of at most 64 pixels, of one surface, are in range, bright and face the camera.
[[nodiscard]] bool all_seen(const Light& light, const float* inverse_depth, const float* cosine,
                            std::size_t n);

/// Disparity `shift` * inverse depth, 0 where there is no depth or one beyond `most`; the projector's
/// column that sees the pixel, whose own column is `columns`.
void disparities(const float* inverse_depth, const float* columns, float shift, float most, float middle,
                 std::size_t n, float* disparity, std::int32_t* column);

}  // namespace colift::sim_hal::kinect_rows
