#include "tools/emulate/emulate_camera.hpp"
#include "tools/cli/interrupt.hpp"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "hal/drivers/capture_link/beside_program.hpp"
#include "hal/drivers/kinect/fakenect_writer.hpp"
#include "sim_hal/emulator/camera/camera_server.hpp"
#include "sim_hal/emulator/mujoco/camera_world_source.hpp"
#include "tools/cli/session.hpp"
#include "tools/rig/rig_world.hpp"

namespace colift::tools {
namespace {

using namespace std::chrono_literals;
using sim_hal::CameraServer;
using sim_hal::CameraServerReport;

constexpr double kRecord_s = 2.0;
constexpr double kTicks_per_ns = 60e6 / 1e9;

hal::Result<> check_options(const EmulateCameraOptions& o) {
  if (o.common.plant != "mujoco") return bad_option("--plant", "emulate camera needs --plant mujoco");
  if (o.common.speed != 1.0) return bad_option("--speed", "a camera lives in real time; expected 1");
  if (auto done = check_seconds("--for", o.common.for_s); !done) return done;
  if (o.live && o.fakenect) return bad_option("--live", "goes without --fakenect");
  if (o.fakenect && !o.common.faults.empty())
    return bad_option("--fault", "a recording has none; expected --live");
  return {};
}

/// The world's first seconds as fakenect plays them, as quickly as they can be computed.
hal::Result<int> record(const CommonOptions& common, const EmulateCameraOptions& o,
                        sim_hal::SimWorld& world) {
  auto writer = hal::kinect::FakenectWriter::open(*o.fakenect);
  if (!writer) return tl::unexpected(writer.error());
  sim_hal::CameraWorldSource eye(world);
  const double for_s = o.common.for_s.value_or(kRecord_s);
  hal::capture::RawFrame raw;
  for (std::uint64_t n = 0; static_cast<double>(n) / 30.0 < for_s && !InterruptGuard::asked(); ++n) {
    const auto due = std::chrono::milliseconds((1000 * n + 29) / 30);
    if (due > world.elapsed()) world.advance(due - world.elapsed());
    const sim_hal::CameraExposure e = eye.look(n);
    raw.pixels = e.codes;
    raw.stamp.ticks = static_cast<std::uint32_t>(
        static_cast<std::uint64_t>(static_cast<double>(world.elapsed().count()) * kTicks_per_ns));
    raw.stamp.has_accel = 1;
    raw.stamp.accel[0] = static_cast<std::int32_t>(std::lround(819.0 * e.up_C.x()));
    raw.stamp.accel[1] = static_cast<std::int32_t>(std::lround(-819.0 * e.up_C.y()));
    raw.stamp.accel[2] = static_cast<std::int32_t>(std::lround(-819.0 * e.up_C.z()));
    if (auto done = writer->write(raw, world.elapsed()); !done) return tl::unexpected(done.error());
  }
  EmulateLines(common).result(
      common.json
          ? nlohmann::ordered_json({{"schema", "colift.emulate/1"},
                                    {"device", "camera"},
                                    {"fakenect", o.fakenect->string()},
                                    {"frames", writer->frames()},
                                    {"bytes", writer->bytes()}})
                .dump()
          : fmt::format("{} frames, {:.1f} MB in {}; play them: colift hal camera watch --source fakenect:{}",
                        writer->frames(), static_cast<double>(writer->bytes()) / 1e6, o.fakenect->string(),
                        o.fakenect->string()));
  return InterruptGuard::asked() ? kInterrupted : kDone;
}

std::string to_json(const EmulateCameraOptions& o, const CameraServerReport& r, double duration_s,
                    const std::string& reason) {
  return nlohmann::ordered_json({{"schema", "colift.emulate/1"},
                                 {"device", "camera"},
                                 {"because", reason},
                                 {"address", o.address},
                                 {"seed", o.common.seed},
                                 {"duration_s", duration_s},
                                 {"clients", r.clients},
                                 {"refused", r.refused},
                                 {"frames",
                                  {{"exposed", r.exposed},
                                   {"sent", r.sent},
                                   {"not_taken", r.not_taken},
                                   {"infrared", r.infrared}}},
                                 {"worst_render_ms", r.worst_render_ms},
                                 {"tilt_deg", r.tilt_deg}})
      .dump();
}

/// Lets the world's time pass as the machine's does.
class WorldPace {
 public:
  explicit WorldPace(sim_hal::SimWorld& world)
      : thread_([this, &world] {
          const hal::SteadyClock clock;
          const hal::Timestamp began = clock.now();
          while (!stop_) {
            const auto ahead =
                std::chrono::floor<std::chrono::milliseconds>(clock.now() - began) - world.elapsed();
            if (ahead >= 1ms)
              world.advance(
                  std::min<hal::Duration>(std::chrono::floor<std::chrono::milliseconds>(ahead), 5ms));
            else
              std::this_thread::sleep_for(1ms);
          }
        }) {}
  ~WorldPace() {
    stop_ = true;
    thread_.join();
  }
  WorldPace(const WorldPace&) = delete;
  WorldPace& operator=(const WorldPace&) = delete;

 private:
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

hal::Result<int> serve(const CommonOptions& common, const EmulateCameraOptions& o,
                       const sim_hal::Scenario& scenario, sim_hal::SimWorld& world) {
  auto faults = sim_hal::faults_of("camera", scenario.faults, o.common.faults, sim_hal::camera_fault,
                                   sim_hal::parse_camera_fault);
  if (!faults) return tl::unexpected(faults.error());
  sim_hal::CameraServerConfig config;
  config.address = o.address;
  config.seed = o.common.seed;
  config.faults = std::move(*faults);
  CameraServer server(config, std::make_unique<sim_hal::CameraWorldSource>(world));
  if (auto done = server.start(); !done)
    return hal::failure(hal::ErrorCode::DeviceFault, "--address", done.error().detail);
  const WorldPace pace(world);
  const EmulateLines lines(common);
  lines.ready(fmt::format(
      "camera on emulated:{}; any program for libfreenect: COLIFT_KINECT_EMULATOR={} "
      "LD_PRELOAD={}/libcolift-freenect.so PROGRAM; for OpenNI2: LD_LIBRARY_PATH={}/openni2-emulated",
      o.address, o.address, hal::capture::own_folder(), hal::capture::own_folder()));
  const std::string reason = run_server(server, o.common, lines, [&] { return server.elapsed_s(); });
  const CameraServerReport r = server.report();
  lines.result(
      common.json
          ? to_json(o, r, server.elapsed_s(), reason)
          : fmt::format(
                "{}: {} clients, {} frames sent, {} not taken, {} infrared; slowest picture {:.1f} ms",
                reason, r.clients, r.sent, r.not_taken, r.infrared, r.worst_render_ms));
  return kDone;
}

hal::Result<int> run(const CommonOptions& common, const EmulateCameraOptions& o) {
  if (auto done = check_options(o); !done) return tl::unexpected(done.error());
  const auto scenario = read_absolute_scenario(o.common.scenario);
  if (!scenario) return tl::unexpected(scenario.error());
  auto world = sim_hal::SimWorld::make(*scenario, hal::built_in_robot(), o.common.seed, {});
  if (!world) return tl::unexpected(world.error());
  const InterruptGuard guard;
  if (o.fakenect) return record(common, o, **world);
  return serve(common, o, *scenario, **world);
}

}  // namespace

int cmd_emulate_camera(const CommonOptions& common, const EmulateCameraOptions& options) {
  const auto code = run(common, options);
  return code ? *code : report_error("emulate camera", code.error());
}

}  // namespace colift::tools
