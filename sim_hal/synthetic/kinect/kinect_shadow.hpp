#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace colift::sim_hal {

/// The shadow of a Kinect's projector, one image row after the other. The projector stands to the right of
/// the camera: what it sees is found by projecting the image's own surfaces into its columns, nearest first.
/// Surfaces that the camera does not see cast no shadow here.
class ProjectorShadow {
 public:
  ProjectorShadow(int width, double fx);

  /// Finds out where the projector does not reach in a row of inverse depths (1 / m, NaN where there is
  /// none), as long as the width, rounded up to a multiple of four.
  void find(const float* inverse_depth);
  /// Takes the depth from where find() says so.
  void apply(float* inverse_depth) const;

 private:
  // disparity rises by so much from a column to the next
  struct Jump {
    std::size_t column;
    float rise;
  };

  void look(const float* inverse_depth);
  void find_jumps();
  void find_spans();
  void project(std::size_t begin, std::size_t end);

  std::size_t width_;
  float shift_;  // disparity (px) of 1 m
  int margin_;
  float low_ = 0.0f, high_ = 0.0f;          // disparities of the row
  std::vector<float> columns_;              // of the camera, as numbers
  std::vector<float> disparity_, nearest_;  // of the camera's columns; in the projector's columns
  std::vector<std::int32_t> column_;        // of the projector, for each of the camera's
  std::vector<Jump> jumps_;
  std::vector<std::pair<std::size_t, std::size_t>> spans_;  // where there may be shadow
};

}  // namespace colift::sim_hal
