#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "control/config/resolve_config.hpp"
#include "hal/config/config_file.hpp"
#include "tools/cli/config_of.hpp"
#include "tools/cli/interrupt.hpp"
#include "tools/cli/session.hpp"
#include "tools/log/cmd_log.hpp"
#include "tools/run/run_live.hpp"
#include "tools/run/run_pace.hpp"
#include "tools/telemetry/channels/built_in_texts.hpp"
#include "tools/telemetry/channels/json_parts.hpp"
#include "tools/telemetry/replay/page_recording.hpp"
#include "tools/telemetry/replay/replay.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::ordered_json;
using telemetry::dumped;
using telemetry::ReplayDifference;
using telemetry::ReplayReport;
using telemetry::Topic;

constexpr std::size_t kShown = 12;

hal::Result<planner::HandModel> recorded_hand(const std::string& yaml) {
  planner::HandModel hand;
  hal::FieldTable table = hal::table_of(hand);
  if (auto done = hal::apply_yaml_text(table, yaml, "recorded hand.yaml"); !done)
    return tl::unexpected(done.error());
  if (auto done = planner::check_hand(hand); !done) return tl::unexpected(done.error());
  return hand;
}

/// The recorded configuration, with the files and settings of the command line over it.
hal::Result<control::ResolvedConfig> config_of_replay(const CommonOptions& common,
                                                      const telemetry::RunDescription& run) {
  control::ConfigRequest request;
  request.command = control::Command::Replay;
  request.recorded = {run.config_yaml, run.method, run.config_complete};
  request.files = common.config_files;
  request.settings = common.settings;
  return control::resolve_config(request);
}

/// A recording, opened, and what it says about its run.
struct Opened {
  telemetry::McapReader reader;
  telemetry::RunDescription run;
};
hal::Result<Opened> open_recording(const std::filesystem::path& file) {
  auto source = telemetry::open_file(file);
  if (!source) return tl::unexpected(source.error());
  auto reader = telemetry::McapReader::open(std::move(*source), file.string());
  if (!reader) return tl::unexpected(reader.error());
  auto run = telemetry::description_of(*reader, file.string());
  if (!run) return tl::unexpected(run.error());
  return Opened{std::move(*reader), std::move(*run)};
}

/// What the replay of a run works with.
hal::Result<telemetry::ReplaySetting> setting_of(const control::ResolvedConfig& resolved,
                                                 const telemetry::RunDescription& run) {
  telemetry::ReplaySetting s;
  s.config = resolved.config;
  const auto origin = resolved.origins.find("hand_file");
  const bool other_hand = origin != resolved.origins.end() && !origin->second.starts_with("recorded");
  if (other_hand && !s.config.hand_file.empty()) {
    auto hand = planner::load_hand(s.config.hand_file);
    if (!hand) return tl::unexpected(hand.error());
    s.hand = std::move(*hand);
  } else if (!run.hand_yaml.empty()) {
    auto hand = recorded_hand(run.hand_yaml);
    if (!hand) return tl::unexpected(hand.error());
    s.hand = std::move(*hand);
  }
  s.hand_tables = std::make_shared<planner::HandCollision>(s.hand, s.config.candidates.collision);
  if (run.robot_urdf.empty()) {
    s.model = std::make_shared<hal::RobotModel>(hal::built_in_robot());
  } else {
    auto model = hal::parse_robot(run.robot_urdf, "recorded robot.urdf");
    if (!model) return tl::unexpected(model.error());
    s.model = std::make_shared<hal::RobotModel>(std::move(*model));
  }
  return s;
}

Json parsed(const std::string& message) {
  if (message.empty()) return nullptr;
  Json j = Json::parse(message, nullptr, false);
  return j.is_discarded() ? Json(nullptr) : j;
}

/// Where two messages part: keys with both values. Of a decision's candidates, those with another verdict.
Json parting(const Json& a, const Json& b) {
  if (!a.is_object() || !b.is_object()) return {{"recorded", a}, {"replayed", b}};
  Json out = Json::object();
  for (const auto& [key, value] : a.items()) {
    if (!b.contains(key) || b[key] == value) continue;
    if (key != "candidates" || !value.is_array() || !b[key].is_array()) {
      out[key] = {{"recorded", value}, {"replayed", b[key]}};
      continue;
    }
    Json& list = out[key] = Json::array();
    const std::size_t common = std::min(value.size(), b[key].size());
    for (std::size_t i = 0; i < common; ++i) {
      Json part = parting(value[i], b[key][i]);
      if (!part.empty()) list.push_back({{"index", i}, {"differs", std::move(part)}});
    }
    if (value.size() != b[key].size())
      list.push_back({{"count", {{"recorded", value.size()}, {"replayed", b[key].size()}}}});
  }
  return out;
}

Json document(const LogOptions& options, const telemetry::RunDescription& run, const ReplayReport& r) {
  Json compared = Json::object(), differences = Json::array();
  for (const auto& [topic, count] : r.compared) compared[telemetry::channel_of(topic).topic] = count;
  for (const ReplayDifference& d : r.differences)
    differences.push_back({{"topic", telemetry::channel_of(d.topic).topic},
                           {"index", d.index},
                           {"differs", parting(parsed(d.recorded), parsed(d.replayed))}});
  return {{"schema", "colift.replay/1"},
          {"file", options.file.string()},
          {"recorded_by", run.version},
          {"replayed_by", telemetry::program_version()},
          {"same", r.same()},
          {"cycles", r.cycles},
          {"compared", std::move(compared)},
          {"differing", r.differing},
          {"differences", std::move(differences)},
          {"notes", r.notes}};
}

/// Of a recording that was shown and not replayed.
std::string shown_document(const LogOptions& options, const telemetry::RunDescription& run,
                           const std::string& note) {
  return dumped({{"schema", "colift.replay/1"},
                 {"file", options.file.string()},
                 {"recorded_by", run.version},
                 {"same", nullptr},
                 {"notes", {note}}}) +
         "\n";
}

std::string short_text(const Json& j) {
  std::string text = j.is_string() ? j.get<std::string>() : j.dump();
  if (text.size() > 160) text = text.substr(0, 157) + "...";
  return text;
}

std::string text(const Json& j) {
  std::string out;
  for (const Json& note : j["notes"]) out += "note: " + note.get<std::string>() + "\n";
  if (j["recorded_by"] != j["replayed_by"])
    out += fmt::format("recorded by version {}, replayed by {}\n", short_text(j["recorded_by"]),
                       short_text(j["replayed_by"]));
  std::string counts;
  for (const auto& [topic, count] : j["compared"].items())
    counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", count.get<std::uint64_t>(), topic);
  if (j["same"].get<bool>())
    return out + fmt::format("the same, bit for bit: {} cycles of the task; {}\n",
                             j["cycles"].get<std::uint64_t>(), counts);
  out += fmt::format("{} messages differ (compared: {}); the first:\n", j["differing"].get<std::uint64_t>(),
                     counts);
  std::size_t shown = 0;
  for (const Json& d : j["differences"]) {
    if (shown++ == kShown) break;
    out += fmt::format("{} {}\n", d["topic"].get<std::string>(), d["index"].get<std::uint64_t>());
    for (const auto& [key, value] : d["differs"].items()) {
      if (value.is_object() && value.contains("recorded"))
        out += fmt::format("  {}: recorded {}, replayed {}\n", key, short_text(value["recorded"]),
                           short_text(value["replayed"]));
      else
        out += fmt::format("  {}: {}\n", key, short_text(value));
    }
  }
  return out;
}

}  // namespace

hal::Result<control::ResolvedConfig> config_of_replay(const CommonOptions& common,
                                                      const LogOptions& options) {
  if (options.file.empty())
    return hal::failure(hal::ErrorCode::BadInput, "FILE",
                        "a replay starts from the configuration in its recording; name the recording");
  const auto opened = open_recording(options.file);
  if (!opened) return tl::unexpected(opened.error());
  return config_of_replay(common, opened->run);
}

int log_replay(const CommonOptions& common, const LogOptions& options) {
  constexpr const char* kCommand = "log replay";
  auto opened = open_recording(options.file);
  if (!opened) return report_error(kCommand, opened.error());
  const telemetry::McapReader& reader = opened->reader;
  telemetry::RunDescription& run = opened->run;
  const auto resolved = config_of_replay(common, run);
  if (!resolved) return report_error(kCommand, resolved.error());
  show_warnings(kCommand, common, *resolved);
  run.method = resolved->method;
  auto setting = setting_of(*resolved, run);
  if (!setting) return report_error(kCommand, setting.error());
  const auto speed = speed_of(options.live, control::Drive::InStep);
  if (!speed) return report_error(kCommand, speed.error());
  std::map<std::string, live::Document> documents;
  constexpr const char* kText = "text/plain; charset=utf-8";
  if (options.live.view) documents["/recording.txt"] = {kText, telemetry::page_recording(reader)};
  if (options.beside) {
    if (!options.live.view)
      return report_error(kCommand,
                          {hal::ErrorCode::BadInput, "--beside", "is for the page; expected --view"});
    const auto other = open_recording(*options.beside);
    if (!other) return report_error(kCommand, other.error());
    documents["/beside.txt"] = {kText, telemetry::page_recording(other->reader)};
  }
  const auto live = RunLive::open(
      options.live, fmt::format("CoLift, recording {}", options.file.filename().string()),
      run.robot_urdf.empty() ? telemetry::built_in_robot_urdf() : run.robot_urdf, std::move(documents));
  if (!live) return report_error(kCommand, live.error());
  const InterruptGuard signals;
  const auto enough = [&] { return InterruptGuard::asked() || (*live && (*live)->stopped()); };
  setting->interrupted = enough;
  if (*live) {
    setting->watchers.push_back(&(*live)->sink());
    const std::string url = (*live)->url();
    std::fprintf(stderr, "live view: %s\n", url.c_str());
    if (options.beside)
      std::fprintf(stderr, "both side by side: %s/both.html\n", url.substr(0, url.find('/', 8)).c_str());
  }
  Pace pace(*speed);
  if (*speed > 0.0)
    setting->pace = [&](hal::Timestamp at) {
      if (!enough()) pace.wait_for(at);
    };

  std::string said;
  int ended_with = kDone;
  const auto whole = telemetry::can_replay(reader, options.file.string());
  if (!whole && *live) {
    // the flight recorder's last seconds, say: nothing to decide, but something to see
    telemetry::play_recording(reader, *setting);
    const std::string note = whole.error().text() + "; it was shown as it was recorded";
    said = common.json ? shown_document(options, run, note) : note + "\n";
  } else {
    const auto report = telemetry::replay(reader, options.file.string(), run, *setting);
    if (enough()) return kInterrupted;
    if (!report) return report_error(kCommand, report.error());
    const Json j = document(options, run, *report);
    said = common.json ? dumped(j) + "\n" : text(j);
    ended_with = report->same() ? kDone : kNoGoal;
  }
  if (enough()) return kInterrupted;
  std::fputs(said.c_str(), stdout);
  std::fflush(stdout);
  if (*live) {
    std::fprintf(stderr, "the live view keeps the last state at %s; Ctrl-C ends it\n",
                 (*live)->url().c_str());
    (*live)->stay(enough);
    if ((*live)->stopped()) return kInterrupted;
  }
  return ended_with;
}

}  // namespace colift::tools
