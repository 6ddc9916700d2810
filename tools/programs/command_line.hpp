#pragma once

#include <CLI/App.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/config/resolve_config.hpp"
#include "tools/cli/options.hpp"
#include "tools/programs/run_program.hpp"

namespace colift::tools {

/// A program's command line: a parser (CLI11) and its commands. Each group of commands adds itself, with
/// its options and what it runs.
class CommandLine {
 public:
  CommandLine(int argc, char** argv);

  /// A command of the program; its line of help stands in programs.cpp.
  CLI::App& command(const std::string& name);
  /// The commands that other programs have, for --help.
  void add_others();
  /// `run` gives the exit code when `parser` was what the user called.
  void when(CLI::App& parser, std::function<int()> run) { runs_.push_back({&parser, std::move(run)}); }

  /// What `check --for` shows of a command: its configuration, and the robot whose calibration belongs to it.
  struct Configured {
    std::function<hal::Result<control::ResolvedConfig>()> config;
    std::function<std::optional<std::filesystem::path>()> robot = {};
  };
  void configured(CLI::App& parser, Configured what) { configured_.emplace_back(&parser, std::move(what)); }

  /// --json and --quiet.
  void add_output(CLI::App& parser);
  /// Also --config and --set.
  void add_common(CLI::App& parser);

  /// Parses and runs what was asked for. The exit code.
  [[nodiscard]] int run(int argc, char** argv);

  CommonOptions common;

 private:
  struct Run {
    CLI::App* parser;
    std::function<int()> run;
  };
  [[nodiscard]] std::optional<int> parse(std::vector<std::string> words);
  /// `check --for COMMAND ...`: `words` without "check" and "--for".
  [[nodiscard]] int check_for(std::vector<std::string> words);
  [[nodiscard]] int refuse(const CLI::ParseError& error, const std::string& first) const;

  CLI::App app_;
  std::vector<Run> runs_;
  std::vector<std::pair<CLI::App*, Configured>> configured_;
};

/// --scenario and --robot: a path, or the name of a shipped file.
CLI::Option* add_scenario(CLI::App& parser, std::optional<std::filesystem::path>& file,
                          const std::string& help);
CLI::Option* add_robot(CLI::App& parser, std::optional<std::filesystem::path>& file, const std::string& help);
/// A recorded frame: a path, the folder of a scene, or the name of a shipped one.
CLI::Option* add_frame(CLI::App& parser, const char* option, std::filesystem::path& file,
                       const std::string& help);

/// --view and what belongs to it, for `run` and `log replay`.
void add_view(CLI::App& parser, ViewOptions& options);

/// --ros2-domain and --ros2-interface, for `run` and `ros2`.
void add_ros2_place(CLI::App& command, Ros2Options& options);

}  // namespace colift::tools
