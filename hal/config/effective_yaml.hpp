#pragma once

#include <string>

#include "hal/config/field_table.hpp"

namespace colift::hal {

/// The whole configuration as nested YAML. Loading it gives the same values, doubles to the bit. Behind each
/// value, as a comment, its origin; with `with_help` also a line above with what it means and what it may be.
[[nodiscard]] std::string effective_yaml(const FieldTable& table, bool with_help);

}  // namespace colift::hal
