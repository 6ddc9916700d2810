#pragma once

#include <string>
#include <vector>

#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "perception/noise_model.hpp"

namespace colift::perception {

/// A noise model measured on frames, and how far it can be trusted.
struct MeasuredNoise {
  NoiseModel model;
  std::size_t frames = 0, blocks = 0;        ///< Flat blocks of 16 x 16 pixels that it rests on.
  double nearest_m = 0.0, farthest_m = 0.0;  ///< Depths that it was measured at.
  double flat_fraction = 0.0;                ///< Of the blocks with depth; a floor and walls have nearly all.
  double misfit = 0.0;              ///< Root mean square of (measured / model - 1) over bins of depth.
  std::vector<std::string> doubts;  ///< What to do better, in a person's words.
};

/// Measures the depth noise of a camera that sees an empty floor or a wall. In each block of 16 x 16 pixels
/// the inverse depth of a plane is linear in the pixel, so what is left of a linear fit is noise; medians
/// over bins of depth are fitted by sigma0 + sigma2 z^2. The quantisation step is the usual distance between
/// neighbouring depth levels.
class NoiseFit {
 public:
  void add(const hal::DepthFrame& frame);
  /// Errors: BadInput when too few flat blocks were seen or they are all at one distance.
  [[nodiscard]] hal::Result<MeasuredNoise> result() const;

 private:
  struct Block {
    float depth_m, residual_m;
  };
  std::vector<Block> blocks_;
  std::vector<float> steps_;  // distance of neighbouring depth levels, divided by depth^2 (1/m)
  std::size_t frames_ = 0, with_depth_ = 0;
};

}  // namespace colift::perception
