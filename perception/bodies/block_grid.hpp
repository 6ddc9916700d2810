#pragma once

#include <algorithm>
#include <cstddef>

namespace colift::perception {

/// The blocks of 4 x 4 pixels of an image, row by row; a border that fills none belongs to none.
struct BlockGrid {
  static constexpr std::size_t kSide = 4;  ///< Pixels: 3 cm at 4 m.

  std::size_t width = 0;              ///< Of the image (px).
  std::size_t columns = 0, rows = 0;  ///< Of blocks.

  BlockGrid(std::size_t width_px, std::size_t height_px)
      : width(width_px), columns(width_px / kSide), rows(height_px / kSide) {}

  [[nodiscard]] std::size_t size() const { return columns * rows; }
  /// The block of a pixel, at the right border the nearest one; size() or more below the last row.
  [[nodiscard]] std::size_t of_pixel(std::size_t pixel) const {
    return pixel / width / kSide * columns + std::min(pixel % width / kSide, columns - 1);
  }
  /// Upper left pixel of a block.
  [[nodiscard]] std::size_t u(std::size_t block) const { return kSide * (block % columns); }
  [[nodiscard]] std::size_t v(std::size_t block) const { return kSide * (block / columns); }

  /// Calls `each` with the block itself and those beside it, up to eight.
  template <class Each>
  void around(std::size_t block, Each&& each) const {
    const std::size_t r = block / columns, c = block % columns;
    for (std::size_t y = r > 0 ? r - 1 : 0; y <= std::min(r + 1, rows - 1); ++y)
      for (std::size_t x = c > 0 ? c - 1 : 0; x <= std::min(c + 1, columns - 1); ++x) each(y * columns + x);
  }
  /// Calls `each` with the pixels of a block.
  template <class Each>
  void pixels(std::size_t block, Each&& each) const {
    const std::size_t first = v(block) * width + u(block);
    for (std::size_t y = 0; y < kSide; ++y)
      for (std::size_t x = 0; x < kSide; ++x) each(first + y * width + x);
  }
};

}  // namespace colift::perception
