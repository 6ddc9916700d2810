#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/types/result.hpp"

namespace colift::hal {

using Bytes = std::span<const std::byte>;

/// The whole of a regular file. Errors: BadInput (missing, a directory, empty, unreadable, over 2 GiB).
[[nodiscard]] Result<std::vector<std::byte>> load_file(const std::filesystem::path& file);

/// The first characters of a text between quotation marks, unprintable ones as \xNN, cut after 40: for error
/// messages.
[[nodiscard]] std::string shown(std::string_view text);

/// A decimal number, nan or inf; nothing when any part of the word is something else or beyond a double.
[[nodiscard]] std::optional<double> to_number(std::string_view word);

/// A whole number of at most 2^63; nothing for signs, fractions and larger numbers.
[[nodiscard]] std::optional<std::uint64_t> to_count(std::string_view word);

/// Takes the next word off the front of a line; empty when only white space is left.
[[nodiscard]] std::string_view next_word(std::string_view& rest);

/// Walks over the lines of a file whose tail may be binary. A carriage return before the line feed is not
/// part of a line.
class LineScanner {
 public:
  explicit LineScanner(Bytes bytes) : bytes_(bytes) {}

  /// Goes on behind a byte at which the given line ended.
  LineScanner(Bytes bytes, std::size_t offset, std::size_t line)
      : bytes_(bytes), offset_(offset), line_(line) {}

  /// The next line; nothing at the end of the file.
  [[nodiscard]] std::optional<std::string_view> next();

  [[nodiscard]] std::size_t line() const {
    return line_;
  }  ///< Number of the last line given, 1 is the first.
  [[nodiscard]] std::size_t offset() const { return offset_; }  ///< First byte after the last line given.

 private:
  Bytes bytes_;
  std::size_t offset_ = 0;
  std::size_t line_ = 0;
};

[[nodiscard]] inline std::string_view as_text(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace colift::hal
