#include "control/task/runner/expected_force.hpp"

namespace colift::control {

HandLoad expected_load(Task task) {
  switch (task) {
    case Task::Close:
    case Task::Verify:
    case Task::AwaitReady:
      return HandLoad::Closing;
    case Task::TestLift:
    case Task::Lift:
    case Task::Hold:
    case Task::Pause:
      return HandLoad::Carried;
    case Task::Lower:
    case Task::Release:
      return HandLoad::Lowering;
    default:
      return HandLoad::Empty;
  }
}

std::string presumed_source(const TaskContext& c, const ForceFinding& force) {
  using Kind = ForceFinding::Kind;
  constexpr double kAlong = 0.8;  // cosine
  if (!is_loaded(c.state) || !c.record.decision || !c.record.decision->partner) return {};
  if (force.kind == Kind::Up) return "the object or the hand meets something from below: ";
  if (force.kind == Kind::Down) return "sudden gain of load: ";
  if (force.kind != Kind::Sideways) return {};
  const Eigen::Vector2d to_partner =
      (c.record.decision->partner->position - c.palm().translation()).head<2>().normalized();
  const double along = force.force_W.head<2>().normalized().dot(to_partner);
  if (along > kAlong) return "the partner's end is pulled: ";
  if (along < -kAlong) return "the partner's end is pushed: ";
  return "pushed across the object: ";
}

}  // namespace colift::control
