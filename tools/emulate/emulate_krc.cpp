#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "hal/os/udp_link.hpp"
#include "sim_hal/emulator/krc/plant/krc_light_plant.hpp"
#include "sim_hal/emulator/mujoco/krc_world_plant.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/emulate/emulate_krc_json.hpp"
#include "tools/rig/rig_world.hpp"

namespace colift::tools {
namespace {

using sim_hal::KrcReport;
using sim_hal::KrcServer;
using sim_hal::KrcServerTiming;

hal::Result<> check_options(const EmulateKrcOptions& o) {
  if (!(o.cycle_ms >= 1.0 && o.cycle_ms <= 100.0) || o.cycle_ms != std::floor(o.cycle_ms))
    return bad_option("--cycle-ms",
                      fmt::format("{} is no cycle; expected whole milliseconds from 1 to 100", o.cycle_ms));
  if (o.from_port < 0 || o.from_port > 65535)
    return bad_option("--from", fmt::format("{} is no port; expected 0 (any) to 65535", o.from_port));
  if (o.common.plant != "mujoco" && o.common.plant != "light")
    return bad_option("--plant", fmt::format("\"{}\" is no plant; expected mujoco or light", o.common.plant));
  if (o.strategy && *o.strategy != 10 && *o.strategy != 20 && *o.strategy != 30)
    return bad_option("--strategy",
                      fmt::format("{} is no strategy; expected 10 (position), 20 (Cartesian impedance) or "
                                  "30 (joint impedance)",
                                  *o.strategy));
  if (!(o.common.speed >= 0.0 && o.common.speed <= 1000.0))
    return bad_option("--speed", fmt::format("{} is no speed; expected 0 (as fast as answers come) to 1000",
                                             o.common.speed));
  if (auto done = check_seconds("--linger-s", o.linger_s); !done) return done;
  if (auto done = check_seconds("--session-s", o.session_s); !done) return done;
  if (auto done = check_seconds("--for", o.common.for_s); !done) return done;
  if (auto done = check_seconds("--restart-s", o.restart_s); !done) return done;
  if (auto done = check_seconds("--idle-s", o.idle_s); !done) return done;
  return {};
}

hal::Result<sim_hal::KrcServerConfig> server_config(const EmulateKrcOptions& o,
                                                    const sim_hal::Scenario& scenario) {
  sim_hal::KrcServerConfig config;
  const auto to = hal::parse_endpoint(o.to);
  if (!to) return bad_option("--to", to.error().detail);
  if (to->address == 0 || to->port == 0)
    return bad_option("--to", fmt::format("\"{}\" names nobody; expected IPV4:PORT of the client", o.to));
  config.krc.to = *to;
  config.krc.cycle = std::chrono::milliseconds(std::lround(o.cycle_ms));
  config.krc.script = o.script;
  if (o.strategy) config.krc.program.strategy = static_cast<sim_hal::FriControl>(*o.strategy / 10);
  config.krc.program.linger_s = o.linger_s;
  config.krc.program.runs_s = o.session_s;
  config.krc.restart_s = o.restart_s;
  config.krc.idle_brakes_s = o.idle_s;
  config.krc.start_opens_brakes = !o.brakes_need_motion;
  config.krc.strict = o.strict;
  config.krc.seed = o.common.seed;
  auto faults = sim_hal::faults_of("arm", scenario.faults, o.common.faults, sim_hal::krc_fault,
                                   sim_hal::parse_krc_fault);
  if (!faults) return tl::unexpected(faults.error());
  config.krc.faults = std::move(*faults);
  config.from_port = static_cast<std::uint16_t>(o.from_port);
  config.speed = o.common.speed;
  return config;
}

std::string summary(const KrcReport& r, const KrcServerTiming& timing, const std::string& reason) {
  return fmt::format(
      "{}: {} packets sent, {} answered, {} missed, {:.1f} s in command mode, {} rule{} broken; {} of this "
      "machine's cycles began late (worst {:.2f} ms)",
      reason, r.sent, r.answered, r.missed,
      r.sent > 0 ? r.duration_s * static_cast<double>(r.command_cycles) / static_cast<double>(timing.cycles)
                 : 0.0,
      r.broken_rules_in_all, r.broken_rules_in_all == 1 ? "" : "s", timing.late, timing.worst_late_ms);
}

hal::Result<int> run(const CommonOptions& common, const EmulateKrcOptions& o) {
  if (auto done = check_options(o); !done) return tl::unexpected(done.error());
  const auto scenario = read_absolute_scenario(o.common.scenario);
  if (!scenario) return tl::unexpected(scenario.error());
  auto config = server_config(o, *scenario);
  if (!config) return tl::unexpected(config.error());

  const hal::ArmDynamics dynamics(hal::built_in_robot(), hal::ArmDynamics::Load::Hand);
  std::unique_ptr<sim_hal::SimWorld> world;
  std::unique_ptr<sim_hal::KrcPlant> plant;
  if (o.common.plant == "mujoco") {
    sim_hal::SimConfig sim;
    sim.arm_period = config->krc.cycle;
    auto made = sim_hal::SimWorld::make(*scenario, hal::built_in_robot(), o.common.seed, sim);
    if (!made) return tl::unexpected(made.error());
    world = std::move(*made);
    plant = std::make_unique<sim_hal::KrcWorldPlant>(*world, dynamics);
  } else {
    plant = std::make_unique<sim_hal::LightPlant>(
        dynamics, sim_hal::LightPlantConfig{sim_hal::SimConfig::home_rad(), o.friction});
  }
  KrcServer server(*config, dynamics, std::move(plant));

  const InterruptGuard guard;
  const EmulateLines lines(common);
  if (auto done = server.start(); !done) return tl::unexpected(done.error());
  lines.ready(fmt::format("krc, program {}, {:g} ms, plant {}, port {} to {}", o.script, o.cycle_ms,
                          o.common.plant, o.from_port > 0 ? std::to_string(o.from_port) : "any", o.to));
  const std::string reason = run_server(
      server, o.common, lines, [&] { return server.report().duration_s; },
      [&] {
        return server.ended() ? std::optional(server.report().closed.value_or("the port broke"))
                              : std::nullopt;
      });
  const KrcReport report = server.report();
  lines.result(common.json ? emulate_krc_json(o, report, server.timing(), reason)
                           : summary(report, server.timing(), reason));
  return report.broken_rules_in_all == 0 ? kDone : kNoGoal;
}

}  // namespace

int cmd_emulate_krc(const CommonOptions& common, const EmulateKrcOptions& options) {
  const auto done = run(common, options);
  return done ? *done : report_error("emulate krc", done.error());
}

}  // namespace colift::tools
