#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/types/result.hpp"

namespace colift::tools {

/// A JSON value with its place in the text. nlohmann's own tree forgets places and takes the last of two
/// equal keys.
struct JsonNode {
  enum class Kind { Null, Boolean, Number, String, Array, Object };
  Kind kind = Kind::Null;
  std::uint32_t at = 0;  ///< Offset of its first character.
  double number = 0.0;
  std::vector<JsonNode> items;
  /// A string's text, or the keys of an object beside its items; apart, because most nodes are numbers.
  std::unique_ptr<std::vector<std::string>> texts;

  /// What an error says was found: "a list of 3".
  [[nodiscard]] std::string found() const;
};

/// Reads one JSON document from an untrusted source. Refuses what nlohmann's own tree lets pass: equal keys
/// in one object, nesting beyond 16 levels, more than five million values, numbers beyond the doubles.
/// Errors: BadInput; where = "name:line:column".
[[nodiscard]] hal::Result<JsonNode> parse_json_tree(std::string_view text, const std::string& name);

/// BadInput at an offset of the text, as "name:line:column".
[[nodiscard]] tl::unexpected<hal::Error> failure_at(std::string_view text, const std::string& name,
                                                    std::size_t at, std::string why);

/// Somebody else's text, short and without control characters, fit for one line of an error.
[[nodiscard]] std::string shown(std::string text);

}  // namespace colift::tools
