#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/drivers/recorded/file_bytes.hpp"
#include "hal/types/geometry.hpp"

namespace colift::hal {

struct PcdField {
  std::string_view name;
  std::uint64_t size = 4;   ///< Bytes of one value.
  std::uint64_t count = 1;  ///< Values.
  char type = 'F';          ///< F, I or U.
};

/// What a PCD header says, checked: sizes fit each other, and x, y, z are single numbers. Whether the rest of
/// the file holds that many points is not checked here. Views point into the bytes that were parsed.
struct PcdHeader {
  enum class Data { Ascii, Binary, Compressed };

  std::vector<PcdField> fields;
  std::uint64_t row_bytes = 0;   ///< Of one point in binary data, at most 2^32.
  std::uint64_t row_values = 0;  ///< Of one point in ascii data.
  std::uint64_t points = 0;      ///< At least 1, width * height, at most 2^31.
  int width = 0;
  int height = 0;
  Pose viewpoint = Pose::Identity();
  Data data = Data::Ascii;
  std::size_t data_offset = 0;        ///< First byte after the line DATA.
  std::size_t data_line = 0;          ///< Number of the line DATA.
  std::size_t x = 0, y = 0, z = 0;    ///< Index into fields.
  std::optional<std::size_t> colour;  ///< Index into fields: packed colour of 4 bytes.
};

/// Errors: BadInput, with the line or the header key.
[[nodiscard]] Result<PcdHeader> parse_pcd_header(Bytes bytes, const std::string& name);

}  // namespace colift::hal
