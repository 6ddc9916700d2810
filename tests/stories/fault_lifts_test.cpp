// Whole lifts with faults as `colift experiment faults` injects them: every run that once failed, and faults
// in states where no other story has them (docs/faults.md).

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include "tests/support/fault_table.hpp"
#include "tests/support/thorough.hpp"
#include "tools/experiments/runs/drawn_faults.hpp"
#include "tools/experiments/trials/sighting.hpp"

namespace {

using namespace colift;
using namespace colift::experiments;
using control::Task;

/// A fault in a state, and the state in which the job has to end.
struct Cell {
  const char* row;  ///< Of the fault catalogue.
  Task in;
  double at_s;  ///< Since the state was entered.
  const char *device, *action;
  double for_s;
  Task ends;
  Wire wire = Wire::None;
  const char* puck = "";
  double value = NAN;
};

const Cell kCells[] = {
    {"3 unplugged", Task::Close, 0.3, "camera", "unplug", 30.0, Task::Refused},
    // without a picture nobody knows whether the partner lowers along: the object is held
    {"3 unplugged", Task::Lower, 0.8, "camera", "unplug", 30.0, Task::Stopped},
    {"3 unplugged", Task::Release, 0.1, "camera", "unplug", 30.0, Task::Done},
    {"3 unplugged", Task::Retreat, 1.0, "camera", "unplug", 30.0, Task::Done},
    {"4 library hangs", Task::AwaitPartner, 0.5, "camera", "hang", 1.0, Task::Done},
    {"4 library crashes", Task::Close, 0.2, "camera", "crash", 1.0, Task::Done},
    {"4 library hangs", Task::Lower, 0.5, "camera", "hang", 1.0, Task::Done},
    {"4 library crashes", Task::Release, 0.1, "camera", "crash", 1.0, Task::Done},
    {"4 library hangs", Task::Retreat, 1.0, "camera", "hang", 2.0, Task::Done},
    {"9 half of the pixels missing", Task::Approach, 1.0, "camera", "holes", 2.0, Task::Done},
    {"9 half of the pixels missing", Task::Close, 0.2, "camera", "holes", 2.0, Task::Done},
    {"9 half of the pixels missing", Task::Lift, 0.5, "camera", "holes", 2.0, Task::Done},
    {"9 half of the pixels missing", Task::Hold, 0.2, "camera", "holes", 2.0, Task::Done},
    {"9 half of the pixels missing", Task::Lower, 0.5, "camera", "holes", 2.0, Task::Done},
    {"9 half of the pixels missing", Task::Release, 0.1, "camera", "holes", 2.0, Task::Done},
    {"9 half of the pixels missing", Task::Retreat, 1.0, "camera", "holes", 2.0, Task::Done},
    {"11 camera moved", Task::Approach, 1.0, "camera", "moved", 60.0, Task::Stopped},
    {"11 camera moved", Task::Close, 0.2, "camera", "moved", 60.0, Task::Stopped},
    {"11 camera moved", Task::Lift, 0.5, "camera", "moved", 60.0, Task::Stopped},
    {"11 camera moved", Task::Hold, 0.2, "camera", "moved", 60.0, Task::Stopped},
    {"11 camera moved", Task::Lower, 0.5, "camera", "moved", 60.0, Task::Stopped},
    {"11 camera moved", Task::Release, 0.1, "camera", "moved", 60.0, Task::Stopped},
    {"11 camera moved", Task::Retreat, 1.0, "camera", "moved", 60.0, Task::Stopped},
    {"13 lets go", Task::Close, 0.5, "partner", "let-go", 0.0, Task::Refused},
    {"14 moves his grasp by 5 cm", Task::Close, 0.5, "partner", "move", 0.0, Task::Done},
    {"14 moves his grasp by 5 cm", Task::Lift, 0.5, "partner", "move", 0.0, Task::Done},
    {"14 moves his grasp by 5 cm", Task::Hold, 0.3, "partner", "move", 0.0, Task::Done},
    {"14 moves his grasp by 5 cm", Task::Lower, 0.5, "partner", "move", 0.0, Task::Done},
    {"25 does not open", Task::Approach, 0.0, "hand", "stuck", 60.0, Task::Aborted, Wire::Hand},
    {"25 does not open", Task::Retreat, 0.5, "hand", "stuck", 60.0, Task::Done, Wire::Hand},
    {"27 one puck silent", Task::AwaitPartner, 0.5, "hand", "silent", 60.0, Task::Stopped, Wire::Hand, "F2"},
    {"27 one puck silent", Task::Retreat, 1.0, "hand", "silent", 60.0, Task::Stopped, Wire::Hand, "F2"},
    {"28 too hot", Task::AwaitPartner, 0.5, "hand", "hot", 60.0, Task::Refused, Wire::Hand, "", 75.0},
    {"28 too hot", Task::Release, 0.1, "hand", "hot", 60.0, Task::Stopped, Wire::Hand, "", 75.0},
    {"28 too hot", Task::Retreat, 1.0, "hand", "hot", 60.0, Task::Done, Wire::Hand, "", 75.0},
    {"51 a box is put into the path", Task::Approach, 1.0, "clutter", "0.75", 0.0, Task::Stopped},
    {"51 a box is put into the path", Task::Lift, 0.5, "clutter", "0.75", 0.0, Task::Stopped},
};

/// A few are in every run; every one where it is to be thorough.
bool always(std::size_t i) {
  return i == 1 || (!tests::kSanitized && (i == 14 || i == 27));
}

FaultyScene quick_table() {
  FaultyScene scene;
  scene.scenario = sim_hal::built_in_scenario();
  scene.scenario.partner.arrives_s = 1.7;
  scene.scenario.task.hold_s = 1.0;
  return scene;
}

FaultyLift lift_of(const FaultyScene& scene) {
  auto lift =
      run_faulty_lift(scene, config_for(control::Method::Fast, faulty_task()), control::Method::Fast, 1);
  REQUIRE(lift);
  return std::move(*lift);
}

/// When the lift without a fault comes to a state.
double nominal_s(const std::string& state) {
  static const FaultyLift lift = lift_of(quick_table());
  return lift.entered.at(state);
}

/// Somebody pushes a box from the side to so far from the middle line of the robot.
void push_box(sim_hal::Scenario& scenario, double to_m, double at_s) {
  constexpr double kFrom_m = 2.5, kSpeed_m_s = 1.0;
  sim_hal::ScenarioClutter box;
  box.size = {0.3, 0.3, 0.9};
  const double x = to_m < 0.5 ? 1.1 : 0.5;  // beside the table, or beside the arm
  box.xyz = {x, -kFrom_m, 0.0};
  box.moves.push_back({std::max(0.0, at_s - (kFrom_m - to_m) / kSpeed_m_s), {x, -to_m, 0.0}, kSpeed_m_s});
  scenario.clutter.push_back(box);
}

FaultyScene scene_of(const Cell& cell) {
  FaultyScene scene = quick_table();
  scene.wire = cell.wire;
  const std::string state(control::word(cell.in));
  if (cell.device == std::string("partner")) {
    sim_hal::PartnerScriptEvent event{cell.at_s, cell.action, {}, state};
    if (event.action == "move") event.to = scene.scenario.partner.grasp + hal::Vec3(0.0, 0.05, 0.0);
    scene.scenario.partner.events.push_back(event);
    return scene;
  }
  if (cell.device == std::string("clutter")) {
    push_box(scene.scenario, std::stod(cell.action), nominal_s(state) + cell.at_s);
    return scene;
  }
  sim_hal::DeviceFaultEvent event{cell.at_s, cell.device, cell.action, cell.for_s};
  event.in_state = state;
  event.puck = cell.puck;
  if (!std::isnan(cell.value)) event.value = cell.value;
  scene.scenario.faults.push_back(event);
  return scene;
}

std::string told(const FaultyLift& lift) {
  std::string all = lift.record.reason + "\n";
  for (const auto& s : lift.record.states)
    all += fmt::format("{:.2f} {}: {}\n", hal::seconds(s.at), control::word(s.state), s.reason);
  for (const auto& f : lift.record.faults)
    all += fmt::format("{:.2f} {}: {}\n", hal::seconds(f.at), f.device, f.what);
  return all;
}

struct Kept {
  Trial trial;
  std::string why;
};

std::vector<Kept> kept() {
  std::ifstream file(std::string(COLIFT_SOURCE_DIR) + "/tests/data/kept_faults.txt");
  REQUIRE(file);
  std::vector<Kept> all;
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::istringstream words(line);
    Kept k;
    words >> k.trial.seed >> k.trial.index;
    std::getline(words >> std::ws, k.why);
    all.push_back(std::move(k));
  }
  return all;
}

}  // namespace

TEST_CASE("the faults of devices and partner that are injected here", "[.fault-table]") {
  for (std::size_t i = 0; i < std::size(kCells); ++i)
    tests::print_fault(kCells[i].row, kCells[i].in, always(i));
}

TEST_CASE("runs that once failed end well", "[faults]") {
  constexpr std::size_t kAlways = tests::repetitions(2, 1);
  const std::vector<Kept> all = kept();
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i >= kAlways && !tests::thorough()) break;
    const DrawnTrial drawn = draw_faults(all[i].trial);
    const auto lift = run_faulty_lift(drawn.scene, config_for(control::Method::Fast, faulty_task()),
                                      control::Method::Fast, all[i].trial.own_seed(kFaultyStream));
    REQUIRE(lift);
    INFO(all[i].trial.seed << " " << all[i].trial.index << ": " << all[i].why << "\n" << told(*lift));
    CHECK(fmt::format("{}", fmt::join(objections(*lift, drawn.faults), "; ")) == "");
  }
}

TEST_CASE("a fault in a state where no other story has it ends as it has to, and the judge is silent",
          "[faults]") {
  for (std::size_t i = 0; i < std::size(kCells); ++i) {
    const Cell& cell = kCells[i];
    if (!always(i) && !tests::thorough()) continue;
    const FaultyLift lift = lift_of(scene_of(cell));
    INFO(cell.row << ": " << cell.device << " " << cell.action << " in " << control::word(cell.in) << "\n"
                  << told(lift));
    CHECK(lift.entered.count(std::string(control::word(cell.in))) == 1);
    CHECK(fmt::format("{}", fmt::join(objections(lift, {}), "; ")) == "");
    CHECK(control::word(lift.record.states.back().state) == control::word(cell.ends));
    CHECK_FALSE(lift.hit_something);
  }
}
