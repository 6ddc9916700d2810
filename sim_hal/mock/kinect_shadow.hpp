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

  /// Finds out where the projector does not reach in a row of `width` depths (m, NaN where there is none).
  void find(const float* depth_m);
  /// Takes the depth from where find() says so.
  void apply(float* depth_m) const;

 private:
  void find_spans();
  void project(std::size_t begin, std::size_t end);

  float shift_;  // disparity (px) times depth (m)
  int margin_;
  std::vector<float> disparity_, nearest_;  // of the camera's columns; in the projector's columns
  std::vector<std::int32_t> column_;        // of the projector, for each of the camera's
  std::vector<std::pair<std::size_t, std::size_t>> spans_;  // where there may be shadow
};

}  // namespace colift::sim_hal
