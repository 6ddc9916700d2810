#pragma once

#include <ctime>
#include <string>

namespace colift::tools {

/// Now, as ISO 8601 in UTC, for files that say when they were made.
[[nodiscard]] inline std::string today() {
  const std::time_t now = std::time(nullptr);
  char text[32] = "";
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

}  // namespace colift::tools
