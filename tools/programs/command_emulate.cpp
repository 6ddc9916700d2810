// Options of the emulated far ends.

#include "tools/emulate/emulate.hpp"
#include "tools/emulate/emulate_camera.hpp"
#include "tools/emulate/emulate_hand.hpp"
#include "tools/emulate/emulate_rig.hpp"
#include "tools/programs/command_line.hpp"

namespace colift::tools {
namespace {

void add_emulate(CLI::App& command, EmulateOptions& o) {
  command.add_option("--plant", o.plant, "Plant model behind the device: mujoco (default) or light")
      ->type_name("PLANT");
  add_scenario(command, o.scenario, "Scenario of the simulated rig, with its faults (default: table)");
  command.add_option("--for", o.for_s, "Duration (s)")->type_name("S");
  command
      .add_option("--fault", o.faults,
                  "Injects a fault at T (s) for DURATION (default 0.5 s); may be given several times")
      ->type_name("T:KIND[:DURATION]")
      ->take_all()
      ->allow_extra_args(false);
  command.add_option("--speed", o.speed, "Speed as a multiple of real time; 0: one cycle per answer")
      ->type_name("X");
  command.add_option("--seed", o.seed, "Random seed of scenario and faults")->type_name("N");
}

void add_emulate_krc(CLI::App& command, EmulateKrcOptions& o) {
  command.add_option("--to", o.to, "Address of the client (default 127.0.0.1:49938)")->type_name("IP:PORT");
  command.add_option("--from", o.from_port, "Source port of the controller (default: any)")
      ->type_name("PORT");
  command.add_option("--cycle-ms", o.cycle_ms, "Cycle time in ms, 1 to 100 (default 2)")->type_name("N");
  command.add_option("--script", o.script,
                     "KRL program: colift (default), stanford, tum, vendor, cep or openkc");
  command.add_option("--strategy", o.strategy,
                     "Control strategy at start: 10, 20 or 30 (default: the program's)");
  command.add_option("--linger-s", o.linger_s, "Monitor mode between a close and silence (default 1.5)")
      ->type_name("S");
  command
      .add_option("--session-s", o.session_s, "Duration of command mode in the vendor's program (default 10)")
      ->type_name("S");
  command
      .add_option("--restart-s", o.restart_s,
                  "An operator acknowledges faults and restarts the program after that time (default: never)")
      ->type_name("S");
  command
      .add_option("--idle-s", o.idle_s,
                  "The brakes close when nothing moved for that time (default 20; 0: never)")
      ->type_name("S");
  command.add_flag("--brakes-need-motion", o.brakes_need_motion,
                   "Closed brakes are opened by a motion of the KRL program only, not by friStart");
  command.add_flag("--strict", o.strict, "Command mode needs quality perfect to start and ok to stay");
  command.add_flag("--friction", o.friction, "Joint friction of the light plant");
}

void add_emulate_hand(CLI::App& command, EmulateHandOptions& o) {
  command
      .add_option("--bus", o.bus, "socketcand:IPV4:PORT/NAME, a gateway that is opened here, or socketcan:IF")
      ->type_name("BUS");
  command.add_option("--width", o.width_m, "Width of an object between the fingers of the light plant (m)")
      ->type_name("M");
  command.add_flag("--awake", o.awake, "The pucks were woken before, and initialised by another program");
  command.add_option("--firmware", o.firmware, "Firmware version of the pucks (default 200)")->type_name("N");
  command
      .add_option("--gauges", o.gauges, "Scales of the strain gauges of F1 to F3 against the maker's curve")
      ->type_name("S,S,S")
      ->delimiter(',');
  command.add_option("--group", o.group, "Third group of every puck (default 5)")->type_name("N");
}

void add_emulate_camera(CLI::App& command, EmulateCameraOptions& o) {
  command.add_option("--fakenect", o.fakenect, "Writes a recording for fakenect there (2 s)")
      ->type_name("DIR");
  command.add_flag("--live", o.live, "Serves it live (default)");
  command.add_option("--address", o.address, "Socket address of the live camera (default @colift-kinect)")
      ->type_name("@NAME");
}

}  // namespace

void add_emulate_commands(CommandLine& line) {
  CommonOptions& common = line.common;
  CLI::App& emulate = line.command("emulate");
  emulate.require_subcommand(1);

  CLI::App& krc_command =
      *emulate.add_subcommand("krc", "A KUKA KRC2lr behind its Fast Research Interface (UDP)");
  const auto krc = std::make_shared<EmulateKrcOptions>();
  add_emulate(krc_command, krc->common);
  add_emulate_krc(krc_command, *krc);
  line.add_output(krc_command);
  line.when(krc_command, [&common, krc] { return cmd_emulate_krc(common, *krc); });

  CLI::App& hand_command = *emulate.add_subcommand("hand", "The four pucks of a BarrettHand on a CAN bus");
  const auto hand = std::make_shared<EmulateHandOptions>();
  add_emulate(hand_command, hand->common);
  add_emulate_hand(hand_command, *hand);
  line.add_output(hand_command);
  line.when(hand_command, [&common, hand] { return cmd_emulate_hand(common, *hand); });

  CLI::App& camera_command =
      *emulate.add_subcommand("camera", "A Kinect on a simulated world, behind libfreenect's own functions");
  const auto camera = std::make_shared<EmulateCameraOptions>();
  add_emulate(camera_command, camera->common);
  add_emulate_camera(camera_command, *camera);
  line.add_output(camera_command);
  line.when(camera_command, [&common, camera] { return cmd_emulate_camera(common, *camera); });

  CLI::App& rig_command = *emulate.add_subcommand(
      "rig", "All three on one simulated world, for colift run --robot emulated in another terminal");
  const auto rig = std::make_shared<EmulateRigOptions>();
  add_emulate(rig_command, rig->common);
  add_robot(rig_command, rig->robot, "Robot file whose addresses are served (default: emulated)");
  line.add_output(rig_command);
  line.when(rig_command, [&common, rig] { return cmd_emulate_rig(common, *rig); });
}

}  // namespace colift::tools
