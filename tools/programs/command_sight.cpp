// Options of what looks and decides, and touches no device.

#include "tools/analyse/cmd_rank.hpp"
#include "tools/analyse/recorded_scene.hpp"
#include "tools/check/cmd_schema.hpp"
#include "tools/check/cmd_shipped.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/programs/command_line.hpp"
#include "tools/scenes/cmd_scene.hpp"

namespace colift::tools {
namespace {

void add_look(CLI::App& command, LookOptions& o) {
  add_frame(command, "CLOUD", o.cloud,
            "Recorded frame: .pcd, .ply, a 16-bit .png depth image, or one that is shipped (colift scenes)")
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
  command
      .add_option(
          "--support", o.support,
          "What the object stands on: floor, table, or auto (default): a table where nothing on the floor "
          "can be the target")
      ->type_name("WHAT");
  command.add_option("--png", o.png, "Writes a picture of scene and decision")->type_name("OUT.png");
  command.add_option("--report", o.report, "Writes one HTML page with picture, table and reasons")
      ->type_name("OUT.html");
}

void add_decide(CLI::App& command, DecideOptions& o) {
  add_look(command, o.look);
  command.add_option("--partner", o.partner, "Where the partner grasps the object")->type_name("X,Y,Z");
  command
      .add_option("--partner-cloud", o.partner_cloud,
                  "A second frame of the same camera that shows the partner's grasp")
      ->type_name("CLOUD2");
  command.add_option("--share", o.share, "Share of the load that the robot shall carry, between 0 and 1")
      ->type_name("S");
  command
      .add_option("--share-strict", o.share_strict,
                  "Refuses a grasp whose predicted share is more than this off the wanted one (with --share)")
      ->type_name("X");
  command
      .add_option("--epsilon", o.epsilon,
                  "Cost weight of the robot's effort relative to the partner's (thesis eq. 4.5)")
      ->type_name("E");
  command
      .add_option("--why", o.why,
                  "Explains candidate K: the terms of its cost and the reasons for its verdict")
      ->type_name("K");
}

void add_check(CLI::App& command, CheckOptions& o, CheckedCamera& camera) {
  command
      .add_option("--for", o.command,
                  "Whose configuration (default: run); behind it stand that command's own options, as in "
                  "check --for decide --method thesis --share 0.3")
      ->type_name("COMMAND ...");
  command.add_flag("--explain", o.explain, "With what each entry means, its unit and what it may be");
  command.add_flag("--graph", o.graph,
                   "Prints states and transitions of the job as a Graphviz graph; "
                   "with --json the rules");
  add_robot(command, camera.robot, "Robot file whose calibration and Kinect are checked too");
  command.add_option("--frame", camera.frame, "Depth image: checks the ground plane against the calibration")
      ->type_name("FILE");
  command
      .add_option("--camera", camera.camera, "Intrinsics of the depth image (default: camera.json beside it)")
      ->type_name("FILE");
}

}  // namespace

void add_sight_commands(CommandLine& line) {
  CommonOptions& common = line.common;

  CLI::App& look_command = line.command("look");
  const auto look = std::make_shared<LookOptions>();
  add_look(look_command, *look);
  line.add_common(look_command);
  line.when(look_command, [&common, look] { return cmd_look(common, *look); });
  line.configured(look_command, {[&common, look] { return config_of_look(common, *look); }});

  CLI::App& decide_command = line.command("decide");
  const auto decide = std::make_shared<DecideOptions>();
  add_decide(decide_command, *decide);
  line.add_common(decide_command);
  line.when(decide_command, [&common, decide] { return cmd_decide(common, *decide); });
  line.configured(decide_command, {[&common, decide] { return config_of_decide(common, *decide); }});

  CLI::App& scene_command = line.command("scene");
  const auto scene = std::make_shared<SceneOptions>();
  scene_command
      .add_option("FOLDER", scene->folders, "Scenes of colift hal camera record --scene, or folders of them")
      ->required();
  scene_command.add_option("--method", scene->method, "fast (default), thesis or both");
  scene_command.add_option("--png", scene->png, "Writes a picture of the truth (of one scene)")
      ->type_name("OUT.png");
  line.add_common(scene_command);
  line.when(scene_command, [&common, scene] { return cmd_scene(common, *scene); });

  CLI::App& rank_command = line.command("rank");
  const auto problem = std::make_shared<std::string>();
  rank_command.add_option("PROBLEM.json", *problem, "The problem; - reads it from stdin")->required();
  line.add_common(rank_command);
  line.when(rank_command, [&common, problem] { return cmd_rank(*problem, common.json); });

  CLI::App& check_command = line.command("check");
  const auto check = std::make_shared<CheckOptions>();
  const auto camera = std::make_shared<CheckedCamera>();
  add_check(check_command, *check, *camera);
  line.add_common(check_command);
  line.when(check_command, [&common, check, camera] {
    check->command = "run";
    // by its address: with a share of its own it would own itself
    camera->read_frame = [checked = camera.get()] { return read_depth(*checked->frame, checked->camera); };
    return cmd_check(common, *check, *camera, [&common] { return config_of_run(common, {}); });
  });

  CLI::App& scenarios_command = line.command("scenarios");
  line.add_output(scenarios_command);
  line.when(scenarios_command, [&common] { return cmd_shipped(ShippedKind::Scenario, common.json); });
  CLI::App& robots_command = line.command("robots");
  line.add_output(robots_command);
  line.when(robots_command, [&common] { return cmd_shipped(ShippedKind::Robot, common.json); });
  CLI::App& scenes_command = line.command("scenes");
  line.add_output(scenes_command);
  line.when(scenes_command, [&common] { return cmd_shipped(ShippedKind::Scene, common.json); });

  CLI::App& schema_command = line.command("schema");
  const auto name = std::make_shared<std::string>();
  schema_command.add_option("NAME", *name, "The document: run, look, decide, ... (without: which there are)");
  line.add_common(schema_command);
  line.when(schema_command, [&common, name] { return cmd_schema(*name, common.json); });
}

}  // namespace colift::tools
