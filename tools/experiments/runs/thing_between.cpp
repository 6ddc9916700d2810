#include "tools/experiments/runs/thing_between.hpp"

#include <array>

#include "hal/types/units.hpp"

namespace colift::experiments {
namespace {

constexpr double kThick_m = 0.020, kLong_m = 0.050;
constexpr double kOff_m = 0.001;     // from the object's face
constexpr double kAside_m = 0.0375;  // of a thing under F1 or F2 alone: its end is beside the other one
constexpr double kComesFrom_m = 1.5, kComes_m_s = 3.0, kComesBefore_s = 0.25;
constexpr double kLevel = 0.3, kUpright = 0.95;  // vertical part of a unit vector: at most, at least

}  // namespace

const char* word(Under place) {
  constexpr std::array<const char*, kUnder> kWords{"F1", "F2", "F1 and F2", "F3"};
  return kWords[static_cast<std::size_t>(place)];
}

FirstGrip first_grip(const control::RunRecord& record) {
  FirstGrip grip;
  bool closed = false;
  for (const control::StateChange& s : record.states) {
    if (s.state == control::Task::Close && !closed) {
      closed = true;
      grip.close_s = hal::seconds(s.at);
    } else if (closed && s.state != control::Task::Verify) {
      grip.accepted = s.state == control::Task::AwaitReady;
      grip.why = s.reason;
      break;
    }
  }
  const auto& decision = record.decision;
  if (closed && decision && decision->decision.chosen)
    grip.grasp = decision->candidates[static_cast<std::size_t>(*decision->decision.chosen)];
  return grip;
}

std::optional<sim_hal::ScenarioClutter> thing_between(const planner::GraspCandidate& grasp,
                                                      const planner::HandModel& hand, Under place,
                                                      double close_s) {
  const hal::Vec3 across = grasp.closing.cross(grasp.approach);
  const bool upright = std::abs(across.z()) > kUpright, level = std::abs(grasp.closing.z()) < kLevel;
  const bool flat = std::abs(grasp.closing.z()) > kUpright && std::abs(across.z()) < kLevel;
  if (!upright && !level && !flat) return std::nullopt;
  const bool stands = !upright && level;
  if (stands && place == Under::F1AndF2) return std::nullopt;
  const double x_m =
      place == Under::F1 || place == Under::F2 ? hand.fingers[static_cast<std::size_t>(place)].x_m : 0.0;
  const double aside_m = stands || x_m == 0.0 ? x_m : std::copysign(kAside_m, x_m);
  const double side = place == Under::F3 ? 1.0 : -1.0;
  const hal::Vec3 middle = planner::load_point(grasp) + aside_m * across +
                           side * (0.5 * (grasp.width + kThick_m) + kOff_m) * grasp.closing;
  sim_hal::ScenarioClutter thing;
  double height_m = kThick_m;
  if (flat) {
    thing.size = {kLong_m, kThick_m, kThick_m};
    thing.yaw_deg = hal::rad_to_deg(std::atan2(across.y(), across.x()));
  } else {
    height_m = stands ? 2.0 * kThick_m : kLong_m;
    thing.shape = "cylinder";
    thing.size = {0.5 * kThick_m, height_m};
  }
  const hal::Vec3 to = middle - 0.5 * height_m * hal::Vec3::UnitZ();
  // from above, or from the side on which it ends up
  const bool down = upright ? across.z() < 0.0 : aside_m < 0.0;
  thing.xyz = to + (down ? -kComesFrom_m : kComesFrom_m) * across;
  thing.moves = {{close_s - kComesBefore_s, to, kComes_m_s}};
  return thing;
}

}  // namespace colift::experiments
