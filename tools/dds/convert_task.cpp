// State, decision, devices.

#include "tools/dds/convert_parts.hpp"
#include "tools/telemetry/channels/messages.hpp"

namespace colift::ros2 {
namespace {

// diagnostic_msgs/DiagnosticStatus
constexpr std::uint8_t kOk = 0, kWarn = 1, kError = 2, kStale = 3;

std::uint8_t level_of(const std::string& state) {
  if (state == "streaming") return kOk;
  if (state == "opening") return kWarn;
  return state == "stalled" || state == "absent" ? kStale : kError;
}

}  // namespace

bool to_task_status(colift_msgs_msg_dds__TaskStatus_& out, const ChannelMessage& in) {
  const Json j = Json::parse(in.bytes);
  set_header(out.header, in.at + in.to_ros, "");
  set_text(out.state, j.at("state"));
  out.in_state_s = number_of(j.at("in_state_s"));
  set_text(out.because, j.at("because"));
  set_text(out.waits_for, j.at("waits_for"));
  set_text(out.doing, j.at("doing"));
  out.done = number_of(j.at("done"));
  out.speed_scale = number_of(j.at("separation").at("speed_scale"));
  return true;
}

bool to_decision(colift_msgs_msg_dds__Decision_& out, const ChannelMessage& in) {
  const Json j = Json::parse(in.bytes);
  set_header(out.header, in.at + in.to_ros, telemetry::kWorldFrame);
  out.decided = !j.at("chosen").is_null();
  out.chosen = out.decided ? j["chosen"].get<std::int32_t>() : -1;
  out.share = number_of(j.at("share"));
  out.cost = number_of(j.at("cost"));
  set_text(out.because, j.at("because"));
  set_list(out.partner, j.at("partner"));
  set_list(out.cog, j.at("cog"));
  const Json& candidates = j.at("candidates");
  auto* to = hal::dds::resize(out.candidates, candidates.size());
  for (const Json& c : candidates) {
    to->id = c.at("id").get<std::int32_t>();
    set_text(to->kind, c.at("kind"));
    set_list(to->position, c.at("position"));
    set_list(to->approach, c.at("approach"));
    set_list(to->closing, c.at("closing"));
    to->width = number_of(c.at("width"));
    set_text(to->verdict, c.at("verdict"));
    set_text(to->because, c.at("because"));
    to->share = number_of(c.at("share"));
    to->cost = number_of(c.at("cost"));
    ++to;
  }
  return true;
}

bool to_diagnostics(diagnostic_msgs_msg_dds__DiagnosticArray_& out, const ChannelMessage& in) {
  const Json j = Json::parse(in.bytes);
  set_header(out.header, in.at + in.to_ros, "");
  const Json& devices = j.at("devices");
  auto* to = hal::dds::resize(out.status, devices.size());
  for (const Json& d : devices) {
    const auto& state = d.at("state").get_ref<const std::string&>();
    const auto& error = d.at("last_error").get_ref<const std::string&>();
    to->level = level_of(state);
    hal::dds::set(to->name, "colift: " + d.at("name").get_ref<const std::string&>());
    hal::dds::set(to->message, error.empty() ? state : state + ": " + error);
    set_text(to->hardware_id, d.at("name"));
    auto* values = hal::dds::resize(to->values, 2);
    for (const char* key : {"accepted", "rejected"}) {
      hal::dds::set(values->key, key);
      hal::dds::set(values->value, std::to_string(d.at(key).get<std::uint64_t>()));
      ++values;
    }
    ++to;
  }
  return true;
}

}  // namespace colift::ros2
