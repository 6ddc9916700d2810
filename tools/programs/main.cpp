// `colift`: starts the program that has the command, as git does. It links nothing that is slow to load: a
// command waits for its own program's libraries alone.

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "tools/programs/programs.hpp"

int main(int argc, char** argv) {
  using namespace colift::tools;
  const std::vector<std::string> words(argv + 1, argv + std::max(argc, 1));
  if (words.size() == 1 && words.front() == "--version") {
    std::puts("colift " COLIFT_VERSION);
    return 0;
  }
  return become(program_for(words), argv);
}
