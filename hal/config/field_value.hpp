#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <tl/expected.hpp>

#include "hal/config/field_table.hpp"
#include "hal/config/yaml_tree.hpp"

namespace colift::hal {

/// What is wrong with a value, and where it stands in the file.
struct Objection {
  YamlPlace place;
  std::string
      reason;  ///< Ends a sentence that begins with the field's name: "expects a number, but found a map".
};

/// The value for `field` that stands at `node`, of the field's type and within its range or choices.
[[nodiscard]] tl::expected<FieldValue, Objection> read_value(const Field& field, const YamlTree& tree,
                                                             std::uint32_t node);

/// Why the field must not hold this value, as in Objection::because; nothing if it may.
[[nodiscard]] std::optional<std::string> objection_to(const Field& field, const FieldValue& value);

/// Writes a value of the field's own type into the struct. Not for a list of structs.
void write_value(const Field& field, const FieldValue& value);

/// A value as YAML on one line. Reading it back gives the same bits.
[[nodiscard]] std::string value_text(const FieldValue& value);

/// "a number from 0 to 90", "one of box, cylinder", "a list of 3 numbers": what a file may give for this
/// field.
[[nodiscard]] std::string expectation(const Field& field);

/// "the text "steep"", "a list of 2", "nothing": what stands at a node.
[[nodiscard]] std::string description(const YamlNode& node);

}  // namespace colift::hal
