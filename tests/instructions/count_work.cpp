// Does one piece of work on a fixed input. instructions.py runs it under callgrind, which counts what happens
// within colift_counted() alone.
#include <fmt/format.h>

#include <string>

#include "counted_work.hpp"

extern "C" [[gnu::noinline]] void colift_counted(const std::function<void()>& work) {
  work();
}

int main(int argc, char** argv) {
  using namespace colift::counted;
  std::vector<Work> works = perception_works();
  for (auto* more : {&planning_works, &simulation_works})
    for (Work& work : more()) works.push_back(std::move(work));
  if (argc == 1) {
    for (const Work& work : works) fmt::print("{}\t{}\n", work.name, work.what);
    return 0;
  }
  for (const Work& work : works) {
    if (work.name != argv[1]) continue;
    colift_counted(work.prepare());
    return 0;
  }
  fmt::print(stderr, "no work is called {}; without an argument they are listed\n", argv[1]);
  return 2;
}
