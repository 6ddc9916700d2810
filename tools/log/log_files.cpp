// Recordings made into other files.

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/cli/session.hpp"
#include "tools/log/cmd_log.hpp"
#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"
#include "tools/telemetry/replay/export.hpp"
#include "tools/telemetry/replay/recover.hpp"
#ifdef COLIFT_DDS
#include "tools/dds/export_ros2.hpp"
#endif

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;
using telemetry::dumped;
using telemetry::Exported;

hal::Result<Exported> exported_for_ros2([[maybe_unused]] const telemetry::McapReader& reader,
                                        [[maybe_unused]] const std::filesystem::path& folder) {
#ifdef COLIFT_DDS
  return ros2::export_ros2(reader, folder);
#else
  return hal::failure(
      hal::ErrorCode::BadInput, "--format ros2",
      "this program was built without Cyclone DDS (Debian: cyclonedds-dev, cyclonedds-tools)");
#endif
}

hal::Result<Exported> exported(const telemetry::McapReader& reader, const std::string& format,
                               const std::filesystem::path& folder) {
  if (format == "csv") return telemetry::export_csv(reader, folder);
  if (format == "png") return telemetry::export_png(reader, folder);
  if (format == "fakenect") return telemetry::export_fakenect(reader, folder);
  if (format == "ros2") return exported_for_ros2(reader, folder);
  return hal::failure(hal::ErrorCode::BadInput, "--format",
                      fmt::format("\"{}\" is none; expected csv, png, fakenect or ros2", format));
}

}  // namespace

int log_export(const CommonOptions& common, const LogOptions& options) {
  constexpr const char* kCommand = "log export";
  auto source = telemetry::open_file(options.file);
  if (!source) return report_error(kCommand, source.error());
  const auto reader = telemetry::McapReader::open(std::move(*source), options.file.string());
  if (!reader) return report_error(kCommand, reader.error());
  std::vector<std::string> formats = options.formats;
  if (formats.empty()) formats.push_back("csv");
  const std::filesystem::path out =
      options.out.value_or(options.file.parent_path() / (options.file.stem().string() + "-export"));

  if (!common.json)
    for (const std::string& damage : reader->info().damage)
      std::fputs(fmt::format("{}: {}; what can be read is exported\n", options.file.string(), damage).c_str(),
                 stdout);
  Json j = {{"schema", "colift.log.export/1"}, {"damage", reader->info().damage}, {"exports", Json::array()}};
  for (const std::string& format : formats) {
    // each in a folder of its own when there are several, so that no index lists what is not its own
    const std::filesystem::path folder = formats.size() > 1 ? out / format : out;
    const auto done = exported(*reader, format, folder);
    if (!done) return report_error(kCommand, done.error());
    j["exports"].push_back(
        {{"format", format}, {"folder", folder.string()}, {"files", done->count}, {"notes", done->notes}});
    if (common.json) continue;
    std::fputs(fmt::format("{}: {} files in {}\n", format, done->count, folder.string()).c_str(), stdout);
    for (const std::string& note : done->notes) std::fputs(("  " + note + "\n").c_str(), stdout);
  }
  if (common.json) std::puts(dumped(j).c_str());
  return kDone;
}

int log_recover(const CommonOptions& common, const LogOptions& options) {
  constexpr const char* kCommand = "log recover";
  auto source = telemetry::open_file(options.file);
  if (!source) return report_error(kCommand, source.error());
  const auto reader = telemetry::McapReader::open(std::move(*source), options.file.string());
  if (!reader) return report_error(kCommand, reader.error());
  const std::filesystem::path out =
      options.out.value_or(options.file.parent_path() / (options.file.stem().string() + ".recovered.mcap"));
  std::error_code ignored;
  if (std::filesystem::equivalent(out, options.file, ignored))
    return report_error(kCommand, {hal::ErrorCode::BadInput, out.string(),
                                   "is the damaged file itself; give another one with --out"});
  const auto done = telemetry::recover(*reader, out);
  if (!done) return report_error(kCommand, done.error());
  if (common.json) {
    std::puts(dumped({{"schema", "colift.log.recover/1"},
                      {"file", out.string()},
                      {"bytes", done->bytes},
                      {"messages", done->messages},
                      {"attachments", done->attachments},
                      {"metadata", done->metadata},
                      {"damage", done->damage}})
                  .c_str());
    return kDone;
  }
  std::fputs(fmt::format("{}: {} messages, {} attachments, {:.1f} MB\n", out.string(), done->messages,
                         done->attachments, 1e-6 * static_cast<double>(done->bytes))
                 .c_str(),
             stdout);
  for (const std::string& d : done->damage) std::fputs(fmt::format("  {}\n", d).c_str(), stdout);
  return kDone;
}

}  // namespace colift::tools
