#include "tools/log/cmd_log.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "tools/cli/session.hpp"
#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/record/flight_request.hpp"

namespace colift::tools {
namespace {

constexpr double kSnapshotTimeout_s = 10.0;

int log_snapshot(const CommonOptions& common, const LogOptions& options) {
  std::optional<pid_t> pid;
  if (options.pid) pid = *options.pid;
  if (auto done = telemetry::ask_for_flight(options.file, pid, kSnapshotTimeout_s); !done) {
    report_error("log snapshot", done.error());
    return done.error().code == hal::ErrorCode::BadInput ? kBadInput : kNoGoal;
  }
  if (common.json)
    std::puts(
        telemetry::dumped({{"schema", "colift.log.snapshot/1"}, {"file", options.file.string()}}).c_str());
  else
    std::fputs(fmt::format("the last seconds are in {}\n", options.file.string()).c_str(), stdout);
  return kDone;
}

}  // namespace

int cmd_log(const CommonOptions& common, const LogOptions& options) {
  if (options.verb == "info") return log_info(common, options);
  if (options.verb == "compare") return log_compare(common, options);
  if (options.verb == "export") return log_export(common, options);
  if (options.verb == "recover") return log_recover(common, options);
  if (options.verb == "replay") return log_replay(common, options);
  return log_snapshot(common, options);
}

}  // namespace colift::tools
