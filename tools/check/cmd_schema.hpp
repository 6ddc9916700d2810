#pragma once

#include <string>

namespace colift::tools {

/// Prints the JSON Schema (2020-12) of one document that CoLift writes or reads, from config/schema; without
/// a name those that there are, one per line, as a JSON list with `json`. 0 printed, 2 there is no such
/// document.
[[nodiscard]] int cmd_schema(const std::string& name, bool json);

}  // namespace colift::tools
