#pragma once

// A whole simulated lift that is recorded, and its replay: what the tests of this folder share.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "control/config/config.hpp"
#include "control/task/run_record.hpp"
#include "sim_hal/scenario/scenario.hpp"
#include "tools/telemetry/record/recorder.hpp"
#include "tools/telemetry/replay/replay.hpp"

namespace colift::telemetry::test {

[[nodiscard]] sim_hal::Scenario short_lift();

struct Recorded {
  control::RunRecord record;
  RecorderReport report;
};

/// `pushed`: the camera's true pose in the calibrated one. `settings`: of the configuration, "KEY=VALUE".
[[nodiscard]] Recorded run(const sim_hal::Scenario& scenario, const std::filesystem::path* file,
                           const hal::Pose& pushed = hal::Pose::Identity(),
                           const std::vector<std::string>& settings = {});

/// Counts what a viewer of a replay gets.
class Watcher final : public TelemetrySink {
 public:
  void publish(const Publication& p) override {
    ++count[p.topic];
    if (p.topic == Topic::Devices || p.topic == Topic::Map) text[p.topic] = p.encode();
  }
  std::map<Topic, std::size_t> count;
  std::map<Topic, std::string> text;
};

[[nodiscard]] hal::Result<ReplayReport> replayed(const McapReader& reader,
                                                 const std::vector<std::string>& settings = {},
                                                 Watcher* watcher = nullptr);

[[nodiscard]] McapReader opened(const std::filesystem::path& file);

}  // namespace colift::telemetry::test
