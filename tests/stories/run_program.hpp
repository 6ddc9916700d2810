#pragma once

#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

namespace story {

struct ProgramRun {
  int code = -1;
  std::string out, err;
};

/// A folder of this test program.
inline std::filesystem::path scratch() {
  static const std::filesystem::path dir = [] {
    auto d = std::filesystem::temp_directory_path() / ("colift-program-" + std::to_string(::getpid()));
    std::filesystem::create_directories(d);
    return d;
  }();
  return dir;
}

inline std::string slurp(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A program as a user starts it.
inline ProgramRun run_program(const std::filesystem::path& program, const std::string& arguments) {
  const auto out = scratch() / "out", err = scratch() / "err";
  const std::string command = program.string() + " " + arguments + " >" + out.string() + " 2>" + err.string();
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(out), slurp(err)};
}

inline ProgramRun run_colift(const std::string& arguments) {
  return run_program(COLIFT_PROGRAM, arguments);
}

}  // namespace story
