#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace colift::sim_hal {

/// The grain of a Kinect's depth, one image row after the other: normal numbers of which neighbours are
/// alike, since their correlation windows overlap. White noise, smoothed along rows and across. In planes of
/// real frames neighbours along a row correlate by 0.4 to 0.6, next but one by 0.2 to 0.35.
///
/// The white noise of a row is a piece of one long tape of normal numbers, from a place that is drawn for the
/// row: pieces of two rows overlap in 2 % of the cases, then with a shift along the row.
class KinectGrain {
 public:
  /// `seed` of the frame.
  KinectGrain(int width, std::uint64_t seed);

  /// Standard deviations in units of kUnit, for each pixel of the next row; as many as the width, rounded up
  /// to a multiple of eight. Valid until the next call.
  [[nodiscard]] const std::int16_t* next_row();

  static const float kUnit;

 private:
  [[nodiscard]] const std::int16_t* white(int v, std::size_t begin) const;

  std::uint64_t seed_;
  int v_ = 0;
  std::vector<std::int16_t> across_, row_;
};

}  // namespace colift::sim_hal
