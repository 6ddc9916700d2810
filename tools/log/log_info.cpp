#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/cli/session.hpp"
#include "tools/log/cmd_log.hpp"
#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/mcap/mcap_reader.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;
using telemetry::dumped;
using telemetry::McapInfo;

double seconds(std::uint64_t ns) {
  return 1e-9 * static_cast<double>(ns);
}

std::uint64_t messages_of(const McapInfo& info, std::uint16_t channel) {
  const auto found = info.statistics.per_channel.find(channel);
  return found == info.statistics.per_channel.end() ? 0 : found->second;
}

Json document(const telemetry::McapReader& reader) {
  const McapInfo& info = reader.info();
  Json channels = Json::array(), attachments = Json::array(), metadata = Json::object();
  const double duration = seconds(info.statistics.end_time - info.statistics.start_time);
  for (const auto& [id, c] : info.channels) {
    const std::uint64_t n = messages_of(info, id);
    const auto schema = info.schemas.find(c.schema_id);
    channels.push_back({{"topic", c.topic},
                        {"encoding", c.message_encoding},
                        {"schema", schema == info.schemas.end() ? "" : schema->second.name},
                        {"messages", n},
                        {"rate_hz", duration > 0.0 ? static_cast<double>(n) / duration : 0.0}});
  }
  for (const auto& a : info.attachments)
    attachments.push_back({{"name", a.name}, {"type", a.content_type}, {"bytes", a.data_size}});
  for (const auto& m : info.metadata)
    if (const auto found = reader.metadata(m.name)) metadata[m.name] = found->entries;
  return {{"schema", "colift.log.info/1"},
          {"bytes", info.size},
          {"readable_bytes", info.readable},
          {"complete", info.complete},
          {"damage", info.damage},
          {"library", info.library},
          {"start_s", seconds(info.statistics.start_time)},
          {"duration_s", duration},
          {"messages", info.statistics.messages},
          {"chunks", info.statistics.chunks},
          {"channels", std::move(channels)},
          {"attachments", std::move(attachments)},
          {"metadata", std::move(metadata)}};
}

/// What comes from the file is shown without anything that a terminal obeys.
std::string shown(const Json& text) {
  std::string out = text.get<std::string>();
  for (char& c : out)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '?';
  return out;
}

std::string text(const Json& j) {
  std::string out =
      fmt::format("{:.1f} MB, {:.2f} s from {:.2f} s on, {} messages in {} chunks\n",
                  1e-6 * j["bytes"].get<double>(), j["duration_s"].get<double>(), j["start_s"].get<double>(),
                  j["messages"].get<std::uint64_t>(), j["chunks"].get<std::uint64_t>());
  if (!j["complete"].get<bool>())
    out +=
        fmt::format("not whole: {} of {} bytes can be read; colift log recover makes a whole file of them\n",
                    j["readable_bytes"].get<std::uint64_t>(), j["bytes"].get<std::uint64_t>());
  for (const Json& d : j["damage"]) out += "  " + shown(d) + "\n";
  for (const auto& [name, entries] : j["metadata"].items()) {
    out += shown(Json(name)) + "\n";
    for (const auto& [key, value] : entries.items())
      out += fmt::format("  {:<16}{}\n", shown(Json(key)), shown(value));
  }
  out += "channels\n";
  for (const Json& c : j["channels"])
    out += fmt::format("  {:<22}{:>8}  {:>7.1f} Hz  {}\n", shown(c["topic"]),
                       c["messages"].get<std::uint64_t>(), c["rate_hz"].get<double>(),
                       c["schema"] == "" ? shown(c["encoding"]) : shown(c["schema"]));
  out += "attachments\n";
  for (const Json& a : j["attachments"])
    out += fmt::format("  {:<22}{:>8}  {}\n", shown(a["name"]), a["bytes"].get<std::uint64_t>(),
                       shown(a["type"]));
  return out;
}

}  // namespace

int log_info(const CommonOptions& common, const LogOptions& options) {
  auto source = telemetry::open_file(options.file);
  if (!source) return report_error("log info", source.error());
  const auto reader = telemetry::McapReader::open(std::move(*source), options.file.string());
  if (!reader) return report_error("log info", reader.error());
  const Json j = document(*reader);
  std::fputs((common.json ? dumped(j) + "\n" : text(j)).c_str(), stdout);
  return kDone;
}

}  // namespace colift::tools
