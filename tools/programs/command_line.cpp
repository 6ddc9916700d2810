#include "tools/programs/command_line.hpp"

#include <fmt/format.h>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include <algorithm>
#include <cstdio>
#include <exception>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include "hal/config/nearest_name.hpp"
#include "tools/cli/commands.hpp"
#include "tools/live/live_server.hpp"
#include "tools/programs/programs.hpp"

namespace colift::tools {
namespace {

bool is_port(const std::string& text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// As CLI11's parse() takes them. In `log replay --view FILE` the file is no port: an option with a value that
// may be left out would take it.
std::vector<std::string> last_first(const std::vector<std::string>& words) {
  std::vector<std::string> out;
  for (auto word = words.rbegin(); word != words.rend(); ++word) {
    const bool no_port = *word == "--view" && !out.empty() && !is_port(out.back());
    out.push_back(no_port ? fmt::format("--view={}", live::ServerConfig{}.port) : *word);
  }
  return out;
}

constexpr std::string_view kFor = "--for";
constexpr const char* kConfiguredCommands =
    "run, recover, look, decide, experiment, log replay, calibrate, hal arm, hal hand, hal camera";

bool says_for(const std::string& word) {
  return word == kFor || word.starts_with("--for=");
}

// "run --json --share 0.3" of "check --json --for run --share 0.3".
std::vector<std::string> words_of_command(const std::vector<std::string>& words) {
  std::vector<std::string> before, command;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (!says_for(words[i])) {
      before.push_back(words[i]);
      continue;
    }
    std::string name = words[i] == kFor ? "" : words[i].substr(kFor.size() + 1);
    if (words[i] == kFor && i + 1 < words.size()) name = words[++i];
    std::istringstream parts(name);  // "log replay" in one word
    for (std::string part; parts >> part;) command.push_back(part);
    command.insert(command.end(), words.begin() + static_cast<std::ptrdiff_t>(i) + 1, words.end());
    break;
  }
  // behind the names of command and verb, before its options: a --config before --for stays the earlier one
  const auto options = std::find_if(command.begin(), command.end(),
                                    [](const std::string& word) { return word.starts_with('-'); });
  command.insert(options, before.begin(), before.end());
  return command;
}

// Whose configuration is asked for, does not need what it works on.
void require_nothing(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) option->required(false);
  for (CLI::App* below : app.get_subcommands([](CLI::App*) { return true; })) require_nothing(*below);
}

const CLI::App& deepest(const CLI::App& app) {
  const CLI::App* asked = &app;
  while (!asked->get_subcommands().empty()) asked = asked->get_subcommands().front();
  return *asked;
}

// The option that was most likely meant by the first unknown one in CLI11's message.
std::optional<std::string> nearest_option(const CLI::App& app, std::string_view message) {
  const std::size_t at = message.find(" --");
  if (at == std::string_view::npos) return std::nullopt;
  message.remove_prefix(at + 3);
  const std::string_view unknown = message.substr(0, message.find_first_of("= "));
  std::vector<std::string> known;
  for (const CLI::Option* option : deepest(app).get_options())
    for (const std::string& name : option->get_lnames()) known.push_back(name);
  if (std::find(known.begin(), known.end(), unknown) != known.end()) return std::nullopt;
  const auto nearest = hal::nearest_path(unknown, known);
  return nearest ? std::optional("--" + *nearest) : std::nullopt;
}

std::string full_name(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr || parent->get_parent() == nullptr ? app.get_name()
                                                              : full_name(*parent) + " " + app.get_name();
}

// "\"exprt\" is no command; did you mean \"export\"?" of a command that has some, without one of them.
std::optional<std::string> which_of(const CLI::App& app) {
  const CLI::App& asked = deepest(app);
  std::vector<std::string> names;
  for (const CLI::App* below : asked.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(below->get_name());
  if (names.empty()) return std::nullopt;
  const std::string said = asked.get_parent() == nullptr ? "" : " " + full_name(asked);
  const std::vector<std::string> unknown = app.remaining(true);
  if (unknown.empty())
    return fmt::format("colift{}: expected one of {}; see colift{} --help", said, fmt::join(names, ", "),
                       said);
  const std::string& word = unknown.front();
  const bool option = word.starts_with('-');
  const auto nearest = option ? nearest_option(app, " " + word) : hal::nearest_path(word, names);
  return fmt::format("colift{}: \"{}\" is no {}; {}", said, word, option ? "option" : "command",
                     nearest  ? fmt::format("did you mean \"{}\"?", *nearest)
                     : option ? fmt::format("see colift{} --help", said)
                              : fmt::format("there are {}", fmt::join(names, ", ")));
}

}  // namespace

CommandLine::CommandLine(int argc, char** argv)
    : app_(
          "CoLift carries large objects together with a person: it observes where the person grasps, and "
          "decides\n"
          "where the robot grasps so that both carry their share of the load.") {
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
                  "Overrides one value after the files, as in --set decision.near_partner_m=0.2")
      ->type_name("KEY=VALUE")
      ->take_all()
      ->allow_extra_args(false);
  add_output(parser);
}

std::optional<int> CommandLine::parse(std::vector<std::string> words) {
  const std::string first = words.empty() ? "-" : words.front();
  try {
    app_.parse(last_first(words));
  } catch (const CLI::Success& e) {
    return app_.exit(e);  // --help, --version
  } catch (const CLI::ParseError& e) {
    return refuse(e, first);
  }
  return std::nullopt;
}

int CommandLine::run(int argc, char** argv) {
  const std::vector<std::string> words(argv + 1, argv + std::max(argc, 1));
  if (!words.empty() && words.front() == "check" && std::any_of(words.begin(), words.end(), says_for))
    return check_for(words_of_command(words));
  if (const auto ended = parse(words)) return *ended;
  const auto called =
      std::find_if(runs_.begin(), runs_.end(), [](const Run& r) { return r.parser->parsed(); });
  return called != runs_.end() ? called->run() : static_cast<int>(kInternal);
}

int CommandLine::check_for(std::vector<std::string> words) {
  CheckOptions options;
  options.explain = std::erase(words, "--explain") > 0;
  require_nothing(app_);
  if (const auto ended = parse(std::move(words))) return *ended;
  options.command = full_name(deepest(app_));
  const auto found =
      std::find_if(configured_.begin(), configured_.end(), [](const auto& c) { return c.first->parsed(); });
  if (found == configured_.end()) {
    std::fputs(fmt::format("colift check: --for: {} takes no configuration; these do: {}\n", options.command,
                           kConfiguredCommands)
                   .c_str(),
               stderr);
    return kBadInput;
  }
  CheckedCamera camera;
  if (found->second.robot) camera.robot = found->second.robot();
  return cmd_check(common, options, camera, found->second.config);
}

int CommandLine::refuse(const CLI::ParseError& error, const std::string& first) const {
  if (first[0] == '-' || find_command(first) != nullptr) {
    if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr && first != "-")
      if (const auto which = which_of(app_)) {
        fmt::print(stderr, "{}\n", *which);
        return kBadInput;
      }
    std::string next = "; see colift --help";
    if (dynamic_cast<const CLI::ValidationError*>(&error) != nullptr)
      next.clear();  // it says what would do
    else if (const auto nearest = nearest_option(app_, error.what()))
      next = "; did you mean " + *nearest + "?";
    std::fprintf(stderr, "colift: %s%s\n", error.what(), next.c_str());
    return kBadInput;
  }
  std::vector<std::string> names;
  for (const CommandEntry& c : command_table()) names.emplace_back(c.name);
  const auto nearest = hal::nearest_path(first, names);
  fmt::print(stderr, "colift: \"{}\" is no command; {}\n", first,
             nearest ? fmt::format("did you mean \"{}\"?", *nearest)
                     : fmt::format("there are {}; see colift --help", fmt::join(names, ", ")));
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
