#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "hal/config/range.hpp"
#include "hal/depth_camera.hpp"
#include "hal/infrared_camera.hpp"

namespace colift::perception {

struct SpotConfig {
  double sigmas = 8.0;
  double peak_part = 0.10;
  double steady_part = 0.4;
  int least_px = 4;
  int most_px = 200;
  double rival_part = 0.7;
  double move_px = 0.3;
  int saturation = 1015;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sigmas", sigmas, hal::Range{3, 50}, "A spot is brighter than the noise by this many deviations.");
    v("peak_part", peak_part, hal::kFraction, "A spot's pixels have at least this part of its peak.");
    v("steady_part", steady_part, hal::kFraction,
      "Part of a spot's brightness that every pair of images shows; less is something that moves.");
    v("least_px", least_px, hal::Range{1, 100}, "Smaller spots are noise (px).");
    v("most_px", most_px, hal::Range{10, 5000}, "Larger ones are no emitter (px).");
    v("rival_part", rival_part, hal::kFraction,
      "A second spot with this part of the first one's light makes the image useless.");
    v("move_px", move_px, hal::kPositive, "A spot that moves farther between images is not still (px).");
    v("saturation", saturation, hal::Range{100, 65535}, "Brightness from which a pixel says no more.");
  }
};

/// The emitter in the image.
struct Spot {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();       ///< Pixel centres at integer coordinates.
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< px^2.
  double peak = 0.0;                                     ///< Brightest difference.
  int area_px = 0;
  bool saturated = false;
  double moved_px = 0.0;  ///< Farthest from the mean in a pair of images.
};

/// Why an image has no spot: "dark", "faint", "large", "moving", "rival", "border", "unsteady", "images".
struct SpotRefusal {
  std::string kind;
  std::string because;
};

/// Finds what is brighter with the emitter on: difference of the mean images, connected blobs above noise
/// and a part of the peak, those that every image shows, the largest if it has no rival. Sub-pixel place by
/// the centre of light; by a Gaussian on the flanks where the core is saturated (weights after Guo 2011).
[[nodiscard]] tl::expected<Spot, SpotRefusal> find_spot(std::span<const hal::InfraredFrame> off,
                                                        std::span<const hal::InfraredFrame> on,
                                                        const SpotConfig& config);

/// The same for an emitter that blinks by itself: which image shows it lit is told from the images, half-lit
/// ones are left out.
[[nodiscard]] tl::expected<Spot, SpotRefusal> find_blinking_spot(std::span<const hal::InfraredFrame> frames,
                                                                 const SpotConfig& config);

/// Depth around a spot (m): median of a ring of 5 to 12 pixels about it in the depth image, which is cut out
/// of the infrared one at (5, 4). Nothing with fewer than 8 values, or when they lie farther apart than a
/// palm is deep (4 cm).
[[nodiscard]] std::optional<double> depth_near(const hal::DepthFrame& depth, const Eigen::Vector2d& pixel);

}  // namespace colift::perception
