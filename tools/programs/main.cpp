// The program's front: has `run` in simulation itself and starts the program that has the command otherwise.
// The command line's options stand in command_*.cpp, what a command does in cmd_*.cpp.

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "tools/programs/programs.hpp"
#include "tools/programs/run_program.hpp"

int main(int argc, char** argv) {
  using namespace colift::tools;
  const std::vector<std::string> words(argv + 1, argv + std::max(argc, 1));
  if (const CommandEntry* command = find_command(command_asked_for(words));
      command && std::strcmp(program_for(*command, words), "colift"))
    return become(*command, program_for(*command, words), argv);
  return run_program(argc, argv, add_simulated_job);
}
