#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <random>
#include <string>
#include <vector>

#include "hal/drivers/recorded/cloud_files/point_file.hpp"
#include "hal/drivers/recorded/file_bytes.hpp"
#include "tests/support/temporary_folder.hpp"

namespace colift::hal::test {

/// One column of a PCD file, with the letter and the size in bytes of its type.
struct Column {
  std::string name;
  char type = 'F';
  int size = 4;
  int count = 1;
};

enum class PcdData { Ascii, Binary, Compressed };

/// Columns x, y, z as floats and a packed colour, if the points have one.
[[nodiscard]] std::vector<Column> plain_columns(const PointFile& points);

/// A PCD file of the points; columns other than x, y, z, rgb and rgba hold the number 7.
[[nodiscard]] std::string pcd(const PointFile& points, PcdData data, const std::vector<Column>& columns);
[[nodiscard]] std::string pcd(const PointFile& points, PcdData data);

enum class PlyData { Ascii, Little, Big };

/// A PLY file of the points, with a list element before and another after the vertices.
[[nodiscard]] std::string ply(const PointFile& points, PlyData data);

/// A PNG of grey values, 8 or 16 bits, or of RGB colours.
[[nodiscard]] std::string png(int width, int height, int bits, bool colour, bool interlaced,
                              const std::vector<std::uint16_t>& values);

/// Points anywhere in a cube of 4 m, some of them NaN, with colours when asked for.
[[nodiscard]] PointFile random_points(std::uint32_t seed, int width, int height, bool coloured);

[[nodiscard]] inline Bytes bytes_of(const std::string& text) {
  return std::as_bytes(std::span(text));
}

using tests::TemporaryFolder;

[[nodiscard]] std::filesystem::path data(const std::string& name);

/// True when both are the same number or both are not finite.
[[nodiscard]] bool same(float a, float b);
[[nodiscard]] bool same(const std::vector<float>& a, const std::vector<float>& b);

}  // namespace colift::hal::test
