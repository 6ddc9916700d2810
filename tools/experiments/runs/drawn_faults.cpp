#include "tools/experiments/runs/drawn_faults.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iterator>
#include <numbers>

#include "sim_hal/synthetic/hash_random.hpp"
#include "tools/experiments/trials/layouts.hpp"

namespace colift::experiments {
namespace {

using sim_hal::DeviceFaultEvent;
using sim_hal::Draws;
using sim_hal::PartnerScriptEvent;
using sim_hal::Scenario;
using sim_hal::ScenarioPerson;

constexpr double kHeight_m = 0.05, kHold_s = 1.0;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// A state, how long it lasts in an undisturbed lift (s), and how often it is drawn.
struct Window {
  const char* state;
  double lasts_s;
  int weight;
};
constexpr Window kWindows[] = {{"await-partner", 2.4, 2}, {"approach", 4.5, 4},    {"close", 1.4, 2},
                               {"verify", 0.3, 1},        {"await-ready", 0.5, 1}, {"lift", 2.3, 4},
                               {"hold", 1.0, 3},          {"lower", 3.2, 3},       {"release", 0.6, 2},
                               {"retreat", 4.5, 3}};

/// A way in which a device fails: how long, and how much where that has a meaning.
struct DeviceKind {
  const char* action;
  double min_s, max_s;
  double low = NAN, high = NAN;
  Demand demand = Demand::None;
};
constexpr DeviceKind kCamera[] = {{"drop", 0.1, 4.0, NAN, NAN, Demand::NoGrip},
                                  {"freeze", 0.1, 4.0, NAN, NAN, Demand::NoGrip},
                                  {"blind", 0.1, 4.0, NAN, NAN, Demand::NoGrip},
                                  {"corrupt", 0.1, 4.0, NAN, NAN, Demand::NoGrip},
                                  {"unplug", 0.1, 30.0, NAN, NAN, Demand::NoGrip},
                                  {"crash", 0.1, 4.0, NAN, NAN, Demand::NoGrip},
                                  {"zeros", 0.1, 4.0, NAN, NAN, Demand::NoGrip},
                                  {"late", 0.1, 4.0},
                                  {"slow", 0.5, 10.0},
                                  {"holes", 0.5, 10.0},
                                  {"moved", 0.5, 30.0}};
// not "late": a simulated arm that delivers its cycles late still takes steps of one regular cycle only
constexpr DeviceKind kSimArm[] = {{"drop", 0.005, 2.0, NAN, NAN, Demand::Rest},
                                  {"freeze", 0.05, 2.0, NAN, NAN, Demand::Rest},
                                  {"corrupt", 0.005, 1.0, NAN, NAN, Demand::Rest},
                                  {"unplug", 0.1, 2.0, NAN, NAN, Demand::Rest}};
constexpr DeviceKind kSimHand[] = {{"drop", 0.02, 3.0},
                                   {"freeze", 0.02, 3.0},
                                   {"corrupt", 0.02, 3.0},
                                   {"unplug", 0.1, 3.0, NAN, NAN, Demand::Rest},
                                   {"late", 0.1, 3.0}};
constexpr DeviceKind kKrc[] = {{"loss", 0.1, 0.1, 1.0, 40.0},
                               {"delay", 0.1, 1.0, 1.0, 20.0},
                               {"reorder", 0.1, 1.0},
                               {"duplicate", 0.1, 2.0},
                               {"corrupt", 0.01, 0.5},
                               {"burst", 0.1, 0.1, 2.0, 50.0},
                               {"quality", 0.1, 2.0, 0.0, 1.99},
                               {"monitor", 0.1, 1.0, NAN, NAN, Demand::Rest},
                               {"emergency-stop", 0.1, 2.0, NAN, NAN, Demand::Rest},
                               {"drive-error", 0.1, 2.0, NAN, NAN, Demand::Rest},
                               {"drive-warning", 0.1, 3.0},
                               {"drives-off", 0.1, 2.0, NAN, NAN, Demand::Rest},
                               {"temperature", 0.1, 5.0, 60.0, 110.0},
                               {"freeze", 0.05, 2.0, NAN, NAN, Demand::Rest},
                               {"jump", 0.01, 0.5, -0.5, 0.5},
                               {"nan", 0.002, 0.5},
                               {"torque-offset", 0.1, 3.0, -40.0, 40.0},
                               {"contact", 0.1, 2.0, 20.0, 150.0},
                               {"unplug", 0.1, 2.0, NAN, NAN, Demand::Rest}};
constexpr DeviceKind kPucks[] = {{"silent", 0.02, 30.0},
                                 {"loss", 0.1, 5.0, 1.0, 100.0},
                                 {"late", 0.1, 3.0, 1.0, 50.0},
                                 {"duplicate", 0.1, 3.0},
                                 {"wrong", 0.1, 3.0},
                                 {"reset", 0.1, 0.1},
                                 {"error", 0.1, 30.0, 1.0, 20.0},
                                 {"hot", 1.0, 30.0, 55.0, 80.0},
                                 {"stuck", 0.2, 10.0},
                                 {"freeze", 0.1, 5.0},
                                 {"jump", 0.1, 1.0, -30000.0, 30000.0}};
constexpr DeviceKind kBus[] = {{"brown-out", 0.1, 0.5},
                               {"off", 0.1, 3.0},
                               {"foreign", 0.1, 5.0},
                               {"bus-off", 0.1, 30.0, NAN, NAN, Demand::Rest},
                               {"down", 0.1, 30.0, NAN, NAN, Demand::Rest},
                               {"noise", 0.1, 3.0},
                               {"full", 0.1, 10.0},
                               {"passive", 0.1, 3.0}};

template <std::size_t N>
const DeviceKind& one_of(Draws& draws, const DeviceKind (&kinds)[N]) {
  return kinds[draws.below(static_cast<int>(N))];
}

const Window& window(Draws& draws) {
  int all = 0;
  for (const Window& w : kWindows) all += w.weight;
  int at = draws.below(all);
  for (const Window& w : kWindows)
    if ((at -= w.weight) < 0) return w;
  return kWindows[0];
}

/// Makes one fault after another for a scene.
class FaultDraws {
 public:
  FaultDraws(Draws& draws, DrawnTrial& trial) : draws_(draws), trial_(trial) {}

  void draw() {
    const Window& w = window(draws_);
    DrawnFault f;
    f.in_state = w.state;
    f.at_s = draws_.between(0.0, w.lasts_s);
    const int group = draws_.below(16);
    if (group < 3) {
      device(std::move(f), "camera", one_of(draws_, kCamera));
    } else if (group < 6) {
      const bool wired = trial_.scene.wire == Wire::Arm;
      device(std::move(f), "arm", wired ? one_of(draws_, kKrc) : one_of(draws_, kSimArm));
    } else if (group < 9) {
      hand(std::move(f));
    } else if (group < 11) {
      push(std::move(f));
    } else if (group < 13) {
      partner(std::move(f));
    } else if (group < 14) {
      person(std::move(f));
    } else if (group < 15) {
      clutter(std::move(f));
    } else {
      operator_ends(std::move(f));
    }
  }

 private:
  void device(DrawnFault f, const std::string& name, const DeviceKind& kind, const std::string& puck = "") {
    DeviceFaultEvent event;
    event.in_state = f.in_state;
    event.at_s = f.at_s;
    event.for_s = f.for_s = draws_.between(kind.min_s, kind.max_s);
    event.device = name;
    event.action = kind.action;
    event.puck = puck;
    if (!std::isnan(kind.low)) event.value = std::floor(10.0 * draws_.between(kind.low, kind.high)) / 10.0;
    if (event.value && (event.action == "quality" || event.action == "loss" || event.action == "burst" ||
                        event.action == "error"))
      event.value = std::floor(*event.value);
    f.group = name;
    f.what = fmt::format("{} {}", name, kind.action);
    if (!puck.empty()) f.what += " " + puck;
    if (event.value) f.what += fmt::format(" {:g}", *event.value);
    f.what += fmt::format(", {:.2f} s", f.for_s);
    f.demand = kind.demand;
    trial_.scene.scenario.faults.push_back(std::move(event));
    trial_.faults.push_back(std::move(f));
  }

  void hand(DrawnFault f) {
    if (trial_.scene.wire != Wire::Hand) return device(std::move(f), "hand", one_of(draws_, kSimHand));
    if (draws_.chance(0.4)) return device(std::move(f), "hand", one_of(draws_, kBus));
    static constexpr const char* kNames[] = {"F1", "F2", "F3", "spread", ""};
    const char* puck = kNames[draws_.below(5)];
    device(std::move(f), "hand", one_of(draws_, kPucks), puck);
  }

  void push(DrawnFault f) {
    DeviceFaultEvent event;
    event.in_state = f.in_state;
    event.at_s = f.at_s;
    event.for_s = f.for_s = draws_.between(0.05, 2.0);
    event.device = "arm";
    event.action = "push";
    event.link = draws_.chance(0.5) ? 0 : 3 + draws_.below(5);
    const double force_n = std::floor(draws_.between(20.0, 200.0));
    event.value = force_n;
    const double turn = draws_.between(0.0, kTwoPi), up = draws_.between(-1.0, 1.0);
    event.direction = {std::cos(turn), std::sin(turn), up};
    f.group = "force";
    f.what = fmt::format("push {:.0f} N on {}, {:.2f} s", force_n,
                         event.link == 0 ? "the hand" : fmt::format("link {}", event.link), f.for_s);
    // on the hand; nearer to the base a push has little lever
    if (event.link == 0 && force_n > 120.0 && f.for_s > 0.3) f.demand = Demand::NotLifted;
    trial_.scene.scenario.faults.push_back(std::move(event));
    trial_.faults.push_back(std::move(f));
  }

  void partner(DrawnFault f) {
    Scenario& s = trial_.scene.scenario;
    PartnerScriptEvent event;
    event.in_state = f.in_state;
    event.at_s = f.at_s;
    static constexpr const char* kActions[] = {"let-go", "let-go",      "stumble",
                                               "move",   "steps-aside", "second-hand"};
    event.action = kActions[draws_.below(static_cast<int>(std::size(kActions)))];
    f.what = "partner " + event.action;
    if (event.action == "stumble") {
      event.force_n = std::floor(draws_.between(20.0, 150.0));
      event.for_s = f.for_s = draws_.between(0.1, 1.0);
      f.what += fmt::format(" {:.0f} N, {:.2f} s", event.force_n, f.for_s);
    }
    // along his edge: mostly still on the object, else he cannot grasp there
    const double aside_m = draws_.between(-0.15, 0.15);
    if (event.action == "move" || event.action == "second-hand") {
      event.to = s.partner.grasp + (s.object.kind == "chair" ? hal::Vec3(aside_m, 0, 0)
                                    : s.object.kind == "cylinder" || s.object.kind == "box"
                                        ? hal::Vec3(-std::abs(aside_m), 0, 0)
                                        : hal::Vec3(0, aside_m, 0));
      f.what += fmt::format(" {:.0f} cm", 100.0 * aside_m);
    }
    f.group = "partner";
    s.partner.events.push_back(std::move(event));
    trial_.faults.push_back(std::move(f));
  }

  void person(DrawnFault f) {
    Scenario& s = trial_.scene.scenario;
    if (s.people.size() >= 2) return push(std::move(f));
    ScenarioPerson p;
    p.in_state = f.in_state;
    p.enters_s = f.at_s;
    const double side = draws_.chance(0.5) ? 1.0 : -1.0;
    p.path = {{draws_.between(-0.5, 1.5), side * 2.6},
              {draws_.between(0.0, 1.0), side * draws_.between(0.6, 1.3)}};
    p.speed = draws_.between(0.5, 1.6);
    static constexpr const char* kActions[] = {"walk", "stand", "crouch", "reach"};
    p.action = kActions[draws_.below(4)];
    if (p.action == "reach") {
      static constexpr const char* kTargets[] = {"robot-hand", "object"};
      p.reach_to = kTargets[draws_.below(2)];
    }
    if (draws_.chance(0.6)) p.leaves_s = draws_.between(3.0, 8.0);
    f.group = "people";
    f.what = fmt::format("a person who comes with {:.1f} m/s to {:.1f} m: {}", p.speed,
                         std::abs(p.path.back().y()), p.action);
    // who stays may stand until after the job
    s.people.push_back(std::move(p));
    trial_.faults.push_back(std::move(f));
  }

  void clutter(DrawnFault f) {
    sim_hal::ScenarioClutter box;
    box.size = {0.35, 0.35, 0.9};
    const double side = draws_.chance(0.5) ? 1.0 : -1.0;
    box.xyz = {draws_.between(0.2, 0.8), side * 2.5, 0.0};
    sim_hal::ClutterMove move;
    move.at_s = f.at_s = draws_.between(3.0, 18.0);
    move.to = {box.xyz.x(), side * draws_.between(0.5, 1.0), 0.0};
    move.speed = draws_.between(0.3, 1.2);
    f.in_state.clear();
    f.group = "clutter";
    f.what = fmt::format("a box pushed to {:.2f} m with {:.1f} m/s", std::abs(move.to.y()), move.speed);
    box.moves.push_back(move);
    trial_.scene.scenario.clutter.push_back(std::move(box));
    trial_.faults.push_back(std::move(f));
  }

  void operator_ends(DrawnFault f) {
    f.in_state.clear();
    f.at_s = draws_.between(0.5, 20.0);
    if (trial_.scene.interrupted_s) return;
    trial_.scene.interrupted_s = f.at_s;
    f.for_s = 1e3;
    f.group = "operator";
    f.what = "interrupt";
    f.demand = Demand::NotLifted;
    trial_.faults.push_back(std::move(f));
  }

  Draws& draws_;
  DrawnTrial& trial_;
};

}  // namespace

DrawnTrial draw_faults(const Trial& trial) {
  Draws draws(trial.own_seed(12), 8200);
  DrawnTrial drawn;
  drawn.scene.scenario = mixed_layout(trial.index, trial.seed);
  drawn.scene.scenario.task.height = kHeight_m;
  drawn.scene.scenario.task.hold_s = kHold_s;
  drawn.scene.scenario.partner.obliging = draws.chance(0.5);
  static constexpr Wire kWires[] = {Wire::None, Wire::Arm, Wire::Hand};
  drawn.scene.wire = kWires[draws.below(3)];
  const int n = 1 + draws.below(3);
  FaultDraws faults(draws, drawn);
  for (int i = 0; i < n; ++i) faults.draw();
  return drawn;
}

control::TaskSaid faulty_task() {
  return {"experiment faults", kHeight_m, kHold_s};
}

const std::vector<std::string>& fault_groups() {
  static const std::vector<std::string> all{"camera",  "arm",    "hand",    "force",
                                            "partner", "people", "clutter", "operator"};
  return all;
}

}  // namespace colift::experiments
