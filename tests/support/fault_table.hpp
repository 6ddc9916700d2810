#pragma once

#include <cstdio>
#include <string_view>

#include "control/task/machine/task_machine.hpp"

namespace colift::tests {

/// One fault that a program of whole lifts injects, for docs/faults.md: `row` begins with its number in the
/// fault catalogue, `always` says whether every test run injects it, or COLIFT_THOROUGH=1 alone.
/// tests/docs/fault_table.py reads the line. Printed by the hidden test case "[.fault-table]" from the same
/// tables that the test cases go through.
inline void print_fault(std::string_view row, control::Task in, bool always) {
  const std::string_view state = control::word(in);
  std::printf("fault\t%.*s\t%.*s\t%s\n", static_cast<int>(row.size()), row.data(),
              static_cast<int>(state.size()), state.data(), always ? "always" : "thorough");
}

}  // namespace colift::tests
