#pragma once

#include <filesystem>

namespace colift::tools {

/// `colift rank PROBLEM.json`: reads the problem (`-` is stdin), prints the ranking to stdout, as the
/// document colift.rank/1 with `json`, else as a table. Returns the exit code: 0 ranked, even if nothing is
/// feasible; 2 bad input, with one line on stderr; 4 the output could not be written.
[[nodiscard]] int cmd_rank(const std::filesystem::path& problem, bool json);

}  // namespace colift::tools
