#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace colift::sim_hal {

/// Where too little of a Kinect's light comes back, one image row after the other: on grazing and dark
/// surfaces, out of range, and in specks without a cause.
class KinectLight {
 public:
  /// `reflectivity` of every shape; `seed` of the frame.
  KinectLight(const std::vector<float>& reflectivity, int width, std::uint64_t seed);

  /// Takes the inverse depth (1 / m) from the pixels of row v whose light is lost. `shape` (-1: none) and
  /// `cosine` of incidence tell what each pixel sees; all three as long as the width, rounded up to a
  /// multiple of four.
  void punch_holes(int v, const std::int16_t* shape, const float* cosine, float* inverse_depth);

 private:
  void judge_four(int v, const std::int16_t* shape, const float* cosine, std::size_t u, float* inverse_depth);
  void lay_patches(int v);
  void add_specks(int v, float* inverse_depth) const;

  std::vector<float> reflectivity_;  // one place up, of no shape first
  int width_;
  std::size_t seen_columns_, whole_;  // whole: width, rounded up
  std::uint64_t seed_;
  // smooth numbers in [0, 1) with lumps of a few pixels: knots of two rows, and what they make of one row
  int knot_row_ = -2, patch_row_ = -1;
  std::vector<float> above_, below_, knots_;
  std::vector<std::uint16_t> knot_;  // left of each column
  std::vector<float> part_;          // of the way from it to the next
};

}  // namespace colift::sim_hal
