#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/drivers/recorded/file_bytes.hpp"

namespace colift::hal {

enum class PlyType { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };
enum class PlyEncoding { Ascii, Little, Big };

[[nodiscard]] std::size_t bytes_of(PlyType type);

struct PlyProperty {
  std::string_view name;
  PlyType type = PlyType::Float32;
  std::optional<PlyType> length;  ///< Of a list: the type of its length.
};

struct PlyElement {
  std::string_view name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  [[nodiscard]] bool has_lists() const;

  /// Index of the scalar property of that name.
  [[nodiscard]] std::optional<std::size_t> find(std::string_view wanted) const;

  /// Fewest bytes of one record: an empty list is its length alone, an ascii value is a digit and a space.
  [[nodiscard]] std::uint64_t min_bytes(PlyEncoding encoding) const;
};

/// What a PLY header says. Whether the rest of the file holds as much is not checked here. Views point into
/// the bytes that were parsed.
struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::Ascii;
  std::vector<PlyElement> elements;
  std::optional<std::uint64_t> columns, rows;  ///< Of an organised cloud, from obj_info; each at most 2^31.
  std::size_t data_offset = 0;                 ///< First byte after the line end_header.
  std::size_t data_line = 0;                   ///< Number of the line after it.
};

/// Errors: BadInput, with the line.
[[nodiscard]] Result<PlyHeader> parse_ply_header(Bytes bytes, const std::string& name);

}  // namespace colift::hal
