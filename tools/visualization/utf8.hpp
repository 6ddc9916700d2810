#pragma once

#include <string>

namespace colift::picture {

/// Whether a byte continues a character that an earlier byte began.
[[nodiscard]] constexpr bool continues_character(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0u) == 0x80u;
}

/// The text with a question mark for every byte that is no UTF-8, and spaces for control characters except
/// line ends. File names may hold any bytes; a picture or page with them would be refused as a whole.
[[nodiscard]] std::string valid_utf8(const std::string& text);

}  // namespace colift::picture
