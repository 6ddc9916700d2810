#include "tools/emulate/emulate_rig.hpp"
#include "tools/cli/interrupt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/cli/session.hpp"
#include "tools/emulate/emulate_hand.hpp"
#include "tools/emulate/emulate_krc_json.hpp"
#include "tools/rig/emulated_rig.hpp"
#include "tools/rig/rig_world.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;

/// What config/emulated.yaml says, for who has no file at hand.
RobotFile usual_robot() {
  RobotFile file;
  file.arm = "fri";
  file.hand = "barrett";
  file.camera = "kinect";
  file.barrett.can = EmulateHandOptions{}.bus;
  file.kinect.source = "emulated:@colift-kinect";
  return file;
}

hal::Result<RobotFile> robot_of(const EmulateRigOptions& o) {
  if (!o.robot) return usual_robot();
  auto file = read_robot_file(o.robot);
  if (!file) return file;
  if (file->arm != "fri" || file->hand != "barrett" ||
      (file->camera != "kinect" && file->camera != "openni2" && file->camera != "ros2"))
    return hal::failure(
        hal::ErrorCode::BadConfig, o.robot->string(),
        fmt::format("a rig is served for three real drivers; expected arm: fri, hand: barrett, camera: "
                    "kinect, openni2 or ros2, found {}, {}, {}",
                    file->arm, file->hand, file->camera));
  const std::string& source = file->camera == "openni2" ? file->openni2.source : file->kinect.source;
  if (file->camera != "ros2" && !source.starts_with("emulated:@"))
    return hal::failure(
        hal::ErrorCode::BadConfig, o.robot->string(),
        fmt::format("{}.source: \"{}\" is not served here; expected emulated:@NAME", file->camera, source));
  return file;
}

hal::Result<> check_options(const EmulateRigOptions& o) {
  if (o.common.plant != "mujoco") return bad_option("--plant", "emulate rig needs --plant mujoco");
  if (o.common.speed != 1.0) return bad_option("--speed", "pucks and camera live in real time; expected 1");
  if (!o.common.faults.empty())
    return bad_option("--fault", "expected in the scenario's faults, which name the device");
  return check_seconds("--for", o.common.for_s);
}

/// The client's devices have been started: the arm took commands, every puck found its stop.
bool client_is_ready(EmulatedRig& rig) {
  const auto pucks = rig.pucks()->report().initialised;
  return rig.krc().report().command_cycles > 0 &&
         std::all_of(pucks.begin(), pucks.end(), [](int times) { return times > 0; });
}

std::uint64_t rules_broken(EmulatedRig& rig) {
  std::uint64_t all = rig.krc().report().broken_rules_in_all;
  for (const std::uint64_t count : rig.pucks()->report().broken) all += count;
  return all;
}

Json camera_json(EmulatedRig& rig) {
  if (const sim_hal::ServedCamera* served = rig.served_camera()) {
    const sim_hal::ServedCamera::Report r = served->report();
    return {{"frames_sent", r.frames}, {"worst_render_ms", r.worst_render_ms}};
  }
  const sim_hal::CameraServerReport c = rig.camera()->report();
  return {{"clients", c.clients},
          {"frames_sent", c.sent},
          {"frames_not_taken", c.not_taken},
          {"infrared", c.infrared},
          {"worst_render_ms", c.worst_render_ms}};
}

std::string document(const EmulateRigOptions& o, const RobotFile& file, EmulatedRig& rig, bool began,
                     const std::string& reason) {
  EmulateKrcOptions krc;
  krc.common = o.common;
  krc.to = fmt::format("127.0.0.1:{}", file.fri.port);
  krc.cycle_ms = file.fri.cycle_ms;
  krc.script = file.fri.script;
  EmulateHandOptions hand;
  hand.common = o.common;
  hand.bus = file.barrett.can;
  const sim_hal::HandServer& pucks = *rig.pucks();
  const Json j = {
      {"schema", "colift.emulate/1"},
      {"device", "rig"},
      {"because", reason},
      {"seed", o.common.seed},
      {"scenario_began", began},
      {"broken_rules_in_all", rules_broken(rig)},
      {"arm", Json::parse(emulate_krc_json(krc, rig.krc().report(), rig.krc().timing(), reason))},
      {"hand",
       Json::parse(emulate_hand_json(hand, pucks.report(), pucks.timing(), pucks.elapsed_s(), reason))},
      {"camera", camera_json(rig)},
  };
  return j.dump(-1, ' ', false, Json::error_handler_t::replace);
}

hal::Result<int> run(const CommonOptions& common, const EmulateRigOptions& o) {
  if (auto done = check_options(o); !done) return tl::unexpected(done.error());
  auto file = robot_of(o);
  if (!file) return tl::unexpected(file.error());
  auto sign = ServedRigSign::put_up(static_cast<std::uint16_t>(file->fri.port));
  if (!sign) return tl::unexpected(sign.error());
  const auto scenario = read_absolute_scenario(o.common.scenario);
  if (!scenario) return tl::unexpected(scenario.error());
  const auto model = read_model(file->model);
  if (!model) return tl::unexpected(model.error());
  auto world = make_world(*file, *scenario, **model, o.common.seed);
  if (!world) return tl::unexpected(world.error());
  const InterruptGuard guard;
  auto rig = EmulatedRig::start(emulated_rig_of(*file, o.common.seed), *scenario, **model, *world);
  if (!rig) return tl::unexpected(rig.error());

  const EmulateLines lines(common);
  lines.ready(
      fmt::format("rig {}: arm's controller to 127.0.0.1:{} every {:g} ms, hand on {}, camera on {}; "
                  "now colift run --robot {} in another terminal",
                  scenario->name, file->fri.port, file->fri.cycle_ms, file->barrett.can,
                  (*rig)->camera() ? "emulated:" + (*rig)->camera()->address() : file->ros2.image,
                  o.robot ? o.robot->string() : "emulated"));
  const auto print = [&](const char* device, auto& server) {
    for (const auto& e : server.take_events()) lines.event(e.t_s, fmt::format("{:6} {}", device, e.text));
  };
  bool began = false;
  const auto elapsed_s = [&] { return (*rig)->krc().report().duration_s; };
  const auto print_all = [&] {
    print("arm", (*rig)->krc());
    print("hand", *(*rig)->pucks());
    if ((*rig)->camera()) print("camera", *(*rig)->camera());
    if (began || !client_is_ready(**rig)) return;
    began = true;
    (*rig)->begin();
    lines.event(elapsed_s(), "the client's devices are ready: the scenario begins");
  };
  const std::string reason = run_emulator(
      o.common, {print_all, elapsed_s, [&] { (*rig)->stop(); },
                 [&] {
                   const auto& krc = (*rig)->krc();
                   return krc.ended() ? std::optional(krc.report().closed.value_or("the arm's port broke"))
                                      : std::nullopt;
                 }});
  const std::uint64_t broken = rules_broken(**rig);
  lines.result(common.json ? document(o, *file, **rig, began, reason)
                           : fmt::format("{}: {} rule{} broken by the client", reason, broken,
                                         broken == 1 ? "" : "s"));
  return broken == 0 ? kDone : kNoGoal;
}

}  // namespace

int cmd_emulate_rig(const CommonOptions& common, const EmulateRigOptions& options) {
  const auto code = run(common, options);
  return code ? *code : report_error("emulate rig", code.error());
}

}  // namespace colift::tools
