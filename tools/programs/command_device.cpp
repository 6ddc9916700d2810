// Options of what brings devices up, one at a time.

#include <fmt/format.h>

#include "tools/bring_up/cmd_hal.hpp"
#include "tools/bring_up/cmd_hal_camera.hpp"
#include "tools/calibrate/calibrate.hpp"
#include "tools/cli/commands.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/programs/command_line.hpp"
#include "tools/recover/cmd_recover.hpp"
#include "tools/rig/wired_devices.hpp"

namespace colift::tools {
namespace {

/// A verb of `hal DEVICE`, with what all of them take.
CLI::App& add_verb(CLI::App& device, const char* name, const char* help, HalOptions& o, CommandLine& line) {
  CLI::App* verb = device.add_subcommand(name, help);
  add_robot(*verb, o.robot, "Robot file: address of the device (default: the driver's defaults)");
  verb->callback([&o, name] { o.verb = name; });
  line.add_common(*verb);
  return *verb;
}

void add_hal_arm(CommandLine& line, CLI::App& arm, HalOptions& o) {
  arm.require_subcommand(1);
  const auto for_s = [&o](CLI::App& verb, const char* help) {
    verb.add_option("--for", o.for_s, help)->type_name("S");
  };
  const auto yes = [&o](CLI::App& verb) {
    verb.add_flag("--yes", o.yes, "Allows values beyond the limits of bring-up");
  };
  for_s(add_verb(arm, "state", "State, and what prevents command mode; no motion", o, line),
        "Observation time (default 1.2)");
  const auto out = [&o](CLI::App& verb) {
    verb.add_option("--out", o.out, "The file (default arm-doctor.tar)")->type_name("FILE.tar");
  };
  out(add_verb(arm, "doctor", "State, answer times, obstacles and settings as one file to send; no motion", o,
               line));
  for_s(add_verb(arm, "watch", "State continuously, with response times; no motion", o, line),
        "Duration (default: until interrupted)");
  const CLI::IsMember strategies({"joint_impedance", "position", "cartesian_impedance"});
  const auto control = [&](CLI::App& verb, const char* by_default = "the file's") {
    verb.add_option("--control", o.control,
                    fmt::format("joint_impedance, position or cartesian_impedance (default: {})", by_default))
        ->type_name("C")
        ->check(strategies);
  };
  CLI::App& hold =
      add_verb(arm, "hold", "Enters command mode, holds the measured position, leaves command mode", o, line);
  for_s(hold, "Duration (default 10)");
  control(hold);
  CLI::App& switched = add_verb(
      arm, "switch", "Holds the measured position in one control strategy after the other, without a restart",
      o, line);
  switched
      .add_option("CONTROL", o.controls,
                  "joint_impedance, position, cartesian_impedance, in the order to try")
      ->required()
      ->check(strategies);
  for_s(switched, "Duration of each (default 2)");
  CLI::App& move = add_verb(arm, "move-joint", "Moves one joint by a relative angle, slowly", o, line);
  move.add_option("N", o.joint, "Joint, 1 to 7 from the base")->required();
  move.add_option("DEG", o.degrees, "Relative angle in degrees")->required();
  move.add_option("--speed", o.speed_deg_s, "Degrees per second (default 5)")->type_name("DEG/S");
  control(move);
  yes(move);
  CLI::App& load =
      add_verb(arm, "load", "Turns A4 to A7 through ten poses and compares the load with the KRC's load data",
               o, line);
  control(load, "position where the KRL program takes a strategy, else the file's");
  yes(load);
  add_verb(arm, "limits", "Joint limits: of the arm, of the guard, in T1", o, line);
  CLI::App& stiffness = add_verb(
      arm, "stiffness", "Joint impedance control with this stiffness, to be pushed by hand", o, line);
  stiffness.add_option("VALUE", o.stiffness_nm_rad, "N m/rad, 0 to 2000")->required();
  for_s(stiffness, "Duration (default 30)");
  yes(stiffness);
}

void add_hal_hand(CommandLine& line, CLI::App& hand, HalOptions& o) {
  hand.require_subcommand(1);
  const auto for_s = [&o](CLI::App& verb, const char* help) {
    verb.add_option("--for", o.for_s, help)->type_name("S");
  };
  const auto yes = [&o](CLI::App& verb) {
    verb.add_flag("--yes", o.yes, "Opens even if the hand holds an object, which then falls");
  };
  const auto torque = [&o](CLI::App& verb) {
    verb.add_option("--torque", o.torque_nm, "Max torque at the fingertips (default 0.5 N m)")
        ->type_name("NM");
  };
  yes(add_verb(hand, "init", "Wakes the pucks and opens all joints to their stops to find their zeros", o,
               line));
  for_s(add_verb(hand, "state", "What each puck answers; read-only, also of a cold hand", o, line),
        "Ignored: the state is read once");
  add_verb(hand, "doctor", "What each puck answers, the bus, settings and the bus log as one file to send", o,
           line)
      .add_option("--out", o.out, "The file (default hand-doctor.tar)")
      ->type_name("FILE.tar");
  for_s(add_verb(hand, "watch", "State continuously; no motion", o, line),
        "Duration (default: until interrupted)");
  for_s(add_verb(hand, "tactile", "Forces on the tactile pads; no motion", o, line),
        "Duration (default: until interrupted)");
  yes(add_verb(hand, "open", "Opens the fingers", o, line));
  add_verb(hand, "emergency-open",
           "Opens every finger that still answers, without configuring the hand; what it holds falls", o,
           line)
      .add_flag("--yes", o.yes, "Confirms that what the hand holds may fall");
  torque(add_verb(hand, "close", "Closes until each finger meets an object or its stop", o, line));
  CLI::App& preshape = add_verb(hand, "preshape", "Opens the fingers and turns the spread", o, line);
  preshape.add_option("DEG", o.spread_deg, "Spread, 0 to 180 degrees")->required();
  yes(preshape);
  preshape
      .add_option("--fingers", o.fingers_deg, "Then closes the fingers to this angle, one after the other")
      ->type_name("DEG");
  const auto one = [&](const char* name, const char* help, const char* value, const char* what) -> CLI::App& {
    CLI::App& verb = add_verb(hand, name, help, o, line);
    verb.add_option("FINGER", o.finger, "F1, F2 or F3")->required();
    verb.add_option(value, o.value, what)->required();
    yes(verb);
    return verb;
  };
  torque(one("finger", "Moves one finger to an angle of its inner joint", "DEG", "0 to 137 degrees"));
  torque(one("step", "Moves one finger by an angle", "DEG", "Degrees, closing is positive"));
  CLI::App& velocity = one("velocity", "Moves one finger with a velocity", "DEG/S", "Up to 34 either way");
  torque(velocity);
  for_s(velocity, "Duration (default 1)");
  CLI::App& push = one("torque", "Drives one finger with a torque; the puck knows no joint limits then", "NM",
                       "At the fingertip, closing is positive");
  for_s(push, "Duration (default 1)");
  CLI::App& grip = add_verb(hand, "grip", "Closes on an object and monitors the grip", o, line);
  torque(grip);
  for_s(grip, "Duration (default 5)");
  CLI::App& calibrate =
      add_verb(hand, "calibrate",
               "Measures a finger's strain gauge with known torques, and what its motor gives", o, line);
  calibrate.add_option("FINGER", o.finger, "F1, F2 or F3")->required();
  calibrate
      .add_option(
          "--torques", o.torques_nm,
          "N m that a person applies about the outer joint, rising, at least two (default 0.2,0.4,0.6)")
      ->type_name("NM,NM,..")
      ->delimiter(',');
  calibrate.add_flag(
      "--press", o.press,
      "Then the finger closes onto something rigid with rising torque, up to move_torque_units");
  calibrate.add_option("--pause", o.pause_s, "Each step begins by itself so long after it was said")
      ->type_name("S");
  calibrate
      .add_option("--out", o.out,
                  "Kept by the puck's serial number, for calibration_file: of a robot file; a file "
                  "that exists keeps its other pucks")
      ->type_name("FILE.yaml");
  yes(calibrate);
  for (CLI::App* verb : hand.get_subcommands({}))
    verb->add_option("--bus-log", o.bus_log, "Logs every frame of the bus (candump -L -x), for replay")
        ->type_name("FILE");
  CLI::App& replay = add_verb(
      hand, "replay", "Plays a bus log to today's driver and to an emulated hand; no device", o, line);
  replay
      .add_option("FILE", o.replay, "Made by --bus-log, or by candump -L (then for the emulated hand only)")
      ->required();
}

void add_hal_camera(CommandLine& line, CLI::App& camera, HalCameraOptions& o) {
  camera.require_subcommand(1);
  const auto add = [&](const char* name, const char* help) -> CLI::App& {
    CLI::App& verb = add_verb(camera, name, help, o.hal, line);
    verb.add_option(
        "--source", o.source,
        "usb, usb:SERIAL, fakenect:DIR or emulated:ADDRESS; of OpenNI2 openni2:any, "
        "openni2:uri:URI, openni2:file:NAME.oni or openni2:emulated:ADDRESS (default: the file's)");
    verb.add_option("--for", o.hal.for_s, "Duration")->type_name("S");
    return verb;
  };
  const auto png = [&o](CLI::App& verb) {
    verb.add_option("--png", o.png, "Writes a picture of the last frame")->type_name("OUT.png");
    verb.add_option("--depth", o.depth,
                    "Writes the last frame itself (16-bit PNG, mm), camera.json beside it")
        ->type_name("OUT.png");
    verb.add_option("--infrared", o.infrared,
                    "Writes an infrared image, to check that the emitter is visible")
        ->type_name("OUT.png");
  };
  png(add("info", "Serial number, mounting angle, depth statistics"));
  png(add("watch", "Statistics continuously (with --png: for one second)"));
  CLI::App& record =
      add("record", "Records raw depth for fakenect, 18 MB a second, until interrupted; or a scene");
  record.add_option("FOLDER", o.folder, "New or empty folder; of a camera of OpenNI2 a new file NAME.oni")
      ->required();
  CLI::Option* const scene = record.add_flag("--scene", o.scene,
                                             "Records empty place, object, hand and lift, as colift scene "
                                             "checks them; --for is the lift's duration");
  record.add_option("--object", o.object, "What is carried, in a few words")->needs(scene);
  record.add_option("--lifted", o.lifted_m, "How far it is lifted, where that is measured")
      ->type_name("M")
      ->needs(scene);
  record.add_option("--pause", o.pause_s, "Each step begins by itself so long after it was said")
      ->type_name("S")
      ->needs(scene);
  record.add_option("--licence", o.licence, "Under which others may have the images")->needs(scene);
  add("noise", "Measures the depth noise on an empty floor or wall (default: for 3 s), as a configuration")
      .add_option("--out", o.out, "Writes it into a file for --config")
      ->type_name("OUT.yaml");
  CLI::App& tilt = add("tilt", "Tilts the camera with its motor; invalidates the calibration");
  tilt.add_option("DEG", o.tilt_deg, "-31 to 31 degrees against the horizon")->required();
  tilt.add_flag("--yes", o.hal.yes, "Confirms that the camera may move");
}

void add_calibrate(CLI::App& command, CalibrateOptions& o) {
  command.add_option("--samples", o.samples, "Folder with samples.yaml and infrared images")
      ->type_name("FOLDER");
  command.add_flag("--sim", o.sim, "Takes the samples on the simulated rig");
  add_robot(command, o.robot, "Takes the samples with these devices; clear the space around the arm first");
  add_scenario(command, o.scenario, "Scenario of the simulated rig (default: nothing near the arm)");
  command.add_option("--poses", o.poses, "Poses of the arm, 5 to 200 (default 20)")->type_name("N");
  command.add_option("--seed", o.seed, "Same samples, seed and program: same result, bit for bit")
      ->type_name("N");
  command.add_option("--camera-at", o.camera_at, "Approximate camera position in the robot base")
      ->type_name("X,Y,Z");
  command.add_option("--date", o.date, "Date written into the result (default: now)")->type_name("TEXT");
  command.add_option("--out", o.out, "Writes the result, for calibration_file: in a configuration")
      ->type_name("FILE.yaml");
  command.add_option("--save", o.save, "Keeps the samples, for --samples")->type_name("FOLDER");
  command.add_option("--png", o.png, "Writes a picture of spots and residuals")->type_name("OUT.png");
}

void add_doctor(CLI::App& command, DoctorOptions& o) {
  add_robot(command, o.robot, "Robot file whose port and bus are checked (default: the drivers' defaults)");
  command.add_option("--root", o.root, "Root folder of /sys, /proc and /dev (default: /)")
      ->type_name("FOLDER");
}

}  // namespace

void add_device_commands(CommandLine& line) {
  CommonOptions& common = line.common;

  CLI::App& hal = line.command("hal");
  hal.require_subcommand(1);
  CLI::App& arm_command = *hal.add_subcommand("arm", "The KUKA LWR 4+ over FRI");
  const auto arm = std::make_shared<HalOptions>();
  add_hal_arm(line, arm_command, *arm);
  line.when(arm_command, [&common, arm] { return cmd_hal_arm(common, *arm); });
  const auto hal_config = [&common] { return config_of(common, control::Command::Hal); };
  line.configured(arm_command, {hal_config});
  CLI::App& hand_command = *hal.add_subcommand("hand", "The BarrettHand over CAN");
  const auto hand = std::make_shared<HalOptions>();
  add_hal_hand(line, hand_command, *hand);
  line.when(hand_command, [&common, hand] { return cmd_hal_hand(common, *hand); });
  line.configured(hand_command, {hal_config});
  CLI::App& camera_command =
      *hal.add_subcommand("camera", "The Kinect v1 over libfreenect, or the depth camera of the robot file");
  const auto camera = std::make_shared<HalCameraOptions>();
  add_hal_camera(line, camera_command, *camera);
  line.when(camera_command, [&common, camera] { return cmd_hal_camera(common, *camera); });
  line.configured(camera_command, {hal_config});

  CLI::App& calibrate_command = line.command("calibrate");
  const auto calibrate = std::make_shared<CalibrateOptions>();
  add_calibrate(calibrate_command, *calibrate);
  line.add_common(calibrate_command);
  line.when(calibrate_command, [&common, calibrate] { return cmd_calibrate(common, *calibrate); });
  line.configured(calibrate_command, {[&common] { return config_of(common, control::Command::Calibrate); }});

  CLI::App& recover_command = line.command("recover");
  const auto recover = std::make_shared<RecoverOptions>();
  add_robot(recover_command, recover->robot,
            "Robot file: which devices are used (default: the simulated rig)");
  add_scenario(recover_command, recover->scenario, "Scenario of a simulated or emulated rig");
  recover_command.add_flag("--yes", recover->yes, "Confirms every step; simulated and emulated rigs only");
  line.add_common(recover_command);
  line.when(recover_command, [&common, recover] { return cmd_recover(common, *recover, &wired_devices()); });
  line.configured(recover_command, {[&common, recover] {
                                      RunOptions as_run;
                                      as_run.robot = recover->robot;
                                      as_run.scenario = recover->scenario;
                                      return config_of_run(common, as_run);
                                    },
                                    [recover] { return recover->robot; }});

  CLI::App& doctor_command = line.command("doctor");
  const auto doctor = std::make_shared<DoctorOptions>();
  add_doctor(doctor_command, *doctor);
  line.add_common(doctor_command);
  line.when(doctor_command, [&common, doctor] { return cmd_doctor(common, *doctor); });
}

}  // namespace colift::tools
