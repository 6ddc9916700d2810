// The program's front: commands, options, exit codes. What a command does stands in cmd_*.cpp.

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "tools/colift/calibrate.hpp"
#include "tools/colift/cmd_experiment.hpp"
#include "tools/colift/cmd_hal.hpp"
#include "tools/colift/cmd_hal_camera.hpp"
#include "tools/colift/cmd_log.hpp"
#include "tools/colift/cmd_rank.hpp"
#include "tools/colift/commands.hpp"
#include "tools/colift/emulate.hpp"
#include "tools/colift/emulate_camera.hpp"
#include "tools/colift/emulate_hand.hpp"
#include "tools/colift/emulate_rig.hpp"

namespace {

using colift::tools::CommonOptions;
using colift::tools::LookOptions;
using colift::tools::RunOptions;

void add_output(CLI::App& command, CommonOptions& o) {
  command.add_flag("--json", o.json, "Prints one JSON document to stdout and nothing else");
  command.add_flag("--quiet", o.quiet, "Prints only the result");
}

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
  add_output(command, o);
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

void add_view(CLI::App& command, colift::tools::ViewOptions& o) {
  command
      .add_option_function<std::vector<std::string>>(
          "--view", [&o](const std::vector<std::string>& port) { o.view = port.empty() ? "" : port.front(); },
          "Shows it on a page in the browser, and to Foxglove and Lichtblick (default port 8765)")
      ->expected(0, 1)
      ->type_name("[PORT]");
  command
      .add_option("--view-address", o.view_address, "Where the page is served (default: this machine alone)")
      ->type_name("ADDRESS");
  command.add_flag("--allow-operator", o.allow_operator,
                   "Who has the address with the token that is printed may stop the run");
  command.add_option("--allow-origin", o.allow_origins, "A page from elsewhere that may connect")
      ->type_name("URL");
  command
      .add_option(
          "--speed", o.speed,
          "Of simulated time, as a multiple of real time (default: 1 with --view, else as fast as it goes)")
      ->type_name("X");
}

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
CLI::App& add_log_verb(CLI::App& log, const char* name, const char* help, colift::tools::LogOptions& o,
                       const char* file_help) {
  CLI::App* verb = log.add_subcommand(name, help);
  verb->callback([&o, name] { o.verb = name; });
  verb->add_option("FILE", o.file, file_help)->required();
  return *verb;
}

CLI::App* add_log(CLI::App& app, colift::tools::LogOptions& o, CommonOptions& common) {
  constexpr const char* kRecording = "Recording (MCAP); one that was cut is read as far as it goes";
  CLI::App* log = app.add_subcommand("log", "Recordings of runs");
  log->require_subcommand(1);
  add_output(add_log_verb(*log, "info", "What is in it", o, kRecording), common);
  CLI::App& exported = add_log_verb(*log, "export", "Makes tables or pictures of it", o, kRecording);
  exported.add_option("--out", o.out, "Folder (default: FILE-export)")->type_name("FOLDER");
  exported
      .add_option("--format", o.formats,
                  "csv (default): a table for each channel; png: depth images and camera.json; fakenect: for "
                  "libfreenect's player; may be given several times")
      ->type_name("FORMAT")
      ->take_all()
      ->allow_extra_args(false);
  add_output(exported, common);
  CLI::App& recovered =
      add_log_verb(*log, "recover", "Makes a whole file of one that was cut or damaged", o, kRecording);
  recovered.add_option("--out", o.out, "The new file (default: FILE.recovered.mcap)")->type_name("FILE");
  add_output(recovered, common);
  CLI::App& replayed = add_log_verb(
      *log, "replay",
      "Decides once more on what was recorded; --config and --set change what with; --view shows it", o,
      kRecording);
  add_view(replayed, o.live);
  add_common(replayed, common);
  CLI::App& snapshot =
      add_log_verb(*log, "snapshot", "Has a running colift run write its last seconds", o, "Where they go");
  snapshot.add_option("--pid", o.pid, "Of the run (default: the newest of this user)")->type_name("PID");
  add_output(snapshot, common);
  return log;
}

void add_experiment(CLI::App& command, colift::tools::ExperimentOptions& o) {
  command
      .add_option("NAME", o.words,
                  "grasps, realtime, tilt, load, complex, robust, wrong-cog, slip or all; or: merge DIR...")
      ->required();
  command.add_option("--trials", o.trials, "How many (default: each experiment's own number)")
      ->type_name("N");
  command.add_option("--seed", o.seed, "Same seed and trials: same figures (default 1)")->type_name("S");
  command.add_option("--method", o.method, "fast (default), thesis or both");
  command.add_option("--shard", o.shard, "Only part I of N of the trials, for a cluster")->type_name("I/N");
  command.add_option("--jobs", o.jobs, "Threads (default: one per core)")->type_name("N");
  command.add_option("--out", o.out, "Folder of tables, figures, plots and page (default out/experiments)")
      ->type_name("DIR");
}

void add_calibrate(CLI::App& command, colift::tools::CalibrateOptions& o) {
  command.add_option("--samples", o.samples, "Folder with samples.yaml and infrared images")
      ->type_name("FOLDER");
  command.add_flag("--sim", o.sim, "Takes the samples on the simulated rig");
  command.add_option("--robot", o.robot, "Takes them with these devices; clear the space around the arm")
      ->type_name("FILE");
  command
      .add_option("--scenario", o.scenario, "What the simulated rig holds (default: nothing near the arm)")
      ->type_name("FILE");
  command.add_option("--poses", o.poses, "Poses of the arm, 5 to 200 (default 20)")->type_name("N");
  command.add_option("--seed", o.seed, "Same samples, seed and program: same result, bit for bit")
      ->type_name("N");
  command.add_option("--camera-at", o.camera_at, "Where the camera about stands, in the robot base")
      ->type_name("X,Y,Z");
  command.add_option("--date", o.date, "Stands in the result (default: now)")->type_name("TEXT");
  command.add_option("--out", o.out, "Writes the result, for calibration_file: in a configuration")
      ->type_name("FILE.yaml");
  command.add_option("--save", o.save, "Keeps the samples, for --samples")->type_name("FOLDER");
  command.add_option("--png", o.png, "Writes a picture of spots and residuals")->type_name("OUT.png");
}

void add_emulate(CLI::App& command, colift::tools::EmulateOptions& o) {
  command.add_option("--plant", o.plant, "What is behind the device: mujoco (default) or light")
      ->type_name("PLANT");
  command
      .add_option("--scenario", o.scenario, "What the simulated rig holds, and its faults (default: table)")
      ->type_name("FILE");
  command.add_option("--for", o.for_s, "Ends after that time (s)")->type_name("S");
  command.add_option("--fault", o.faults, "Something goes wrong at T (s); may be given several times")
      ->type_name("T:KIND[:DURATION]")
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--speed", o.speed, "Device seconds in a second; 0: as fast as answers come")
      ->type_name("X");
  command.add_option("--seed", o.seed, "Of the scenario and of random faults")->type_name("N");
}

void add_emulate_krc(CLI::App& command, colift::tools::EmulateKrcOptions& o) {
  command.add_option("--to", o.to, "Where the client listens (default 127.0.0.1:49938)")
      ->type_name("IP:PORT");
  command.add_option("--from", o.from_port, "The controller's own port (default: any)")->type_name("PORT");
  command.add_option("--cycle-ms", o.cycle_ms, "Time between two measurements, 1 to 100 (default 2)")
      ->type_name("N");
  command.add_option("--script", o.script, "KRL program: colift (default), stanford, tum, vendor or cep");
  command.add_option("--strategy", o.strategy, "10, 20 or 30 in place of the program's own first strategy");
  command.add_option("--linger-s", o.linger_s, "Monitor mode between a close and silence (default 1.5)")
      ->type_name("S");
  command.add_option("--session-s", o.session_s, "How long the vendor's program commands (default 10)")
      ->type_name("S");
  command
      .add_option("--restart-s", o.restart_s,
                  "An operator acknowledges faults and restarts the program after that time (default: never)")
      ->type_name("S");
  command.add_flag("--strict", o.strict, "Starts only at quality perfect, stays only at ok or better");
  command.add_flag("--friction", o.friction, "Joint friction of the light plant");
}

void add_emulate_hand(CLI::App& command, colift::tools::EmulateHandOptions& o) {
  command
      .add_option("--bus", o.bus, "socketcand:IPV4:PORT/NAME, a gateway that is opened here, or socketcan:IF")
      ->type_name("BUS");
  command.add_option("--width", o.width_m, "Of an object between the fingers of the light plant (m)")
      ->type_name("M");
  command.add_flag("--awake", o.awake, "The pucks were woken before and know their zero");
  command.add_option("--firmware", o.firmware, "Of the pucks (default 200)")->type_name("N");
  command.add_option("--group", o.group, "Third group of every puck (default 5)")->type_name("N");
}

/// A verb of `hal DEVICE`, with what all of them take.
CLI::App& add_verb(CLI::App& device, const char* name, const char* help, colift::tools::HalOptions& o,
                   CommonOptions& common) {
  CLI::App* verb = device.add_subcommand(name, help);
  verb->add_option("--robot", o.robot, "How the device is reached (default: the driver's own defaults)")
      ->type_name("FILE");
  verb->callback([&o, name] { o.verb = name; });
  add_common(*verb, common);
  return *verb;
}

CLI::App* add_hal_arm(CLI::App& hal, colift::tools::HalOptions& o, CommonOptions& common) {
  CLI::App* arm = hal.add_subcommand("arm", "The KUKA LWR 4+ over FRI");
  arm->require_subcommand(1);
  const auto for_s = [&o](CLI::App& verb, const char* help) {
    verb.add_option("--for", o.for_s, help)->type_name("S");
  };
  const auto yes = [&o](CLI::App& verb) {
    verb.add_flag("--yes", o.yes, "Goes beyond the careful limits of bring-up");
  };
  for_s(add_verb(*arm, "state", "How it is, and why command mode would be refused now; nothing moves", o,
                 common),
        "Looks for that time (default 1.2)");
  for_s(add_verb(*arm, "watch", "The same all the time, with the times of the answers; nothing moves", o,
                 common),
        "Ends after that time (default: when interrupted)");
  for_s(add_verb(*arm, "hold", "Gets command mode, holds the measured pose, leaves", o, common),
        "Holds for that time (default 10)");
  CLI::App& move = add_verb(*arm, "move-joint", "Moves one joint by an angle, slowly, and leaves", o, common);
  move.add_option("N", o.joint, "Joint, 1 to 7 from the base")->required();
  move.add_option("DEG", o.degrees, "By how many degrees, from where it stands")->required();
  move.add_option("--speed", o.speed_deg_s, "Degrees per second (default 5)")->type_name("DEG/S");
  yes(move);
  add_verb(*arm, "limits", "Limits of each joint: the arm's, those of the guard, those in T1", o, common);
  CLI::App& stiffness =
      add_verb(*arm, "stiffness", "Holds with a stiffness of the joints, for a person to feel it", o, common);
  stiffness.add_option("VALUE", o.stiffness_nm_rad, "N m/rad, 0 to 2000")->required();
  for_s(stiffness, "Holds for that time (default 30)");
  yes(stiffness);
  return arm;
}

CLI::App* add_hal_hand(CLI::App& hal, colift::tools::HalOptions& o, CommonOptions& common) {
  CLI::App* hand = hal.add_subcommand("hand", "The BarrettHand over CAN");
  hand->require_subcommand(1);
  const auto for_s = [&o](CLI::App& verb, const char* help) {
    verb.add_option("--for", o.for_s, help)->type_name("S");
  };
  const auto yes = [&o](CLI::App& verb) {
    verb.add_flag("--yes", o.yes, "Opens although the hand holds something, which falls");
  };
  const auto torque = [&o](CLI::App& verb) {
    verb.add_option("--torque", o.torque_nm, "At the fingertips, at most (default 0.5 N m)")->type_name("NM");
  };
  yes(add_verb(*hand, "init", "Wakes the pucks and opens all joints to their stops to find their zeros", o,
               common));
  for_s(add_verb(*hand, "state", "How it is; nothing moves", o, common), "Looks for that time (default 1)");
  for_s(add_verb(*hand, "watch", "The same all the time; nothing moves", o, common),
        "Ends after that time (default: when interrupted)");
  for_s(add_verb(*hand, "tactile", "Forces on the pads; nothing moves", o, common),
        "Ends after that time (default: when interrupted)");
  yes(add_verb(*hand, "open", "Opens the fingers", o, common));
  torque(add_verb(*hand, "close", "Closes until each finger is held by something or by its stop", o, common));
  CLI::App& preshape = add_verb(*hand, "preshape", "Opens the fingers and turns the spread", o, common);
  preshape.add_option("DEG", o.spread_deg, "Spread, 0 to 180 degrees")->required();
  yes(preshape);
  CLI::App& grip = add_verb(*hand, "grip", "Closes on an object and watches the grip", o, common);
  torque(grip);
  for_s(grip, "Watches it for that time (default 5)");
  return hand;
}

CLI::App* add_hal_camera(CLI::App& hal, colift::tools::HalCameraOptions& o, CommonOptions& common) {
  CLI::App* camera = hal.add_subcommand("camera", "The Kinect v1 over libfreenect");
  camera->require_subcommand(1);
  const auto add = [&](const char* name, const char* help) -> CLI::App& {
    CLI::App& verb = add_verb(*camera, name, help, o.hal, common);
    verb.add_option("--source", o.source,
                    "usb, usb:SERIAL, fakenect:DIR or emulated:ADDRESS (default: the file's)");
    verb.add_option("--for", o.hal.for_s, "Ends after that time")->type_name("S");
    return verb;
  };
  const auto png = [&o](CLI::App& verb) {
    verb.add_option("--png", o.png, "Writes a picture of the last frame")->type_name("OUT.png");
    verb.add_option("--depth", o.depth,
                    "Writes the last frame itself (16-bit PNG, mm), camera.json beside it")
        ->type_name("OUT.png");
    verb.add_option("--infrared", o.infrared, "Writes an infrared image: is the emitter seen?")
        ->type_name("OUT.png");
  };
  png(add("info", "What it is, how it hangs, what it sees"));
  png(add("watch", "The same all the time (with --png: for a second)"));
  add("record", "Records raw depth for fakenect, 18 MB a second, until interrupted")
      .add_option("FOLDER", o.folder, "New or empty folder")
      ->required();
  CLI::App& tilt = add("tilt", "Turns its foot; whatever was calibrated is wrong then");
  tilt.add_option("DEG", o.tilt_deg, "-31 to 31 degrees against the horizon")->required();
  tilt.add_flag("--yes", o.hal.yes, "Yes, move the camera");
  return camera;
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
  decide_command
      ->add_option("--why", decide.why,
                   "Explains candidate K: what its cost is made of, what stands against it")
      ->type_name("K");
  add_common(*decide_command, common);

  CLI::App* rank_command = app.add_subcommand("rank", "Only the load-sharing decision, on numbers");
  rank_command->add_option("PROBLEM.json", problem, "The problem; - reads it from stdin")->required();
  add_common(*rank_command, common);

  colift::tools::RunOptions run;
  CLI::App* run_command = app.add_subcommand(
      "run", "The whole job: watch, decide, approach, lift together, lower, release, retreat");
  add_run(*run_command, run);
  add_common(*run_command, common);

  colift::tools::ExperimentOptions experiment;
  CLI::App* experiment_command = app.add_subcommand(
      "experiment", "Repeats the thesis's chapter 6 in simulation: tables, figures with intervals, a page");
  add_experiment(*experiment_command, experiment);
  add_output(*experiment_command, common);

  CLI::App* emulate_command = app.add_subcommand("emulate", "The far end of a device's wire");
  emulate_command->require_subcommand(1);
  colift::tools::EmulateKrcOptions krc;
  CLI::App* krc_command =
      emulate_command->add_subcommand("krc", "A KUKA KRC2lr behind its Fast Research Interface (UDP)");
  add_emulate(*krc_command, krc.common);
  add_emulate_krc(*krc_command, krc);
  add_output(*krc_command, common);
  colift::tools::EmulateHandOptions pucks;
  CLI::App* pucks_command =
      emulate_command->add_subcommand("hand", "The four pucks of a BarrettHand on a CAN bus");
  add_emulate(*pucks_command, pucks.common);
  add_emulate_hand(*pucks_command, pucks);
  add_output(*pucks_command, common);

  colift::tools::EmulateCameraOptions kinect;
  CLI::App* kinect_command = emulate_command->add_subcommand(
      "camera", "A Kinect on a simulated world, behind libfreenect's own functions");
  add_emulate(*kinect_command, kinect.common);
  kinect_command->add_option("--fakenect", kinect.fakenect, "Writes a recording for fakenect there (2 s)")
      ->type_name("DIR");
  kinect_command->add_flag("--live", kinect.live, "Serves it live (default)");
  kinect_command->add_option("--address", kinect.address, "Of the live camera (default @colift-kinect)")
      ->type_name("@NAME");
  add_output(*kinect_command, common);

  colift::tools::EmulateRigOptions rig;
  CLI::App* rig_command = emulate_command->add_subcommand(
      "rig",
      "All three on one simulated world, for colift run --robot config/emulated.yaml in another terminal");
  add_emulate(*rig_command, rig.common);
  rig_command->add_option("--robot", rig.robot, "Whose wires (default: those of config/emulated.yaml)")
      ->type_name("FILE");
  add_output(*rig_command, common);

  CLI::App* hal_command = app.add_subcommand("hal", "Bring-up of one device at a time");
  hal_command->require_subcommand(1);
  colift::tools::HalOptions arm;
  CLI::App* arm_command = add_hal_arm(*hal_command, arm, common);
  colift::tools::HalOptions hand;
  CLI::App* hand_command = add_hal_hand(*hal_command, hand, common);
  colift::tools::HalCameraOptions camera;
  CLI::App* camera_command = add_hal_camera(*hal_command, camera, common);

  colift::tools::CalibrateOptions calibrate;
  CLI::App* calibrate_command = app.add_subcommand(
      "calibrate", "Where the camera is: a blinking emitter on the palm, seen at many poses of the arm");
  add_calibrate(*calibrate_command, calibrate);
  add_common(*calibrate_command, common);

  colift::tools::DoctorOptions doctor;
  CLI::App* doctor_command =
      app.add_subcommand("doctor", "This machine: what is found, and the line that repairs it");
  doctor_command
      ->add_option("--robot", doctor.robot,
                   "Whose port and bus are looked at (default: the drivers' defaults)")
      ->type_name("FILE");
  doctor_command->add_option("--root", doctor.root, "Where /sys, /proc and /dev are looked for (default: /)")
      ->type_name("FOLDER");
  add_common(*doctor_command, common);

  colift::tools::LogOptions log;
  CLI::App* log_command = add_log(app, log, common);

  CLI::App* check_command = app.add_subcommand(
      "check", "Reads configuration and hand, touches no device, prints what would be used");
  check_command->add_flag("--explain", check.explain, "With what each entry means and what it may be");
  check_command->add_flag("--graph", check.graph,
                          "Prints the states of the job and what leads from one to the other, as a Graphviz "
                          "drawing; with --json the rules");
  colift::tools::CheckedCamera checked;
  check_command->add_option("--robot", checked.robot, "Whose calibration and Kinect are looked at too")
      ->type_name("FILE");
  check_command
      ->add_option("--frame", checked.frame, "A depth image: is the ground where the calibration has it?")
      ->type_name("FILE");
  check_command->add_option("--camera", checked.camera, "Of a PNG: its camera.json (default: beside it)")
      ->type_name("FILE");
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
      std::fprintf(stderr,
                   "colift: \"%s\" is no command; there are run, look, decide, rank, experiment, hal, "
                   "emulate, doctor, log and check; see colift --help\n",
                   first.c_str());
    else
      std::fprintf(stderr, "colift: %s; see colift --help\n", e.what());
    return colift::tools::kBadInput;
  }
  if (look_command->parsed()) return colift::tools::cmd_look(common, look);
  if (decide_command->parsed()) return colift::tools::cmd_decide(common, decide);
  if (run_command->parsed()) return colift::tools::cmd_run(common, run);
  if (experiment_command->parsed()) return colift::tools::cmd_experiment(common, experiment);
  if (krc_command->parsed()) return colift::tools::cmd_emulate_krc(common, krc);
  if (kinect_command->parsed()) return colift::tools::cmd_emulate_camera(common, kinect);
  if (rig_command->parsed()) return colift::tools::cmd_emulate_rig(common, rig);
  if (camera_command->parsed()) return colift::tools::cmd_hal_camera(common, camera);
  if (pucks_command->parsed()) return colift::tools::cmd_emulate_hand(common, pucks);
  if (hand_command->parsed()) return colift::tools::cmd_hal_hand(common, hand);
  if (arm_command->parsed()) return colift::tools::cmd_hal_arm(common, arm);
  if (calibrate_command->parsed()) return colift::tools::cmd_calibrate(common, calibrate);
  if (doctor_command->parsed()) return colift::tools::cmd_doctor(common, doctor);
  if (log_command->parsed()) return colift::tools::cmd_log(common, log);
  if (rank_command->parsed()) return colift::tools::cmd_rank(problem, common.json);
  return colift::tools::cmd_check(common, check, checked);
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
