#include "hal/os/udp_link.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

namespace colift::hal {
namespace {

sockaddr_in to_sockaddr(const Endpoint& e) {
  sockaddr_in a{};
  a.sin_family = AF_INET;
  a.sin_addr.s_addr = htonl(e.address);
  a.sin_port = htons(e.port);
  return a;
}

class UdpLink final : public DatagramLink {
 public:
  explicit UdpLink(const Endpoint& local) : local_(local) {}
  ~UdpLink() override { close(); }
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;

  Result<> open() override {
    close();
    socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket_ < 0) return failed("socket");
    const sockaddr_in address = to_sockaddr(local_);
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
      auto error = failed("bind");
      close();
      return error;
    }
    return {};
  }

  void close() noexcept override {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
  }

  Datagram receive(std::span<std::byte> into, Duration timeout) noexcept override {
    Datagram got;
    if (socket_ < 0) {
      got.kind = Datagram::Kind::Broken;
      return got;
    }
    const Timestamp until = clock_.now() + timeout;
    for (;;) {
      sockaddr_in from{};
      socklen_t length = sizeof from;
      const ssize_t n = ::recvfrom(socket_, into.data(), into.size(), MSG_TRUNC,
                                   reinterpret_cast<sockaddr*>(&from), &length);
      got.arrived_at = clock_.now();
      if (n >= 0) {
        got.kind = Datagram::Kind::Data;
        got.size = static_cast<std::size_t>(n);
        got.from = {ntohl(from.sin_addr.s_addr), ntohs(from.sin_port)};
        return got;
      }
      // a peer that is not there yet answers with ICMP: nobody lost anything by that
      if (errno == EINTR || errno == ECONNREFUSED) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) {
        got.kind = Datagram::Kind::Broken;
        return got;
      }
      const Duration left = until - got.arrived_at;
      if (left <= Duration::zero()) return got;
      const timespec wait{static_cast<time_t>(left.count() / 1'000'000'000),
                          static_cast<long>(left.count() % 1'000'000'000)};
      pollfd poll{socket_, POLLIN, 0};
      (void)::ppoll(&poll, 1, &wait, nullptr);
    }
  }

  bool send(const Endpoint& to, std::span<const std::byte> bytes) noexcept override {
    if (socket_ < 0) return false;
    const sockaddr_in address = to_sockaddr(to);
    for (int tries = 0; tries < 3; ++tries) {
      const ssize_t n = ::sendto(socket_, bytes.data(), bytes.size(), 0,
                                 reinterpret_cast<const sockaddr*>(&address), sizeof address);
      if (n == static_cast<ssize_t>(bytes.size())) return true;
      if (n >= 0 || (errno != EINTR && errno != ECONNREFUSED)) return false;
    }
    return false;
  }

 private:
  tl::unexpected<Error> failed(const char* call) const {
    const std::string at = to_string(local_);
    if (errno == EADDRINUSE)
      return failure(ErrorCode::LinkLost, "udp " + at,
                     "the port is in use: another client or a second instance has it");
    if (errno == EADDRNOTAVAIL)
      return failure(ErrorCode::LinkLost, "udp " + at, "this machine has no such address");
    return failure(ErrorCode::LinkLost, "udp " + at, fmt::format("{}: {}", call, std::strerror(errno)));
  }

  Endpoint local_;
  SteadyClock clock_;
  int socket_ = -1;
};

}  // namespace

Result<Endpoint> parse_endpoint(std::string_view text) {
  const auto bad = [&] {
    return failure(ErrorCode::BadConfig, "address",
                   fmt::format("\"{}\" is no address; expected IPV4:PORT, as 127.0.0.1:49938", text));
  };
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return bad();
  Endpoint e;
  const std::string_view port = text.substr(colon + 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), e.port);
  if (error != std::errc{} || end != port.data() + port.size()) return bad();
  if (const std::string host(text.substr(0, colon)); !host.empty()) {
    in_addr address{};
    if (::inet_pton(AF_INET, host.c_str(), &address) != 1) return bad();
    e.address = ntohl(address.s_addr);
  }
  return e;
}

std::string to_string(const Endpoint& e) {
  return fmt::format("{}.{}.{}.{}:{}", e.address >> 24, (e.address >> 16) & 255, (e.address >> 8) & 255,
                     e.address & 255, e.port);
}

std::unique_ptr<DatagramLink> make_udp_link(const Endpoint& local) {
  return std::make_unique<UdpLink>(local);
}

}  // namespace colift::hal
