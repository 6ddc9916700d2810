#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "hal/types/result.hpp"
#include "tools/live/page_files.hpp"
#include "tools/live/visitor.hpp"
#include "tools/telemetry/channels/channels.hpp"

namespace colift::live {

struct ServerConfig {
  std::string address = "127.0.0.1";
  std::uint16_t port = 8765;        ///< 0: any free one. 8765 is what Foxglove proposes.
  std::size_t most_clients = 32;    ///< Of the channels.
  std::size_t operator_places = 4;  ///< Further ones, for who has the token.
  std::size_t most_callers = 32;    ///< Connections that speak HTTP; the oldest makes room for the next.
  std::size_t largest_message = 64 * 1024;  ///< Of a client (bytes).
  double messages_per_second = 50.0;        ///< Of a client; more ends its connection.
  DoorRules door;
  std::string name = "CoLift";
  /// What an operator's client may ask for; called from the server's thread.
  std::function<void()> on_stop, on_lower, on_continue;
};

struct ServerCounts {
  std::uint64_t clients = 0, clients_ever = 0, turned_away = 0, published = 0, dropped = 0, sent = 0;
};

/// Page and channels on one port: HTTP for the page's files, WebSocket with Foxglove's protocol for the
/// channels. One thread of its own does all of it; publish() hands over and never waits for a client.
class LiveServer final : public telemetry::TelemetrySink {
 public:
  /// Listens at once. Errors: NotReady with the address and what the system says.
  [[nodiscard]] static hal::Result<std::unique_ptr<LiveServer>> open(const ServerConfig& config,
                                                                     PageFiles files);
  ~LiveServer() override;

  [[nodiscard]] std::uint16_t port() const;
  /// "http://127.0.0.1:8765/"; with the token where there is one.
  [[nodiscard]] std::string url() const;
  /// Any thread. What comes faster than the server's thread takes it is dropped, oldest first, and counted.
  void publish(const telemetry::Publication& publication) override;
  [[nodiscard]] ServerCounts counts() const;

 private:
  struct Impl;
  explicit LiveServer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::live
