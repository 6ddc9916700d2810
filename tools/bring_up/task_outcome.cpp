#include "tools/bring_up/task_outcome.hpp"

#include "tools/cli/options.hpp"

namespace colift::tools {

std::string_view to_string(TaskOutcome outcome) {
  switch (outcome) {
    case TaskOutcome::Done:
      return "done";
    case TaskOutcome::Interrupted:
      return "interrupted";
    case TaskOutcome::BadRequest:
      return "bad-request";
    case TaskOutcome::Refused:
      return "refused";
    case TaskOutcome::Stopped:
      return "stopped";
    case TaskOutcome::WrongLoad:
      return "wrong-load";
    case TaskOutcome::NoGrip:
      return "no-grip";
    case TaskOutcome::Lost:
      return "lost";
    case TaskOutcome::Failed:
      return "failed";
  }
  return "";
}

int exit_code(TaskOutcome outcome) {
  switch (outcome) {
    case TaskOutcome::Done:
      return kDone;
    case TaskOutcome::Interrupted:
      return kInterrupted;
    case TaskOutcome::BadRequest:
      return kBadInput;
    case TaskOutcome::Stopped:
    case TaskOutcome::WrongLoad:
    case TaskOutcome::NoGrip:
      return kNoGoal;
    case TaskOutcome::Refused:
    case TaskOutcome::Lost:
    case TaskOutcome::Failed:
      return kDeviceFailed;
  }
  return kInternal;
}

}  // namespace colift::tools
