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

/// What counts as the emitter's spot in an infrared image.
struct SpotConfig {
  double sigmas = 8.0;
  double peak_fraction = 0.10;
  double steady_fraction = 0.4;
  int min_px = 4;
  int max_px = 200;
  double rival_fraction = 0.7;
  double move_px = 0.3;
  int saturation = 1015;
  int window_px = 2;
  int blink_places = 8;
  double min_sigma_px = 0.08;
  double min_fitted_sigma_px = 0.15;
  double min_noise = 0.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v("sigmas", sigmas, hal::Range{3, 50}, "Min brightness of a spot, in standard deviations of the noise.");
    v("peak_fraction", peak_fraction, hal::kFraction,
      "Min brightness of a spot's pixels, as a fraction of its peak.");
    v.renamed("peak_part", "peak_fraction");
    v("steady_fraction", steady_fraction, hal::kFraction,
      "Min fraction of a spot's brightness that every pair of images shows; less is something that moves.");
    v.renamed("steady_part", "steady_fraction");
    v("min_px", min_px, hal::Range{1, 100}, "Min area of a spot (px).");
    v.renamed("least_px", "min_px");
    v("max_px", max_px, hal::Range{10, 5000}, "Max area of a spot (px).");
    v.renamed("most_px", "max_px");
    v("rival_fraction", rival_fraction, hal::kFraction,
      "Max light of a second spot, as a fraction of the first one's.");
    v.renamed("rival_part", "rival_fraction");
    v("move_px", move_px, hal::kPositive, "Max motion of a spot between images (px).");
    v("saturation", saturation, hal::Range{100, 65535}, "Brightness at which a pixel is saturated.");
    v("window_px", window_px, hal::Range{0, 50}, "Width around a spot that still holds its light (px).");
    v("blink_places", blink_places, hal::Range{1, 1000},
      "Number of places, most changed first, that are tried as a blinking emitter.");
    v("min_sigma_px", min_sigma_px, hal::kPositive,
      "Min standard deviation of a spot's centre of light (px).");
    v("min_fitted_sigma_px", min_fitted_sigma_px, hal::kPositive,
      "Min standard deviation of a saturated spot, which is fitted on its flanks (px).");
    v("min_noise", min_noise, hal::kPositive,
      "Min noise of a brightness difference: the steps of the readout.");
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
  std::string reason;
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
