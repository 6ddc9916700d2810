#pragma once

#include <string>

#include "control/task/task_context.hpp"

namespace colift::control {

/// Which forces the arm has to expect in a state.
[[nodiscard]] HandLoad expected_load(Task task);

/// Who or what an unexpected force on a loaded hand comes from, by its direction, as the begin of a sentence;
/// empty where that is not known.
[[nodiscard]] std::string presumed_source(const TaskContext& c, const ForceFinding& force);

}  // namespace colift::control
