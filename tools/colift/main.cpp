// The program's front: commands, options, exit codes. What a command does stands in cmd_*.cpp.

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "tools/colift/cmd_rank.hpp"
#include "tools/colift/commands.hpp"

namespace {

using colift::tools::CommonOptions;
using colift::tools::LookOptions;
using colift::tools::RunOptions;

void add_common(CLI::App& command, CommonOptions& o) {
  command
      .add_option("--config", o.config_files,
                  "Configuration file (YAML); may be given several times, the later one wins")
      ->type_name("FILE")
      ->take_all()
      ->allow_extra_args(false);
  command
      .add_option("--set", o.settings,
                  "Sets one value over the files, as in --set decision.near_partner_m=0.2")
      ->type_name("KEY=VALUE")
      ->take_all()
      ->allow_extra_args(false);
  command.add_flag("--json", o.json, "Prints one JSON document to stdout and nothing else");
  command.add_flag("--quiet", o.quiet, "Prints only the result");
}

void add_look(CLI::App& command, LookOptions& o) {
  command.add_option("CLOUD", o.cloud, "Recorded frame: .pcd, .ply, or a 16-bit .png depth image")
      ->required();
  command.add_option("--method", o.method, "fast (default) or thesis");
  command.add_option("--camera", o.camera, "Intrinsics of a .png (default: camera.json beside it)")
      ->type_name("CAMERA.json");
  command
      .add_option("--camera-pose", o.camera_pose,
                  "Pose of the camera in the robot base; results are then in that frame")
      ->type_name("X,Y,Z,QX,QY,QZ,QW");
  command.add_option("--at", o.at, "Takes the object nearest to this point instead of the largest")
      ->type_name("X,Y,Z");
  command.add_option("--png", o.png, "Writes a picture of what was seen and decided")->type_name("OUT.png");
  command.add_option("--report", o.report, "Writes one HTML page with picture, table and reasons")
      ->type_name("OUT.html");
}

void add_run(CLI::App& command, RunOptions& o) {
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
}

int run(int argc, char** argv) {
  CLI::App app(
      "CoLift carries large objects together with a person: it sees where the person grasps, and decides\n"
      "where the robot takes hold so that both carry their share.");
  app.name("colift");
  app.set_version_flag("--version", "colift " COLIFT_VERSION);
  app.require_subcommand(1);
  app.failure_message(CLI::FailureMessage::help);

  CommonOptions common;
  for (int i = 0; i < argc; ++i) common.command += (i ? " " : "") + std::string(argv[i]);
  LookOptions look;
  colift::tools::DecideOptions decide;
  std::string problem;
  colift::tools::CheckOptions check;

  CLI::App* look_command = app.add_subcommand(
      "look", "Perception of one recorded frame: ground, target, surfaces, grasp candidates");
  add_look(*look_command, look);
  add_common(*look_command, common);

  CLI::App* decide_command =
      app.add_subcommand("decide", "look, then which grasp the robot takes for a partner's grasp, and why");
  add_look(*decide_command, decide.look);
  decide_command->add_option("--partner", decide.partner, "Where the partner holds the object")
      ->type_name("X,Y,Z");
  decide_command
      ->add_option("--partner-cloud", decide.partner_cloud,
                   "A second frame of the same camera that shows the partner's grasp")
      ->type_name("CLOUD2");
  decide_command
      ->add_option("--share", decide.share, "Part of the load that the robot shall carry, between 0 and 1")
      ->type_name("S");
  decide_command
      ->add_option("--epsilon", decide.epsilon,
                   "Price of the robot's effort against the partner's (thesis eq. 4.5)")
      ->type_name("E");
  add_common(*decide_command, common);

  CLI::App* rank_command = app.add_subcommand("rank", "Only the load-sharing decision, on numbers");
  rank_command->add_option("PROBLEM.json", problem, "The problem; - reads it from stdin")->required();
  add_common(*rank_command, common);

  colift::tools::RunOptions run;
  CLI::App* run_command = app.add_subcommand(
      "run", "The whole job: watch, decide, approach, lift together, lower, release, retreat");
  add_run(*run_command, run);
  add_common(*run_command, common);

  CLI::App* check_command = app.add_subcommand(
      "check", "Reads configuration and hand, touches no device, prints what would be used");
  check_command->add_flag("--explain", check.explain, "With what each entry means and what it may be");
  check_command->add_flag("--graph", check.graph,
                          "Prints the states of the job and what leads from one to the other, as a Graphviz "
                          "drawing; with --json the rules");
  add_common(*check_command, common);

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);  // --help, --version
  } catch (const CLI::ParseError& e) {
    const std::string first = argc > 1 ? argv[1] : "-";
    const auto commands = app.get_subcommands({});
    const bool known = std::any_of(commands.begin(), commands.end(),
                                   [&](const CLI::App* c) { return c->get_name() == first; });
    if (first[0] != '-' && !known)
      std::fprintf(
          stderr,
          "colift: \"%s\" is no command; there are run, look, decide, rank and check; see colift --help\n",
          first.c_str());
    else
      std::fprintf(stderr, "colift: %s; see colift --help\n", e.what());
    return colift::tools::kBadInput;
  }
  if (look_command->parsed()) return colift::tools::cmd_look(common, look);
  if (decide_command->parsed()) return colift::tools::cmd_decide(common, decide);
  if (run_command->parsed()) return colift::tools::cmd_run(common, run);
  if (rank_command->parsed()) return colift::tools::cmd_rank(problem, common.json);
  return colift::tools::cmd_check(common, check);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "colift: internal error: %s; please report it with the command line\n", e.what());
    return colift::tools::kInternal;
  }
}
