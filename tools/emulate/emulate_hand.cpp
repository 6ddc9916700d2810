#include "tools/emulate/emulate_hand.hpp"
#include "tools/cli/interrupt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "hal/os/make_can_bus.hpp"
#include "sim_hal/emulator/hand/hand_gateway.hpp"
#include "sim_hal/emulator/hand/hand_light_plant.hpp"
#include "sim_hal/emulator/hand/hand_server.hpp"
#include "sim_hal/emulator/mujoco/hand_world_plant.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/rig_world.hpp"

namespace colift::tools {
namespace {

using sim_hal::HandEmulatorReport;
using sim_hal::HandServer;
using sim_hal::HandServerTiming;

hal::Result<> check_options(const EmulateHandOptions& o) {
  if (o.common.plant != "mujoco" && o.common.plant != "light")
    return bad_option("--plant", fmt::format("\"{}\" is no plant; expected mujoco or light", o.common.plant));
  if (o.common.speed != 1.0) return bad_option("--speed", "a hand's pucks live in real time; expected 1");
  if (auto done = check_seconds("--for", o.common.for_s); !done) return done;
  if (o.width_m && !(*o.width_m > 0.0 && *o.width_m <= 0.3))
    return bad_option("--width", fmt::format("{} is no width; expected metres up to 0.3", *o.width_m));
  if (o.width_m && o.common.plant != "light")
    return bad_option("--width", "a simulated world has its own object; expected --plant light");
  if (o.firmware < 132 || o.firmware > 999)
    return bad_option("--firmware", fmt::format("{} is not emulated; expected 132 to 999", o.firmware));
  const auto usual = [](double scale) { return scale >= 0.2 && scale <= 5.0; };
  if (!o.gauges.empty() &&
      (o.gauges.size() != sim_hal::kHandFingers || !std::all_of(o.gauges.begin(), o.gauges.end(), usual)))
    return bad_option("--gauges", "expected three scales from 0.2 to 5, of F1, F2 and F3");
  if (o.group < 0 || o.group > 31)
    return bad_option("--group", fmt::format("{} is no group; expected 0 to 31", o.group));
  return {};
}

hal::Result<sim_hal::HandEmulatorConfig> emulator_config(const EmulateHandOptions& o,
                                                         const sim_hal::Scenario& scenario) {
  sim_hal::HandEmulatorConfig config;
  config.puck.awake = o.awake;
  config.puck.firmware = o.firmware;
  config.puck.group_c = o.group;
  std::copy(o.gauges.begin(), o.gauges.end(), config.puck.strain_scale.begin());
  config.seed = o.common.seed;
  auto faults = sim_hal::faults_of("hand", scenario.faults, o.common.faults, sim_hal::hand_fault,
                                   sim_hal::parse_hand_fault);
  if (!faults) return tl::unexpected(faults.error());
  config.faults = std::move(*faults);
  return config;
}

std::uint64_t rules_broken(const HandEmulatorReport& r) {
  std::uint64_t all = 0;
  for (const std::uint64_t count : r.broken) all += count;
  return all;
}

hal::Result<int> run(const CommonOptions& common, const EmulateHandOptions& o) {
  if (auto done = check_options(o); !done) return tl::unexpected(done.error());
  const auto scenario = read_absolute_scenario(o.common.scenario);
  if (!scenario) return tl::unexpected(scenario.error());
  auto config = emulator_config(o, *scenario);
  if (!config) return tl::unexpected(config.error());

  std::unique_ptr<sim_hal::SimWorld> world;  // outlives its plant
  std::unique_ptr<hal::CanBus> bus;
  const sim_hal::HandGateway* gate = nullptr;
  constexpr std::string_view kGateway = "socketcand:";
  if (o.bus.starts_with(kGateway)) {
    auto gateway = sim_hal::gateway_config(o.bus);
    if (!gateway) return bad_option("--bus", gateway.error().detail);
    auto made = std::make_unique<sim_hal::HandGateway>(*gateway);
    gate = made.get();
    bus = std::move(made);
  } else {
    auto made = hal::make_can_bus(o.bus);
    if (!made) return bad_option("--bus", made.error().detail);
    bus = std::move(*made);
  }
  std::unique_ptr<sim_hal::HandPlant> plant;
  if (o.common.plant == "mujoco") {
    auto made = sim_hal::SimWorld::make(*scenario, hal::built_in_robot(), o.common.seed, {});
    if (!made) return tl::unexpected(made.error());
    world = std::move(*made);
    sim_hal::HandWorldConfig moves;
    moves.moves_world = true;
    plant = std::make_unique<sim_hal::HandWorldPlant>(*world, moves);
  } else {
    auto light = std::make_unique<sim_hal::LightHandPlant>();
    if (o.width_m) light->put(sim_hal::HandObject::of_width(*o.width_m));
    plant = std::move(light);
  }

  HandServer server(*config, std::move(plant), std::move(bus));
  const EmulateLines lines(common);
  const InterruptGuard guard;
  if (auto done = server.start(); !done) return tl::unexpected(done.error());
  lines.ready(
      fmt::format("hand on {}", gate == nullptr ? o.bus : fmt::format("{} (port {})", o.bus, gate->port())));
  const std::string reason = run_server(server, o.common, lines, [&] { return server.elapsed_s(); });
  const HandEmulatorReport report = server.report();
  const std::uint64_t broken = rules_broken(report);
  lines.result(
      common.json
          ? emulate_hand_json(o, report, server.timing(), server.elapsed_s(), reason)
          : fmt::format("{}: {} questions, {} settings, {} answers, {} rule{} broken; {} times late (worst "
                        "{:.1f} ms)",
                        reason, report.questions, report.settings, report.answers, broken,
                        broken == 1 ? "" : "s", server.timing().late, server.timing().worst_late_ms));
  return broken == 0 ? kDone : kNoGoal;
}

}  // namespace

std::string emulate_hand_json(const EmulateHandOptions& o, const HandEmulatorReport& r,
                              const HandServerTiming& timing, double duration_s, const std::string& reason) {
  using Json = nlohmann::ordered_json;
  Json rules = Json::array();
  for (std::size_t i = 0; i < sim_hal::kHandRules; ++i)
    if (r.broken[i] > 0)
      rules.push_back(
          {{"rule", sim_hal::kHandRuleNames[i]}, {"times", r.broken[i]}, {"because", r.first[i]}});
  Json excused = Json::array();
  for (std::size_t i = 0; i < sim_hal::kHandRules; ++i)
    if (r.excused[i] > 0) excused.push_back({{"rule", sim_hal::kHandRuleNames[i]}, {"times", r.excused[i]}});
  const Json j = {
      {"schema", "colift.emulate/1"},
      {"device", "hand"},
      {"because", reason},
      {"plant", o.common.plant},
      {"bus", o.bus},
      {"seed", o.common.seed},
      {"duration_s", duration_s},
      {"frames",
       {{"heard", r.heard},
        {"foreign", r.foreign},
        {"questions", r.questions},
        {"settings", r.settings},
        {"answers", r.answers},
        {"scans", r.scans},
        {"not_sent", r.not_sent}}},
      {"initialised", r.initialised},
      {"broken_rules", rules},
      {"broken_rules_in_all", rules_broken(r)},
      {"excused_by_faults", excused},
      {"timing", {{"late", timing.late}, {"worst_late_ms", timing.worst_late_ms}, {"wall_s", timing.wall_s}}},
  };
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

int cmd_emulate_hand(const CommonOptions& common, const EmulateHandOptions& options) {
  const auto code = run(common, options);
  return code ? *code : report_error("emulate hand", code.error());
}

}  // namespace colift::tools
