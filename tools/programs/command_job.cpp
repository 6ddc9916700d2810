// Options of the job.

#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/programs/command_line.hpp"
#include "tools/run/run_parts.hpp"

namespace colift::tools {
namespace {

void add_ros2(CLI::App& command, Ros2Options& o) {
  command.add_flag("--ros2", o.on,
                   "Publishes the run as topics of ROS 2, on this machine's loopback interface");
  add_ros2_place(command, o);
}

void add_run(CLI::App& command, RunOptions& o) {
  add_view(command, o.live);
  add_ros2(command, o.ros2);
  add_scenario(command, o.scenario,
               "Scenario of the simulated rig (default: the built-in table); colift scenarios");
  add_robot(command, o.robot, "Robot file: which devices are used (default: the simulated rig)");
  command
      .add_option("--rig", o.rig,
                  "Simulated rig with the faults of real sensors: imperfect, or a file as "
                  "config/rig/imperfect.yaml")
      ->type_name("FILE");
  command.add_option("--method", o.method, "fast (default) or thesis");
  command.add_option("--seed", o.seed, "Same scenario, seed and program: same result, bit for bit")
      ->type_name("N");
  command.add_option("--share", o.share, "Share of the load that the robot shall carry, between 0 and 1")
      ->type_name("S");
  command
      .add_option("--share-strict", o.share_strict,
                  "Refuses a grasp whose predicted share is more than this off the wanted one (with --share)")
      ->type_name("X");
  command.add_flag("--dry-run", o.dry_run, "Perception, decision and plan only; nothing moves");
  command.add_flag(
      "--recover", o.recover,
      "In simulation: a run that ends in \"stopped\" is recovered at once, every step confirmed");
  command.add_option("--report", o.report, "Writes one HTML page with pictures, curves and reasons")
      ->type_name("FILE.html");
  command.add_option("--png", o.png, "Writes a picture of the lift")->type_name("OUT.png");
  command.add_option("--record", o.record, "Records everything, for Foxglove, Lichtblick and colift log")
      ->type_name("FILE.mcap");
  command
      .add_option("--flight", o.flight,
                  "Keeps the last 15 s in memory and writes them on a fault (on a robot always, to "
                  "~/.local/state/colift)")
      ->type_name("FILE.mcap");
}

}  // namespace

void add_job_commands(CommandLine& line, const RunParts& parts) {
  CommonOptions& common = line.common;

  CLI::App& run_command = line.command("run");
  const auto run = std::make_shared<RunOptions>();
  add_run(run_command, *run);
  line.add_common(run_command);
  line.when(run_command, [&common, run, parts] { return cmd_run(common, *run, parts); });
  line.configured(run_command,
                  {[&common, run] { return config_of_run(common, *run); }, [run] { return run->robot; }});
}

void add_simulated_job(CommandLine& line) {
  add_job_commands(line, RunParts{});
  line.add_others();
}

}  // namespace colift::tools
