#pragma once

#include <functional>
#include <string>
#include <vector>

namespace colift::counted {

/// A piece of work on a fixed input, whose instructions are counted.
struct Work {
  std::string name;  ///< As in instructions.json.
  std::string what;  ///< For people.
  /// Prepares the input, which is not counted, and returns what is. May be called once.
  std::function<std::function<void()>()> prepare;
};

[[nodiscard]] std::vector<Work> perception_works();
[[nodiscard]] std::vector<Work> planning_works();
[[nodiscard]] std::vector<Work> simulation_works();

}  // namespace colift::counted
