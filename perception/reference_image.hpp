#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/types/result.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// What the fixed camera sees before the partner comes; later frames are compared with it pixel by pixel. One
/// frame is enough, 10 to 30 are better: edges stop flickering, and pixels that one frame missed are known.
/// All arrays are row-major, width * height.
struct ReferenceImage {
  OrganisedCloud cloud;       ///< Typical depth of each pixel and its point in W; NaN where no frame saw one.
  std::vector<float> near_m;  ///< Smallest depth that any frame measured; NaN where none.
  std::vector<float> spread_m;  ///< Standard deviation over the frames that agree; 0 where one frame saw it.
  std::vector<std::uint16_t> count;  ///< Frames that saw something there.
  int frames = 0;

  /// Part of the seen pixels that changed between frames by more than the noise explains (0 to 1). Edges
  /// alone stay below about 0.05; more means that somebody moved while the reference was taken.
  double restless = 0.0;
};

/// When a scene counts as at rest while its reference is taken.
struct ReferenceConfig {
  double max_restless = 0.10;
  double restless_sigma = 6.0;
  double restless_steps = 2.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("max_restless", max_restless, hal::kFraction,
      "Max fraction of the pixels that may change between the reference frames of a scene at rest.");
    v("restless_sigma", restless_sigma, hal::Range{0, 100},
      "Min change of such a pixel, in standard deviations of the depth noise.");
    v("restless_steps", restless_steps, hal::Range{0, 100}, "The same, in quantisation steps.");
  }
};

/// Typical depth: mean of the frames, and where they disagree by more than the noise (edges between near and
/// far), mean of those that agree with their median. A pixel of a frame that is NaN or not positive counts as
/// not seen. Errors: BadInput (no frame; frames of different sizes; array and intrinsics disagree; more than
/// 65535 frames), NotFound (no frame saw anything; or the scene was not at rest, with the share of restless
/// pixels).
[[nodiscard]] hal::Result<ReferenceImage> build_reference(std::span<const hal::DepthFrame> frames,
                                                          const hal::Pose& X_WC, const NoiseModel& noise,
                                                          const ReferenceConfig& config = {});

}  // namespace colift::perception
