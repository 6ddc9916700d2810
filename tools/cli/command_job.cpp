// Options of the job, its recordings and its experiments.

#include "tools/cli/command_line.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/experiments/cmd_experiment.hpp"
#include "tools/log/cmd_log.hpp"

namespace colift::tools {
namespace {

void add_run(CLI::App& command, RunOptions& o) {
  add_view(command, o.live);
  command.add_option("--scenario", o.scenario, "What the simulated rig holds (default: the built-in table)")
      ->type_name("FILE");
  command.add_option("--robot", o.robot, "Which devices (default: the simulated rig)")->type_name("FILE");
  command.add_option("--method", o.method, "fast (default) or thesis");
  command.add_option("--seed", o.seed, "Same scenario, seed and program: same result, bit for bit")
      ->type_name("N");
  command.add_option("--share", o.share, "Part of the load that the robot shall carry, between 0 and 1")
      ->type_name("S");
  command.add_flag("--dry-run", o.dry_run, "Sees, decides and plans; moves nothing");
  command.add_option("--report", o.report, "Writes one HTML page with pictures, curves and reasons")
      ->type_name("FILE.html");
  command.add_option("--png", o.png, "Writes a picture of the lift")->type_name("OUT.png");
  command.add_option("--record", o.record, "Records everything, for Foxglove, Lichtblick and colift log")
      ->type_name("FILE.mcap");
  command
      .add_option("--flight", o.flight,
                  "Keeps the last seconds and writes them when something goes wrong (on a robot always, to "
                  "~/.local/state/colift)")
      ->type_name("FILE.mcap");
}

/// A verb of `log`, with what all of them take.
CLI::App& add_log_verb(CLI::App& log, const char* name, const char* help, LogOptions& o,
                       const char* file_help) {
  CLI::App* verb = log.add_subcommand(name, help);
  verb->callback([&o, name] { o.verb = name; });
  verb->add_option("FILE", o.file, file_help)->required();
  return *verb;
}

void add_log(CommandLine& line, CLI::App& log, LogOptions& o) {
  constexpr const char* kRecording = "Recording (MCAP); one that was cut is read as far as it goes";
  log.require_subcommand(1);
  line.add_output(add_log_verb(log, "info", "What is in it", o, kRecording));
  CLI::App& exported = add_log_verb(log, "export", "Makes tables or pictures of it", o, kRecording);
  exported.add_option("--out", o.out, "Folder (default: FILE-export)")->type_name("FOLDER");
  exported
      .add_option("--format", o.formats,
                  "csv (default): a table for each channel; png: depth images and camera.json; fakenect: for "
                  "libfreenect's player; may be given several times")
      ->type_name("FORMAT")
      ->take_all()
      ->allow_extra_args(false);
  line.add_output(exported);
  CLI::App& recovered =
      add_log_verb(log, "recover", "Makes a whole file of one that was cut or damaged", o, kRecording);
  recovered.add_option("--out", o.out, "The new file (default: FILE.recovered.mcap)")->type_name("FILE");
  line.add_output(recovered);
  CLI::App& replayed = add_log_verb(
      log, "replay",
      "Decides once more on what was recorded; --config and --set change what with; --view shows it", o,
      kRecording);
  add_view(replayed, o.live);
  line.add_common(replayed);
  CLI::App& snapshot =
      add_log_verb(log, "snapshot", "Has a running colift run write its last seconds", o, "Where they go");
  snapshot.add_option("--pid", o.pid, "Of the run (default: the newest of this user)")->type_name("PID");
  line.add_output(snapshot);
}

void add_experiment(CLI::App& command, ExperimentOptions& o) {
  command
      .add_option("NAME", o.words,
                  "grasps, realtime, tilt, load, complex, robust, wrong-cog, slip, tasks, agents or all; or: "
                  "merge DIR...")
      ->required();
  command.add_option("--trials", o.trials, "How many (default: each experiment's own number)")
      ->type_name("N");
  command.add_option("--seed", o.seed, "Same seed and trials: same figures (default 1)")->type_name("S");
  command.add_option("--method", o.method, "fast (default), thesis or both");
  command.add_option(
      "--camera", o.camera,
      "layout (default): where each scene has it; side: beside the robot, as the thesis's method needs it");
  command.add_option("--shard", o.shard, "Only part I of N of the trials, for a cluster")->type_name("I/N");
  command.add_option("--jobs", o.jobs, "Threads (default: one per core)")->type_name("N");
  command.add_option("--out", o.out, "Folder of tables, figures, plots and page (default out/experiments)")
      ->type_name("DIR");
}

}  // namespace

void add_view(CLI::App& parser, ViewOptions& o) {
  parser
      .add_option_function<std::vector<std::string>>(
          "--view", [&o](const std::vector<std::string>& port) { o.view = port.empty() ? "" : port.front(); },
          "Shows it on a page in the browser, and to Foxglove and Lichtblick (default port 8765)")
      ->expected(0, 1)
      ->type_name("[PORT]");
  parser
      .add_option("--view-address", o.view_address, "Where the page is served (default: this machine alone)")
      ->type_name("ADDRESS");
  parser.add_flag("--allow-operator", o.allow_operator,
                  "Who has the address with the token that is printed may stop the run");
  parser.add_option("--allow-origin", o.allow_origins, "A page from elsewhere that may connect")
      ->type_name("URL");
  parser
      .add_option(
          "--speed", o.speed,
          "Of simulated time, as a multiple of real time (default: 1 with --view, else as fast as it goes)")
      ->type_name("X");
}

void add_job_commands(CommandLine& line) {
  CommonOptions& common = line.common;

  CLI::App& run_command =
      line.command("run", "The whole job: watch, decide, approach, lift together, lower, release, retreat");
  const auto run = std::make_shared<RunOptions>();
  add_run(run_command, *run);
  line.add_common(run_command);
  line.when(run_command, [&common, run] { return cmd_run(common, *run); });
  line.configured(run_command,
                  {[&common, run] { return config_of_run(common, *run); }, [run] { return run->robot; }});

  CLI::App& log_command = line.command("log", "Recordings of runs");
  const auto log = std::make_shared<LogOptions>();
  add_log(line, log_command, *log);
  line.when(log_command, [&common, log] { return cmd_log(common, *log); });
  line.configured(*log_command.get_subcommand("replay"),
                  {[&common, log] { return config_of_replay(common, *log); }});

  CLI::App& experiment_command = line.command(
      "experiment", "Repeats the thesis's chapter 6 in simulation: tables, figures with intervals, a page");
  const auto experiment = std::make_shared<ExperimentOptions>();
  add_experiment(experiment_command, *experiment);
  line.add_output(experiment_command);
  line.when(experiment_command, [&common, experiment] { return cmd_experiment(common, *experiment); });
  line.configured(experiment_command, {[experiment] { return config_of_experiment(*experiment); }});
}

}  // namespace colift::tools
