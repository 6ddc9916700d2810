#include "tools/log/recorded_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "hal/config/yaml_tree.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::tools {
namespace {

using Json = nlohmann::json;
using telemetry::Topic;

// A recording may come from anybody: what is not there, or of another kind, is unknown.

const Json* member(const Json& j, const char* key) {
  if (!j.is_object()) return nullptr;
  const auto found = j.find(key);
  return found == j.end() ? nullptr : &*found;
}

std::optional<double> number(const Json& j, const char* key) {
  const Json* value = member(j, key);
  if (value == nullptr || !value->is_number()) return std::nullopt;
  const double d = value->get<double>();
  return std::isfinite(d) ? std::optional(d) : std::nullopt;
}

std::optional<int> whole_number(const Json& j, const char* key) {
  const auto d = number(j, key);
  return d && std::abs(*d) < 1e9 ? std::optional(static_cast<int>(*d)) : std::nullopt;
}

std::string words(const Json& j, const char* key) {
  const Json* value = member(j, key);
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

std::optional<hal::Vec3> position(const Json& j, const char* key) {
  const Json* value = member(j, key);
  if (value == nullptr || !value->is_array() || value->size() != 3) return std::nullopt;
  hal::Vec3 out;
  for (int i = 0; i < 3; ++i) {
    const Json& v = (*value)[static_cast<std::size_t>(i)];
    if (!v.is_number()) return std::nullopt;
    out[i] = v.get<double>();
  }
  return out.allFinite() ? std::optional(out) : std::nullopt;
}

RecordedDecision decision_of(const Json& j) {
  RecordedDecision out;
  out.chosen = whole_number(j, "chosen");
  out.share = number(j, "share");
  out.cost = number(j, "cost");
  out.partner_W = position(j, "partner");
  out.reason = words(j, "because");
  const Json* candidates = member(j, "candidates");
  if (candidates == nullptr || !candidates->is_array()) return out;
  for (const Json& c : *candidates) {
    const auto id = whole_number(c, "id");
    if (!id) continue;
    out.candidates.push_back({*id, words(c, "kind"), words(c, "verdict"), words(c, "because"),
                              position(c, "position"), number(c, "share"), number(c, "cost")});
  }
  return out;
}

void append(RecordedRun& run, Quantity quantity, double t_s, std::optional<double> value) {
  if (!value) return;
  RecordedCurve& curve = run.curves[quantity];
  if (!curve.t_s.empty() && t_s <= curve.t_s.back()) return;
  curve.t_s.push_back(t_s);
  curve.value.push_back(*value);
}

void take(RecordedRun& run, Topic topic, double t_s, const Json& j) {
  switch (topic) {
    case Topic::Change:
      if (!run.states.empty()) run.states.back().to_s = t_s;
      run.states.push_back({words(j, "state"), words(j, "because"), t_s, t_s});
      break;
    case Topic::Decision:
      run.decision = decision_of(j);
      break;
    case Topic::Load:
      append(run, Quantity::Load, t_s, number(j, "load_n"));
      append(run, Quantity::Share, t_s, number(j, "share"));
      append(run, Quantity::Height, t_s, number(j, "height_m"));
      append(run, Quantity::Tilt, t_s, number(j, "tilt_deg"));
      append(run, Quantity::Slip, t_s, number(j, "slip_m"));
      break;
    case Topic::Status:
      if (const Json* s = member(j, "separation")) {
        append(run, Quantity::Distance, t_s, number(*s, "distance_m"));
        append(run, Quantity::SpeedScale, t_s, number(*s, "speed_scale"));
      }
      break;
    default:
      break;
  }
}

/// The leaves of a document as "a.b[2].c"; a list of plain values is one value.
void flatten(const hal::YamlTree& tree, std::uint32_t index, const std::string& path,
             std::map<std::string, std::string>& out) {
  const hal::YamlNode& node = tree.at(index);
  const auto plain = [&](std::uint32_t child) { return tree.at(child).children.empty(); };
  switch (node.kind) {
    case hal::YamlNode::Kind::Map:
      for (std::size_t i = 0; i + 1 < node.children.size(); i += 2) {
        const std::string& key = tree.at(node.children[i]).text;
        flatten(tree, node.children[i + 1], path.empty() ? key : path + "." + key, out);
      }
      break;
    case hal::YamlNode::Kind::List:
      if (std::all_of(node.children.begin(), node.children.end(), plain)) {
        std::string all;
        for (const std::uint32_t child : node.children)
          all += (all.empty() ? "" : ", ") + tree.at(child).text;
        out[path] = "[" + all + "]";
        break;
      }
      for (std::size_t i = 0; i < node.children.size(); ++i)
        flatten(tree, node.children[i], fmt::format("{}[{}]", path, i), out);
      break;
    default:
      out[path] = node.text;
  }
}

void read_documents(const telemetry::McapReader& reader, RecordedRun& run) {
  const auto entry = [](const telemetry::Metadata& m, const char* key) {
    const auto found = m.entries.find(key);
    return found == m.entries.end() ? std::string() : found->second;
  };
  if (const auto m = reader.metadata("colift.run")) {
    run.version = entry(*m, "version");
    run.command = entry(*m, "command");
    run.started = entry(*m, "started");
    run.method = entry(*m, "method");
    run.seed = entry(*m, "seed");
  }
  if (const auto m = reader.metadata("colift.result")) {
    run.outcome = entry(*m, "outcome");
    run.reason = entry(*m, "because");
  }
  // one run is not another's equal because it had the same configuration
  for (const auto& [name, prefix] :
       {std::pair{"config.yaml", ""}, {"scenario.yaml", "scenario"}, {"robot.yaml", "robot"}})
    if (const auto file = reader.attachment(name))
      if (const auto tree = hal::parse_yaml(file->data, name)) flatten(*tree, tree->root, prefix, run.config);
}

}  // namespace

const RecordedCandidate* RecordedDecision::candidate(int id) const {
  const auto found = std::find_if(candidates.begin(), candidates.end(),
                                  [&](const RecordedCandidate& c) { return c.id == id; });
  return found == candidates.end() ? nullptr : &*found;
}

std::optional<double> RecordedRun::entered_s(std::string_view state) const {
  for (const RecordedState& s : states)
    if (s.state == state) return s.from_s;
  return std::nullopt;
}

hal::Result<RecordedRun> recorded_run_of(const telemetry::McapReader& reader,
                                         const std::filesystem::path& file) {
  RecordedRun run;
  run.file = file;
  run.damage = reader.info().damage;
  read_documents(reader, run);
  std::map<std::string, Topic> topics;
  for (const Topic topic : {Topic::Change, Topic::Decision, Topic::Load, Topic::Status})
    topics[telemetry::channel_of(topic).topic] = topic;
  std::map<std::uint16_t, Topic> channels;
  std::set<std::string> wanted;
  for (const auto& [id, channel] : reader.info().channels)
    if (const auto topic = topics.find(channel.topic); topic != topics.end()) {
      channels[id] = topic->second;
      wanted.insert(channel.topic);
    }
  auto cursor = reader.messages(wanted);
  while (const auto message = cursor.next()) {
    const auto topic = channels.find(message->channel_id);
    if (topic == channels.end()) continue;
    const Json j = Json::parse(message->data, nullptr, false);
    if (j.is_discarded()) continue;
    const double t_s = 1e-9 * static_cast<double>(message->log_time);
    take(run, topic->second, t_s, j);
    run.end_s = std::max(run.end_s, t_s);
  }
  if (!run.states.empty()) run.states.back().to_s = std::max(run.end_s, run.states.back().from_s);
  if (run.states.empty() && run.curves.empty())
    return hal::failure(hal::ErrorCode::BadInput, file.string(),
                        "holds neither changes of state nor a load; a recording of colift run is expected");
  return run;
}

hal::Result<RecordedRun> read_recorded_run(const std::filesystem::path& file) {
  auto source = telemetry::open_file(file);
  if (!source) return tl::unexpected(source.error());
  const auto reader = telemetry::McapReader::open(std::move(*source), file.string());
  if (!reader) return tl::unexpected(reader.error());
  return recorded_run_of(*reader, file);
}

}  // namespace colift::tools
