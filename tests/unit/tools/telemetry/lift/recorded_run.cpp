#include "recorded_run.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "control/task/run_job.hpp"
#include "hal/config/config_file.hpp"
#include "hal/guards/guarded_arm.hpp"
#include "hal/guards/guarded_hand.hpp"
#include "sim_hal/mujoco/devices/sim_devices.hpp"
#include "sim_hal/mujoco/sim_world.hpp"
#include "tools/live/live_server.hpp"
#include "tools/telemetry/channels/built_in_texts.hpp"
#include "tools/telemetry/record/run_telemetry.hpp"

namespace colift::telemetry::test {
namespace {

constexpr std::uint64_t kSeed = 3;

control::Config config_of(const sim_hal::Scenario& scenario, const std::vector<std::string>& settings) {
  control::Config config = control::run_defaults();
  config.task.lift_height_m = scenario.task.height;
  config.task.hold_s = scenario.task.hold_s;
  hal::FieldTable table = hal::table_of(config);
  for (const std::string& s : settings) REQUIRE(hal::apply_setting(table, s));
  return config;
}

/// A viewer that asks for everything and then never reads.
class DeafViewer {
 public:
  explicit DeafViewer(const live::LiveServer& server) : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    const int small = 4096;
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVBUF, &small, sizeof(small));
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(server.port());
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(::connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof(to)) == 0);
    send(
        "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n");
    char c = 0;
    for (std::string head; !head.ends_with("\r\n\r\n"); head.push_back(c))
      REQUIRE(::recv(socket_, &c, 1, 0) == 1);
    std::string all = R"({"op":"subscribe","subscriptions":[)";
    for (int i = 0; i < static_cast<int>(Topic::Depth); ++i)
      all += (i == 0 ? "" : ",") + ("{\"id\":" + std::to_string(i)) + ",\"channelId\":" + std::to_string(i) +
             "}";
    all += "]}";
    // one masked frame of text (RFC 6455); the mask is zero
    std::string frame = {'\x81', '\xFE', static_cast<char>(all.size() >> 8),
                         static_cast<char>(all.size() & 0xFF)};
    send(frame + std::string(4, '\0') + all);
  }
  ~DeafViewer() { ::close(socket_); }
  DeafViewer(const DeafViewer&) = delete;
  DeafViewer& operator=(const DeafViewer&) = delete;

 private:
  void send(const std::string& bytes) const {
    REQUIRE(::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size()));
  }
  int socket_;
};

}  // namespace

sim_hal::Scenario short_lift() {
  sim_hal::Scenario scenario = sim_hal::built_in_scenario();
  scenario.task.hold_s = 0.5;
  return scenario;
}

Recorded run(const sim_hal::Scenario& scenario, const std::filesystem::path* file, const hal::Pose& pushed,
             const std::vector<std::string>& settings) {
  const hal::RobotModel& model = hal::built_in_robot();
  control::Config config = config_of(scenario, settings);
  auto world = sim_hal::SimWorld::make(scenario, model, kSeed, {});
  REQUIRE(world);
  hal::Robot robot;
  robot.arm = std::make_unique<hal::GuardedArm>(sim_hal::make_sim_arm(**world), model, config.guard_arm);
  robot.hand = std::make_unique<hal::GuardedHand>(sim_hal::make_sim_hand(**world), config.guard_hand);
  robot.camera = sim_hal::make_sim_camera(**world);
  robot.clock = sim_hal::make_sim_clock(**world);
  const planner::HandModel hand;
  const auto tables = std::make_shared<planner::HandCollision>(hand, config.candidates.collision);
  const hal::SteadyClock wall;
  const hal::Pose X_WC = sim_hal::camera_pose(scenario.camera) * pushed.inverse();
  control::JobOptions options;
  options.seed = kSeed;

  std::unique_ptr<live::LiveServer> server;
  std::optional<DeafViewer> deaf;
  std::unique_ptr<Recorder> recorder;
  std::unique_ptr<RunTelemetry> telemetry;
  if (file) {
    RunDescription about;
    about.version = program_version();
    about.config_yaml = hal::effective_yaml(hal::table_of(config), false);
    about.robot_urdf = built_in_robot_urdf();
    about.X_WC = X_WC;
    about.seed = kSeed;
    RecorderConfig recording;
    recording.file = *file;
    recording.wait_when_full = true;
    auto started = Recorder::start(recording, documents_of(about));
    REQUIRE(started);
    recorder = std::move(*started);
    live::ServerConfig view;
    view.port = 0;
    auto opened = live::LiveServer::open(view, live::PageFiles("/nowhere"));
    REQUIRE(opened);
    server = std::move(*opened);
    deaf.emplace(*server);
    telemetry = std::make_unique<RunTelemetry>(
        RunTelemetry::Setting{&model, X_WC, {}, control::Drive::InStep, true, &hand, about.robot_urdf},
        std::vector<TelemetrySink*>{recorder.get(), server.get()}, wall);
    telemetry->tap(robot);
  }
  const control::RigView rig{model, hand, tables, X_WC};
  control::JobHooks hooks;
  hooks.continue_confirmed = [&] { return (*world)->take_continue_confirmed(); };
  auto record =
      control::run_job(robot, rig, config, options, telemetry ? telemetry->hooks(hooks) : hooks, wall);
  REQUIRE(record);
  Recorded out{std::move(*record), {}};
  if (recorder) out.report = recorder->finish();
  if (server) CHECK(server->counts().published > 1000);
  return out;
}

hal::Result<ReplayReport> replayed(const McapReader& reader, const std::vector<std::string>& settings,
                                   Watcher* watcher) {
  const auto about = description_of(reader, "lift");
  REQUIRE(about);
  ReplaySetting setting;
  setting.config = control::run_defaults();
  hal::FieldTable table = hal::table_of(setting.config);
  REQUIRE(hal::apply_yaml_text(table, about->config_yaml, "recorded"));
  for (const std::string& s : settings) REQUIRE(hal::apply_setting(table, s));
  setting.hand_tables =
      std::make_shared<planner::HandCollision>(setting.hand, setting.config.candidates.collision);
  auto model = hal::parse_robot(about->robot_urdf, "recorded");
  REQUIRE(model);
  setting.model = std::make_shared<hal::RobotModel>(std::move(*model));
  if (watcher) setting.watchers = {watcher};
  return replay(reader, "lift", *about, setting);
}

McapReader opened(const std::filesystem::path& file) {
  auto source = open_file(file);
  REQUIRE(source);
  auto reader = McapReader::open(std::move(*source), file.string());
  REQUIRE(reader);
  return std::move(*reader);
}

}  // namespace colift::telemetry::test
