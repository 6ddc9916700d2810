#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "hal/types/result.hpp"
#include "hal/types/time.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::live {

// The messages of Foxglove's WebSocket protocol, version 1, as far as CoLift speaks it: server information,
// status, channels, subscriptions, message data, time, and services for the operator. The sub-protocols
// foxglove.websocket.v1 and foxglove.sdk.v1 name the same messages. Pure functions; source:
// https://github.com/foxglove/ws-protocol, docs/spec.md.

inline constexpr const char* kSubProtocols[] = {"foxglove.sdk.v1", "foxglove.websocket.v1"};

/// The first sub-protocol of ours in the client's list (a header value, separated by commas).
[[nodiscard]] std::optional<std::string> chosen_sub_protocol(std::string_view offered);

/// Level of a status message.
enum class StatusLevel { Info = 0, Warning = 1, Error = 2 };

/// What an operator may ask for. `id` is that of the protocol's service.
struct OperatorService {
  std::uint32_t id = 0;
  std::string name;  ///< "/operator/stop"
  std::string what;  ///< Schema description of the answer.
};

[[nodiscard]] std::string server_info(const std::string& name, const std::string& session, bool operates);
[[nodiscard]] std::string status(StatusLevel level, const std::string& message);
/// A channel's id is its topic's place in `channels`.
[[nodiscard]] std::string advertise(std::span<const telemetry::ChannelInfo> channels);
[[nodiscard]] std::string advertise_services(std::span<const OperatorService> services);

/// Binary: 0x01, subscription, nanoseconds, payload; little-endian.
[[nodiscard]] std::string message_data(std::uint32_t subscription, hal::Timestamp at,
                                       std::string_view payload);
/// Binary: 0x02, nanoseconds: what the clock says by which all messages are stamped.
[[nodiscard]] std::string server_time(hal::Timestamp at);
/// Binary: 0x03, service, call, length of "json", "json", payload.
[[nodiscard]] std::string service_response(std::uint32_t service, std::uint32_t call,
                                           std::string_view payload);
[[nodiscard]] std::string service_failure(std::uint32_t service, std::uint32_t call, const std::string& why);

struct Subscription {
  std::uint32_t id = 0;       ///< The client's choice.
  std::uint32_t channel = 0;  ///< As advertised.
};
struct Subscribe {
  std::vector<Subscription> subscriptions;
};
struct Unsubscribe {
  std::vector<std::uint32_t> ids;
};
struct ServiceCall {
  std::uint32_t service = 0, call = 0;
  std::string payload;
};
using ClientMessage = std::variant<Subscribe, Unsubscribe, ServiceCall>;

/// Most entries of one list in a client's message.
inline constexpr std::size_t kMostEntries = 256;

/// A message of a client; nothing of it is trusted. Errors: BadInput with what was found.
[[nodiscard]] hal::Result<ClientMessage> parse_text(std::string_view text);
[[nodiscard]] hal::Result<ClientMessage> parse_binary(std::string_view bytes);

}  // namespace colift::live
