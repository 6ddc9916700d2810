#include "tools/live/foxglove_wire.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/telemetry/channels/json_parts.hpp"

namespace colift::live {
namespace {

using Json = nlohmann::ordered_json;
using telemetry::dumped;

constexpr char kMessageData = 0x01, kServerTime = 0x02, kServiceCall = 0x02, kServiceResponse = 0x03;

template <class Unsigned>
void append(std::string& bytes, Unsigned value) {
  for (std::size_t i = 0; i < sizeof(value); ++i)
    bytes.push_back(static_cast<char>((value >> (8 * i)) & 0xFF));
}

std::uint32_t read_u32(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + i])) << (8 * i);
  return value;
}

tl::unexpected<hal::Error> bad(std::string detail) {
  return hal::failure(hal::ErrorCode::BadInput, "client", std::move(detail));
}

std::optional<std::uint32_t> id_in(const Json& object, const char* key) {
  const auto found = object.find(key);
  if (found == object.end() || !found->is_number_integer()) return std::nullopt;
  // a signed number below zero and one that is too large are both out of the protocol's 32 bits
  if (found->is_number_unsigned()) {
    const auto value = found->get<std::uint64_t>();
    if (value > 0xFFFFFFFFULL) return std::nullopt;
    return static_cast<std::uint32_t>(value);
  }
  return std::nullopt;
}

hal::Result<const Json*> list_in(const Json& message, const char* key) {
  const auto found = message.find(key);
  if (found == message.end() || !found->is_array()) return bad(fmt::format("expected a list '{}'", key));
  if (found->size() > kMostEntries)
    return bad(fmt::format("'{}' has {} entries (at most {})", key, found->size(), kMostEntries));
  return &*found;
}

}  // namespace

std::optional<std::string> chosen_sub_protocol(std::string_view offered) {
  while (!offered.empty()) {
    const std::size_t comma = std::min(offered.find(','), offered.size());
    std::string_view one = offered.substr(0, comma);
    offered.remove_prefix(std::min(comma + 1, offered.size()));
    while (!one.empty() && (one.front() == ' ' || one.front() == '\t')) one.remove_prefix(1);
    while (!one.empty() && (one.back() == ' ' || one.back() == '\t')) one.remove_suffix(1);
    for (const char* ours : kSubProtocols)
      if (one == ours) return std::string(one);
  }
  return std::nullopt;
}

std::string server_info(const std::string& name, const std::string& session, bool operates) {
  Json j = {{"op", "serverInfo"}, {"name", name}, {"capabilities", {"time"}}};
  if (operates) j["capabilities"].push_back("services");
  j["supportedEncodings"] = {"json"};
  j["metadata"] = {{"program", "colift"}, {"operator", operates ? "yes" : "no"}};
  j["sessionId"] = session;
  return dumped(j);
}

std::string status(StatusLevel level, const std::string& message) {
  return dumped({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

std::string advertise(std::span<const telemetry::ChannelInfo> channels) {
  Json all = Json::array();
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const auto& c = channels[i];
    Json one = {{"id", i}, {"topic", c.topic}, {"encoding", c.encoding}, {"schemaName", c.schema_name}};
    one["schema"] = c.schema;
    if (!c.schema_encoding.empty()) one["schemaEncoding"] = c.schema_encoding;
    all.push_back(std::move(one));
  }
  return dumped({{"op", "advertise"}, {"channels", std::move(all)}});
}

std::string advertise_services(std::span<const OperatorService> services) {
  Json all = Json::array();
  for (const auto& s : services) {
    const Json any = {{"type", "object"}};
    const Json answer = {{"type", "object"},
                         {"description", s.what},
                         {"properties", {{"done", {{"type", "boolean"}}}, {"what", {{"type", "string"}}}}}};
    const auto described = [&](const std::string& suffix, const Json& schema) {
      return Json{{"encoding", "json"},
                  {"schemaName", s.name + suffix},
                  {"schemaEncoding", "jsonschema"},
                  {"schema", schema.dump()}};
    };
    all.push_back({{"id", s.id},
                   {"name", s.name},
                   {"type", "colift.Operator"},
                   {"request", described("_request", any)},
                   {"response", described("_response", answer)}});
  }
  return dumped({{"op", "advertiseServices"}, {"services", std::move(all)}});
}

std::string message_data(std::uint32_t subscription, hal::Timestamp at, std::string_view payload) {
  std::string bytes;
  bytes.reserve(13 + payload.size());
  bytes.push_back(kMessageData);
  append(bytes, subscription);
  append(bytes, static_cast<std::uint64_t>(std::max<std::int64_t>(0, at.count())));
  bytes.append(payload);
  return bytes;
}

std::string server_time(hal::Timestamp at) {
  std::string bytes(1, kServerTime);
  append(bytes, static_cast<std::uint64_t>(std::max<std::int64_t>(0, at.count())));
  return bytes;
}

std::string service_response(std::uint32_t service, std::uint32_t call, std::string_view payload) {
  constexpr std::string_view kEncoding = "json";
  std::string bytes;
  bytes.push_back(kServiceResponse);
  append(bytes, service);
  append(bytes, call);
  append(bytes, static_cast<std::uint32_t>(kEncoding.size()));
  bytes.append(kEncoding);
  bytes.append(payload);
  return bytes;
}

std::string service_failure(std::uint32_t service, std::uint32_t call, const std::string& why) {
  return dumped({{"op", "serviceCallFailure"}, {"serviceId", service}, {"callId", call}, {"message", why}});
}

hal::Result<ClientMessage> parse_text(std::string_view text) {
  const Json message = Json::parse(text, nullptr, false);
  if (message.is_discarded() || !message.is_object()) return bad("a text message has to be a JSON object");
  const auto op = message.find("op");
  if (op == message.end() || !op->is_string()) return bad("a text message needs a text 'op'");
  const std::string name = op->get<std::string>();
  if (name == "subscribe") {
    const auto list = list_in(message, "subscriptions");
    if (!list) return tl::unexpected(list.error());
    Subscribe out;
    for (const Json& entry : **list) {
      const auto id = entry.is_object() ? id_in(entry, "id") : std::nullopt;
      const auto channel = entry.is_object() ? id_in(entry, "channelId") : std::nullopt;
      if (!id || !channel) return bad("a subscription needs the whole numbers 'id' and 'channelId'");
      out.subscriptions.push_back({*id, *channel});
    }
    return ClientMessage(std::move(out));
  }
  if (name == "unsubscribe") {
    const auto list = list_in(message, "subscriptionIds");
    if (!list) return tl::unexpected(list.error());
    Unsubscribe out;
    for (const Json& entry : **list) {
      if (!entry.is_number_unsigned() || entry.get<std::uint64_t>() > 0xFFFFFFFFULL)
        return bad("'subscriptionIds' holds whole numbers of 32 bits");
      out.ids.push_back(entry.get<std::uint32_t>());
    }
    return ClientMessage(std::move(out));
  }
  return bad(
      fmt::format("'{}' is not offered here; this server takes subscribe, unsubscribe and service calls",
                  name.substr(0, 40)));
}

hal::Result<ClientMessage> parse_binary(std::string_view bytes) {
  if (bytes.empty()) return bad("an empty binary message");
  if (bytes[0] != kServiceCall)
    return bad(
        fmt::format("binary message {:#04x} is not offered here", static_cast<unsigned char>(bytes[0])));
  constexpr std::size_t kHead = 13;
  if (bytes.size() < kHead)
    return bad(fmt::format("a service call of {} bytes (at least {})", bytes.size(), kHead));
  const std::uint32_t length = read_u32(bytes, 9);
  if (length > bytes.size() - kHead)
    return bad("the name of the encoding continues past the end of the message");
  if (const auto encoding = bytes.substr(kHead, length); encoding != "json")
    return bad("a service call has to be in JSON");
  return ClientMessage(
      ServiceCall{read_u32(bytes, 1), read_u32(bytes, 5), std::string(bytes.substr(kHead + length))});
}

}  // namespace colift::live
