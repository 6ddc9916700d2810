#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "hal/depth_camera.hpp"
#include "perception/noise_model.hpp"
#include "perception/organised_cloud.hpp"

namespace colift::perception {

/// When something between the camera and the partner's hand hides it. SI units.
struct HiddenConfig {
  double radius_m = 0.10;
  double gap_m = 0.12;
  double min_covered = 0.2;
  double max_uncovered = 0.3;

  template <class Visitor>
  void visit(Visitor& v) {
    v("radius_m", radius_m, hal::Range{0.02, 0.5},
      "Pixels of a body so near to his contact are those of his hand (m).");
    v("gap_m", gap_m, hal::Range{0.02, 1.0},
      "Min distance of what covers the hand from the contact, towards the camera; nearer is the hand (m).");
    v("min_covered", min_covered, hal::kFraction,
      "Min fraction of the hand's pixels that something covers: missing depth alone is no reason.");
    v("max_uncovered", max_uncovered, hal::kFraction,
      "Max fraction of them that show again what is there without him; beyond, the hand is gone.");
  }
};

/// The pixels that showed the partner's hand in the last frame in which it was seen, and what became of them.
class HandPixels {
 public:
  explicit HandPixels(const HiddenConfig& config) : config_(config) {}

  /// A frame that shows the hand; one that shows less than half of what was seen at the same place changes
  /// nothing. `changed`: pixels of bodies in it, ascending; `contact_W` in metres.
  void seen(const OrganisedCloud& reference, const hal::DepthFrame& frame,
            std::span<const std::uint32_t> changed, const hal::Vec3& contact_W);

  /// Whether a later frame neither shows the hand nor that it is gone, because his body, or the robot, is
  /// before it. False as long as nothing was seen.
  ///
  /// `reference`: image of the scene without him, of the same camera.
  /// `frame`: without the robot's pixels.
  /// `robot_pixels`: those that were removed, ascending.
  [[nodiscard]] bool hidden(const OrganisedCloud& reference, const hal::DepthFrame& frame,
                            std::span<const std::uint32_t> robot_pixels, const NoiseModel& noise) const;

  [[nodiscard]] bool seen_before() const { return !pixels_.empty(); }
  void forget() { pixels_.clear(); }

 private:
  HiddenConfig config_;
  std::vector<std::uint32_t> pixels_;
  hal::Vec3 contact_C_ = hal::Vec3::Zero();  ///< Where the hand was then, in the camera.
};

}  // namespace colift::perception
