#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "perception/surfaces/object_image.hpp"
#include "perception/surfaces/surface_config.hpp"

namespace colift::perception {

using Part = std::vector<std::uint32_t>;  ///< Entries of an ObjectImage.

/// Connected parts of the object: sets of neighbouring pixels without a jump of depth between them. Every
/// part has a number; pixels of no part have 0. Jumps are by more than CylinderSearchConfig::jump_sigma,
/// jump_steps and jump_base_m together.
class ObjectParts {
 public:
  /// Image and configuration are kept by reference; the labels may change between calls.
  ObjectParts(const ObjectImage& image, const CylinderSearchConfig& config)
      : image_(image), config_(config), number_(image.q.size(), 0) {}

  /// Sets these pixels free for connected(); they leave their parts.
  void open(std::span<const std::uint32_t> pixels) {
    for (const std::uint32_t k : pixels) number_[k] = kOpen;
  }
  /// The parts that the open ones among these pixels make up, in the order of their first pixels; those of
  /// fewer pixels than `least` keep their numbers and are not returned.
  [[nodiscard]] std::vector<Part> connected(std::span<const std::uint32_t> pixels, std::size_t least);

  [[nodiscard]] std::int32_t number(std::uint32_t pixel) const { return number_[pixel]; }
  void set_number(std::uint32_t pixel, std::int32_t number) { number_[pixel] = number; }

  /// All four neighbours are of the same part. Ragged rims carry the depth of a body to where it is not.
  [[nodiscard]] bool inner(std::uint32_t pixel) const;

  /// Pixels of no cylinder in the part's bounding box in the image, grown by `margin` pixels on each side.
  [[nodiscard]] Part around(const Part& part, int margin) const;

  /// How much of a part's rim, 0 to 1, is where the object goes on without a jump of depth.
  [[nodiscard]] double open_rim(const Part& part) const;

 private:
  static constexpr std::int32_t kOpen = -1;

  [[nodiscard]] std::array<std::uint32_t, 4> neighbours(std::uint32_t k) const {
    const auto w = static_cast<std::uint32_t>(image_.width);
    return {k - 1, k + 1, k - w, k + w};
  }
  [[nodiscard]] bool no_jump(std::uint32_t from, std::uint32_t to) const;

  const ObjectImage& image_;
  const CylinderSearchConfig& config_;
  std::vector<std::int32_t> number_;
  std::int32_t last_ = 0;
};

}  // namespace colift::perception
