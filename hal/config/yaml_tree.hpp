#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hal/types/result.hpp"

namespace colift::hal {

/// A place in a text, both counted from 1.
struct YamlPlace {
  int line = 1;
  int column = 1;
};

/// One node of a document: a scalar as it stands in the text, or the children of a list or map.
struct YamlNode {
  enum class Kind { Null, Plain, Quoted, List, Map };
  Kind kind = Kind::Null;
  YamlPlace place;
  std::string text;                     ///< Of Plain and Quoted.
  std::vector<std::uint32_t> children;  ///< Indices into the tree; key, value, key, value, ... in a Map.
};

/// One YAML document. An alias is the index of its anchor, so nodes may be shared, but never in a circle.
struct YamlTree {
  std::vector<YamlNode> nodes;
  std::uint32_t root = 0;

  [[nodiscard]] const YamlNode& at(std::uint32_t index) const { return nodes[index]; }
};

inline constexpr std::size_t kMaxYamlBytes = 1 << 20;
inline constexpr std::size_t kMaxYamlNodes = 100'000;
inline constexpr int kMaxYamlDepth = 32;

/// Parses a text that nobody has looked at before: bytes that are no text, more than one document, tags, keys
/// that are not plain names, and anything beyond the limits above is refused, before it can cost memory or
/// stack. An empty text is a Null root. `name` is the file's, for error messages. Errors: BadConfig with
/// name:line:column.
[[nodiscard]] Result<YamlTree> parse_yaml(std::string_view text, const std::string& name);

/// "name:line:column".
[[nodiscard]] std::string place_text(const std::string& name, YamlPlace place);

/// Whether every byte belongs to a UTF-8 sequence (RFC 3629).
[[nodiscard]] bool is_utf8(std::string_view text);

/// A text from outside as it may stand in a message: one line, control characters shown as '?', cut where too
/// long.
[[nodiscard]] std::string quotable(std::string_view text, std::size_t longest = 60);

}  // namespace colift::hal
