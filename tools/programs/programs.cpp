#include "tools/programs/programs.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "tools/cli/options.hpp"

namespace colift::tools {
namespace {

constexpr const char* kSimulate = "colift-simulate";

constexpr CommandEntry kCommands[] = {
    {"run", kSimulate,
     "One complete co-lift: observe, decide, approach, lift together, lower, release, retreat"},
    {"log", "colift-log", "Recordings of runs"},
    {"experiment", "colift-experiment",
     "Repeats the experiments of the thesis's chapter 6 in simulation: tables, figures with intervals, a "
     "page"},
    {"look", "colift-analyse",
     "Perception of one recorded frame: ground, target, surfaces, grasp candidates"},
    {"decide", "colift-analyse", "look, then the robot's grasp for the partner's grasp, with the reason"},
    {"scene", "colift-analyse",
     "What look, decide and the object follower say of recorded scenes, beside their truth"},
    {"rank", "colift-analyse", "The load-sharing decision alone, for a problem given as numbers"},
    {"check", "colift-analyse", "Prints the configuration that a command would use; touches no device"},
    {"scenarios", "colift-analyse", "The scenarios that --scenario takes by name"},
    {"robots", "colift-analyse", "The robot files that --robot takes by name"},
    {"scenes", "colift-analyse", "The recorded frames that look and decide take by name"},
    {"schema", "colift-analyse", "The JSON Schema of a document that --json prints, or that a command reads"},
    {"hal", "colift-bring-up", "Bring-up of one device at a time"},
    {"calibrate", "colift-bring-up",
     "Camera-to-arm calibration: a blinking emitter on the palm, observed at many poses of the arm"},
    {"recover", "colift-bring-up",
     "After a stop: the state of arm, hand and load; in confirmed steps to lowered, released, home"},
    {"doctor", "colift-bring-up", "Checks this machine; each finding with the command that repairs it"},
    {"ros2", "colift-ros2", "Answers requests of ROS 2 nodes for decisions"},
    {"emulate", "colift-emulate", "Emulates a device at the far end of its wire"},
};

}  // namespace

std::span<const CommandEntry> command_table() {
  return kCommands;
}

std::string_view command_asked_for(std::span<const std::string> words) {
  if (words.empty()) return {};
  if (words.front() != "check") return words.front();
  for (std::size_t i = 1; i < words.size(); ++i) {
    std::string_view name = words[i];
    if (name == "--for" && i + 1 < words.size())
      name = words[i + 1];
    else if (name.starts_with("--for="))
      name.remove_prefix(std::string_view("--for=").size());
    else
      continue;
    return name.substr(0, name.find(' '));  // "log replay" in one word
  }
  return words.front();
}

const CommandEntry* find_command(std::string_view name) {
  const auto found = std::find_if(std::begin(kCommands), std::end(kCommands),
                                  [&](const CommandEntry& c) { return c.name == name; });
  return found == std::end(kCommands) ? nullptr : found;
}

const char* program_for(std::span<const std::string> words) {
  const CommandEntry* command = find_command(command_asked_for(words));
  if (command == nullptr) return kSimulate;
  // the beginnings of the options that `colift-simulate` leaves to the other program; one too many costs
  // nothing, it has them all
  constexpr std::string_view kOthers[] = {"--robot", "--record", "--flight", "--view", "--allow-", "--ros2"};
  if (std::strcmp(command->name, "run") != 0 || words.front() != "run") return command->program;
  for (const std::string_view word : words)
    for (const std::string_view option : kOthers)
      if (word.starts_with(option)) return "colift-run";
  return command->program;
}

int become(const char* program_name, char** argv) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto program = self.parent_path() / program_name;
  ::execv(program.c_str(), argv);
  const int why = errno;
  if (why == ENOENT)
    std::fprintf(stderr, "colift: %s is not there yet; tools/build builds it\n", program.c_str());
  else
    std::fprintf(stderr, "colift: %s cannot be started: %s\n", program.c_str(), std::strerror(why));
  return kInternal;
}

}  // namespace colift::tools
