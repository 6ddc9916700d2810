#include "tools/run/run_recording.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <unistd.h>

#include <ctime>

#include "hal/drivers/recorded/file_bytes.hpp"
#include "tools/rig/robot_file.hpp"
#include "tools/rig/wired_devices.hpp"
#include "tools/run/run_view.hpp"
#include "tools/telemetry/channels/built_in_texts.hpp"
#include "tools/telemetry/record/flight_request.hpp"
#include "tools/telemetry/record/recorder.hpp"
#include "tools/telemetry/record/run_documents.hpp"
#include "tools/telemetry/record/run_telemetry.hpp"

namespace colift::tools {
namespace {

hal::Result<std::string> text_of(const std::filesystem::path& file) {
  const auto bytes = hal::load_file(file);
  if (!bytes) return tl::unexpected(bytes.error());
  return std::string(hal::as_text(*bytes));
}

hal::Result<telemetry::RunDescription> describe(const CommonOptions& common, const RunOptions& options,
                                                const control::JobOptions& job, const Rig& rig,
                                                Setup& setup) {
  telemetry::RunDescription run;
  run.version = telemetry::program_version();
  run.command = common.command;
  run.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  run.config_yaml = control::yaml_of(setup);
  run.X_WC = rig.X_WC;
  run.X_WC_more = rig.X_WC_more;
  run.method = job.method;
  run.seed = job.seed;
  run.dry_run = job.dry_run;
  run.drive = job.drive;
  const auto robot = read_robot_file(options.robot);
  if (!robot) return tl::unexpected(robot.error());
  const auto read = [](const std::optional<std::filesystem::path>& file, std::string& to) -> hal::Result<> {
    if (!file || file->empty()) return {};
    auto text = text_of(*file);
    if (!text) return tl::unexpected(text.error());
    to = std::move(*text);
    return {};
  };
  if (auto done = read(options.robot, run.robot_file); !done) return tl::unexpected(done.error());
  if (auto done = read(std::filesystem::path(robot->model), run.robot_urdf); !done)
    return tl::unexpected(done.error());
  if (robot->model.empty()) run.robot_urdf = telemetry::built_in_robot_urdf();
  if (auto done = read(std::filesystem::path(setup.config.hand_file), run.hand_yaml); !done)
    return tl::unexpected(done.error());
  if (auto done = read(options.scenario, run.scenario_yaml); !done) return tl::unexpected(done.error());
  if (rig.truth && !options.scenario) run.scenario_yaml = telemetry::built_in_scenario_yaml();
  return run;
}

class Recording final : public RunRecording {
 public:
  std::optional<std::filesystem::path> file;
  std::optional<telemetry::FlightPost> post;
  std::unique_ptr<telemetry::Recorder> recorder;
  std::unique_ptr<telemetry::RunTelemetry> telemetry;

  [[nodiscard]] control::JobHooks hooks(control::JobHooks yours) override {
    return telemetry->hooks(std::move(yours));
  }
  void truth(hal::Timestamp at, const TruthSample& s) override {
    telemetry::TruthNow now{s.t_s, s.robot_force_z_n, s.partner_force_z_n, s.floor_force_z_n,
                            {},    s.tilt_rad,        s.height_m,          s.slip_m};
    now.share = true_share(s);
    telemetry->truth(at, now);
  }
  std::vector<std::string> finish(const control::RunRecord& record, const std::string& document,
                                  bool quiet) override {
    std::vector<std::string> lines;
    if (!recorder) return lines;
    telemetry::RunDocuments end;
    end.attachments.push_back({0, 0, "run.json", "application/json", document});
    end.metadata.push_back(
        {"colift.result", {{"outcome", word(record.outcome)}, {"because", record.reason}}});
    const telemetry::RecorderReport report = recorder->finish(end);
    post.reset();  // nobody answers any more
    if (file && !quiet)
      lines.push_back(fmt::format("recording: {}, {} messages, {:.1f} MB", file->string(), report.written,
                                  1e-6 * static_cast<double>(report.file_bytes)));
    if (report.lost_queue > 0)
      lines.push_back(fmt::format("recording: {} messages were lost, the disk or the processor was too slow",
                                  report.lost_queue));
    if (report.lost_disk > 0)
      lines.push_back(fmt::format("recording: {} messages were lost", report.lost_disk));
    if (!report.error.empty()) lines.push_back("recording: " + report.error);
    if (file && !report.complete)
      lines.push_back("recording: it has no end; colift log recover makes a whole file of it");
    for (const auto& flight : report.flights)
      lines.push_back(fmt::format("recording: the last seconds are in {}", flight.string()));
    return lines;
  }
};

}  // namespace

hal::Result<std::unique_ptr<RunRecording>> open_recording(
    const CommonOptions& common, const RunOptions& options, const control::JobOptions& job, Rig& rig,
    Setup& setup, const hal::Clock& wall, const std::vector<telemetry::TelemetrySink*>& watchers) {
  // a simulated run can be run once more; what happened on real wires cannot
  const bool flies = options.flight || job.drive == control::Drive::Thread;
  if (!options.record && !flies && watchers.empty()) return std::unique_ptr<RunRecording>();
  const auto run = describe(common, options, job, rig, setup);
  if (!run) return tl::unexpected(run.error());
  auto impl = std::make_unique<Recording>();
  std::vector<telemetry::TelemetrySink*> sinks = watchers;

  if (options.record || flies) {
    telemetry::RecorderConfig config;
    config.file = impl->file = options.record;
    if (options.flight) {
      config.flight = options.flight;
    } else if (flies) {
      const auto folder = telemetry::flight_folder();
      std::error_code error;
      std::filesystem::create_directories(folder, error);
      config.flight = folder / fmt::format("flight-{:%Y%m%d-%H%M%S}-{}.mcap", fmt::gmtime(std::time(nullptr)),
                                           ::getpid());
    }
    config.wait_when_full = job.drive == control::Drive::InStep;
    if (auto post = telemetry::FlightPost::open()) {
      impl->post.emplace(std::move(*post));
      config.snapshot_asked = [i = impl.get()] { return i->post->asked(); };
    }
    auto recorder = telemetry::Recorder::start(config, telemetry::documents_of(*run));
    if (!recorder) return tl::unexpected(recorder.error());
    impl->recorder = std::move(*recorder);
    sinks.push_back(impl->recorder.get());
  }
  impl->telemetry = std::make_unique<telemetry::RunTelemetry>(
      telemetry::RunTelemetry::Setting{rig.model.get(), rig.X_WC, rig.X_WC_more, job.drive, true, &setup.hand,
                                       run->robot_urdf},
      sinks, wall);
  impl->telemetry->tap(rig.robot);
  if (impl->recorder)
    impl->telemetry->on_fault([r = impl->recorder.get()](const std::string&) { r->fault(); });
  return impl;
}

RunParts all_run_parts() {
  return {&wired_devices(), open_view, open_recording, open_ros2};
}

}  // namespace colift::tools
