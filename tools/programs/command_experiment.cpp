// Options of the experiments.

#include "tools/experiments/cmd_experiment.hpp"
#include "tools/experiments/experiment.hpp"
#include "tools/programs/command_line.hpp"

namespace colift::tools {
namespace {

std::string names_of_all() {
  std::string names;
  for (const experiments::Experiment& e : experiments::all_experiments()) names += e.name + ", ";
  names.replace(names.size() - 2, 2, " or all");
  return names;
}

void add_experiment(CLI::App& command, ExperimentOptions& o) {
  command
      .add_option("NAME", o.words,
                  names_of_all() +
                      "; or: merge DIR...; worst NAME: a page of a campaign's worst trials (20, or --trials)")
      ->required();
  command.add_option("--trials", o.trials, "Number of trials (default: per experiment)")->type_name("N");
  command.add_option("--seed", o.seed, "Same seed and trials: same figures (default 1)")->type_name("S");
  command.add_option("--method", o.method, "fast (default), thesis or both");
  command.add_option(
      "--camera", o.camera,
      "layout (default): camera pose of each scene; side: beside the robot, as the thesis's method needs it");
  command.add_option("--shard", o.shard, "Runs shard I of N of the trials, for a cluster")->type_name("I/N");
  command.add_option("--jobs", o.jobs, "Threads (default: one per core)")->type_name("N");
  command.add_option("--out", o.out, "Folder of tables, figures, plots and page (default out/experiments)")
      ->type_name("DIR");
}

}  // namespace

void add_experiment_commands(CommandLine& line) {
  CommonOptions& common = line.common;
  CLI::App& experiment_command = line.command("experiment");
  const auto experiment = std::make_shared<ExperimentOptions>();
  add_experiment(experiment_command, *experiment);
  line.add_output(experiment_command);
  line.when(experiment_command, [&common, experiment] { return cmd_experiment(common, *experiment); });
  line.configured(experiment_command, {[experiment] { return config_of_experiment(*experiment); }});
}

}  // namespace colift::tools
