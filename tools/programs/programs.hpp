#pragma once

#include <span>
#include <string>
#include <string_view>

namespace colift::tools {

/// A command of `colift`, and the program beside it that has it and is started in its place, as git does. A
/// simulated lift needs only `colift-simulate`; the others are built after it.
struct CommandEntry {
  const char* name;
  const char* program;  ///< "colift-simulate", "colift-log", ...
  const char* help;
};

/// Every command, in the order of `colift --help`.
[[nodiscard]] std::span<const CommandEntry> command_table();

/// The command whose program answers: the first word, but for `check --for COMMAND` that COMMAND, whose
/// options only its own program knows. `words` without the program's name; empty when there is none.
[[nodiscard]] std::string_view command_asked_for(std::span<const std::string> words);

/// nullptr: there is no such command.
[[nodiscard]] const CommandEntry* find_command(std::string_view name);

/// The program for this call: a run with devices on wires, a recording or a live view is `colift-run`'s; the
/// help of all commands, and what is wrong with a call without a known one, are `colift-simulate`'s.
[[nodiscard]] const char* program_for(std::span<const std::string> words);

/// Continues as `program` with the same arguments: same terminal, signals and exit code. Returns only where
/// that is not possible, with the exit code, and has said why.
[[nodiscard]] int become(const char* program, char** argv);

}  // namespace colift::tools
