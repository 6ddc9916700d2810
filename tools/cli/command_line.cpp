#include "tools/cli/command_line.hpp"

#include <fmt/format.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <stdexcept>

#include "tools/cli/programs.hpp"
#include "tools/live/live_server.hpp"

namespace colift::tools {
namespace {

bool is_port(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// As CLI11's parse() takes them. In `log replay --view FILE` the file is no port: an option with a value that
// may be left out would take it.
std::vector<std::string> last_first(int argc, char** argv) {
  std::vector<std::string> words;
  for (int i = argc - 1; i > 0; --i) {
    const std::string word = argv[i];
    const bool no_port = word == "--view" && !words.empty() && !is_port(words.back());
    words.push_back(no_port ? fmt::format("--view={}", live::ServerConfig{}.port) : word);
  }
  return words;
}

}  // namespace

CommandLine::CommandLine(int argc, char** argv)
    : app_(
          "CoLift carries large objects together with a person: it sees where the person grasps, and "
          "decides\n"
          "where the robot takes hold so that both carry their share.") {
  app_.name("colift");
  app_.set_version_flag("--version", "colift " COLIFT_VERSION);
  app_.require_subcommand(1);
  app_.failure_message(CLI::FailureMessage::help);
  for (int i = 0; i < argc; ++i) common.command += (i ? " " : "") + std::string(argv[i]);
}

CLI::App& CommandLine::command(const std::string& name) {
  const CommandEntry* entry = find_command(name);
  if (entry == nullptr) throw std::logic_error("the command " + name + " is missing in programs.cpp");
  return *app_.add_subcommand(name, entry->help);
}

void CommandLine::add_others() {
  const auto mine = app_.get_subcommands([](const CLI::App*) { return true; });
  for (const CommandEntry& entry : command_table())
    if (std::none_of(mine.begin(), mine.end(),
                     [&](const CLI::App* c) { return c->get_name() == entry.name; }))
      app_.add_subcommand(entry.name, entry.help);
}

void CommandLine::add_output(CLI::App& parser) {
  parser.add_flag("--json", common.json, "Prints one JSON document to stdout and nothing else");
  parser.add_flag("--quiet", common.quiet, "Prints only the result");
}

void CommandLine::add_common(CLI::App& parser) {
  parser
      .add_option("--config", common.config_files,
                  "Configuration file (YAML); may be given several times, the later one wins")
      ->type_name("FILE")
      ->take_all()
      ->allow_extra_args(false);
  parser
      .add_option("--set", common.settings,
                  "Sets one value over the files, as in --set decision.near_partner_m=0.2")
      ->type_name("KEY=VALUE")
      ->take_all()
      ->allow_extra_args(false);
  add_output(parser);
}

int CommandLine::run(int argc, char** argv) {
  try {
    app_.parse(last_first(argc, argv));
  } catch (const CLI::Success& e) {
    return app_.exit(e);  // --help, --version
  } catch (const CLI::ParseError& e) {
    return refuse(e, argc > 1 ? argv[1] : "-");
  }
  const auto called =
      std::find_if(runs_.begin(), runs_.end(), [](const Run& r) { return r.parser->parsed(); });
  return called != runs_.end() ? called->run() : static_cast<int>(kInternal);
}

int CommandLine::refuse(const CLI::ParseError& error, const std::string& first) const {
  if (first[0] == '-' || find_command(first) != nullptr) {
    std::fprintf(stderr, "colift: %s; see colift --help\n", error.what());
    return kBadInput;
  }
  std::string names;
  for (const CommandEntry& c : command_table()) names += (names.empty() ? "" : ", ") + std::string(c.name);
  std::fprintf(stderr, "colift: \"%s\" is no command; there are %s; see colift --help\n", first.c_str(),
               names.c_str());
  return kBadInput;
}

int run_program(int argc, char** argv, void (*add_commands)(CommandLine& line)) {
  try {
    CommandLine line(argc, argv);
    add_commands(line);
    return line.run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "colift: internal error: %s; please report it with the command line\n", e.what());
    return kInternal;
  }
}

}  // namespace colift::tools
