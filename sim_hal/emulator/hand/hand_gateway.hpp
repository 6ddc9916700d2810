#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <vector>

#include "hal/can_bus.hpp"

namespace colift::sim_hal {

struct HandGatewayConfig {
  std::string address = "127.0.0.1";  ///< IPv4 of the interface to listen on.
  std::uint16_t port = 29536;         ///< 0: any; see port().
  std::string bus = "can0";
};

/// Where a gateway "socketcand:ADDRESS:PORT/BUS" is to listen. Errors: BadInput, with what was expected.
[[nodiscard]] hal::Result<HandGatewayConfig> gateway_config(const std::string& bus);

/// A socketcand gateway with a bus of its own: TCP clients, as many as come, and one node here. What one
/// sends, all others receive. Greetings and answers have no newline, for python-can compares them whole;
/// frames have one. One thread.
class HandGateway final : public hal::CanBus {
 public:
  explicit HandGateway(HandGatewayConfig config) : config_(std::move(config)) {}
  ~HandGateway() override;
  HandGateway(const HandGateway&) = delete;
  HandGateway& operator=(const HandGateway&) = delete;

  /// Begins to listen. Errors: BadConfig (address), LinkLost (port in use).
  [[nodiscard]] hal::Result<> open() override;
  void close() noexcept override;
  [[nodiscard]] Received receive(hal::CanFrame& into, hal::Duration timeout) noexcept override;
  /// To every client; one that does not read loses it.
  [[nodiscard]] Sent send(const hal::CanFrame& frame) noexcept override;
  [[nodiscard]] hal::CanHealth health() const noexcept override { return health_; }

  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] std::size_t clients() const { return clients_.size(); }
  /// An error frame, its class as in linux/can/error.h.
  void tell_error(std::uint32_t error_class) noexcept;
  /// Throws all clients out and takes none until it is up again.
  void set_down(bool down) noexcept;

 private:
  struct Client {
    int socket = -1;
    std::string in, out;
    bool opened = false, raw = false, gone = false;
    hal::Timestamp raw_since{0};
  };

  void look(hal::Duration timeout) noexcept;
  void accept_all();
  void read(Client& client);
  void obey(Client& client, const std::string& inside);
  void say(Client& client, const std::string& text);
  void flush(Client& client);
  void tell_all(const std::string& text, const Client* but);
  void drop_gone();

  HandGatewayConfig config_;
  hal::SteadyClock clock_;
  int listening_ = -1;
  std::uint16_t port_ = 0;
  bool down_ = false;
  std::deque<Client> clients_;
  std::deque<hal::CanFrame> heard_;
  hal::CanHealth health_;
};

}  // namespace colift::sim_hal
