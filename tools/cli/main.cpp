// The program's front. The command line's options stand in command_*.cpp, what a command does in cmd_*.cpp.

#include <cstdio>
#include <exception>

#include "tools/cli/command_line.hpp"

int main(int argc, char** argv) {
  using namespace colift::tools;
  try {
    CommandLine line(argc, argv);
    add_job_commands(line);
    add_sight_commands(line);
    add_device_commands(line);
    add_emulate_commands(line);
    return line.run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "colift: internal error: %s; please report it with the command line\n", e.what());
    return kInternal;
  }
}
