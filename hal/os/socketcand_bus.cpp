#include "hal/os/socketcand_bus.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "hal/os/can_error.hpp"
#include "hal/os/socketcand_text.hpp"

namespace colift::hal {
namespace {

using State = CanHealth::State;
using Kind = GatewayMessage::Kind;

constexpr Duration kTimeout = std::chrono::seconds(2);

bool wait_for(int socket, short events, Duration timeout) {
  const timespec wait{static_cast<time_t>(timeout.count() / 1'000'000'000),
                      static_cast<long>(timeout.count() % 1'000'000'000)};
  pollfd poll{socket, events, 0};
  return ::ppoll(&poll, 1, &wait, nullptr) > 0;
}

std::string printable(std::string_view words) {
  std::string text(words);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c < ' ' || c > '~'; }, '?');
  return text;
}

class SocketcandBus final : public CanBus {
 public:
  SocketcandBus(std::string host, std::uint16_t port, std::string bus, std::vector<CanFilter> filters)
      : host_(std::move(host)), bus_(std::move(bus)), port_(port), filters_(std::move(filters)) {}
  ~SocketcandBus() override { close(); }
  SocketcandBus(const SocketcandBus&) = delete;
  SocketcandBus& operator=(const SocketcandBus&) = delete;

  Result<> open() override {
    close();
    deadline_ = clock_.now() + kTimeout;
    auto done = connect();
    if (done) done = shake_hands();
    if (!done) {
      close();
      return done;
    }
    health_.state = State::Active;
    return {};
  }

  void close() noexcept override {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
    parser_.clear();
    unsent_ = {};
    health_.state = State::Closed;
  }

  Received receive(CanFrame& into, Duration timeout) noexcept override {
    if (socket_ < 0) return Received::Down;
    const Timestamp until = clock_.now() + timeout;
    for (;;) {
      if (take(into)) return Received::Frame;
      (void)flush();
      const Read got = read_some();
      if (got == Read::Gone) return Received::Down;
      if (got == Read::Some) continue;
      const Duration left = until - clock_.now();
      if (left <= Duration::zero()) return Received::Nothing;
      (void)wait_for(socket_, POLLIN, left);
    }
  }

  Sent send(const CanFrame& frame) noexcept override {
    if (socket_ < 0) return Sent::Down;
    if (const Sent before = flush(); before != Sent::Yes) {
      if (before == Sent::Full) ++health_.not_sent;
      return before;
    }
    const std::string_view text = write_gateway_send(frame, text_);
    const ssize_t n = write_some(text);
    if (n < 0) return gone();
    if (n == 0) {
      ++health_.not_sent;
      return Sent::Full;
    }
    // what TCP took a part of is on its way: the rest follows before anything else
    unsent_ = text.substr(static_cast<std::size_t>(n));
    ++health_.sent;
    return Sent::Yes;
  }

  CanHealth health() const noexcept override {
    CanHealth health = health_;
    health.reports_errors = health.error_frames > 0;
    return health;
  }

 private:
  enum class Read { Some, Nothing, Gone };

  [[nodiscard]] std::string where() const { return fmt::format("socketcand {}:{}/{}", host_, port_, bus_); }
  [[nodiscard]] tl::unexpected<Error> lost(std::string why) const {
    return failure(ErrorCode::LinkLost, where(), std::move(why));
  }
  [[nodiscard]] Duration left() const { return std::max(deadline_ - clock_.now(), Duration::zero()); }

  Result<> connect() {
    addrinfo hints{};
    hints.ai_socktype = SOCK_STREAM;
    hints.ai_flags = AI_NUMERICSERV;
    addrinfo* found = nullptr;
    const int error = ::getaddrinfo(host_.c_str(), fmt::format("{}", port_).c_str(), &hints, &found);
    if (error != 0) return lost(fmt::format("no address for \"{}\": {}", host_, ::gai_strerror(error)));
    deadline_ = clock_.now() + kTimeout;
    int why = 0;
    for (const addrinfo* a = found; a != nullptr && socket_ < 0; a = a->ai_next) why = try_address(*a);
    ::freeaddrinfo(found);
    if (socket_ < 0)
      return lost(why == ECONNREFUSED
                      ? fmt::format("nobody listens there: start socketcand (socketcand -v -p {} -i {} -l "
                                    "INTERFACE -e 1FFFFFFF; without -e it reports no "
                                    "error frames)",
                                    port_, bus_)
                      : fmt::format("no connection: {}", std::strerror(why)));
    const int on = 1;
    (void)::setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return {};
  }

  // 0 with socket_ open, or why not
  int try_address(const addrinfo& a) {
    const int fd = ::socket(a.ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) return errno;
    int error = ::connect(fd, a.ai_addr, a.ai_addrlen) == 0 ? 0 : errno;
    if (error == EINPROGRESS) {
      error = ETIMEDOUT;
      socklen_t size = sizeof error;
      if (wait_for(fd, POLLOUT, left()) && ::getsockopt(fd, SOL_SOCKET, SO_ERROR, &error, &size) != 0)
        error = errno;
    }
    if (error == 0) {
      socket_ = fd;
    } else {
      ::close(fd);
    }
    return error;
  }

  Result<> shake_hands() {
    if (auto hi = expect(Kind::Hi, "greeting"); !hi) return hi;
    if (auto said = say(fmt::format("< open {} >", bus_)); !said) return said;
    if (auto ok = expect(Kind::Ok, "answer to open"); !ok) return ok;
    if (auto said = say("< rawmode >"); !said) return said;
    return expect(Kind::Ok, "answer to rawmode");
  }

  Result<> say(std::string_view text) {
    while (!text.empty()) {
      const ssize_t n = write_some(text);
      if (n < 0)
        return lost(fmt::format("the connection broke while shaking hands: {}", std::strerror(errno)));
      text.remove_prefix(static_cast<std::size_t>(n));
      if (text.empty()) break;
      if (left() == Duration::zero()) return lost("the gateway takes no commands within 2 s");
      (void)wait_for(socket_, POLLOUT, left());
    }
    return {};
  }

  Result<> expect(Kind kind, std::string_view what) {
    for (;;) {
      const GatewayMessage message = parser_.next();
      if (message.kind == kind) return {};
      if (message.kind == Kind::Refused)
        return failure(
            ErrorCode::BadConfig, where(),
            fmt::format("the gateway says \"{}\" instead of its {}", printable(message.words), what));
      if (message.kind == Kind::Broken)
        return failure(ErrorCode::BadConfig, where(), fmt::format("what came as {} is not socketcand", what));
      if (message.kind != Kind::None) continue;  // frames may come before the answer
      if (left() == Duration::zero()) return lost(fmt::format("no {} within 2 s", what));
      (void)wait_for(socket_, POLLIN, left());
      if (read_some() == Read::Gone)
        return lost(fmt::format("the gateway closed the connection before its {}", what));
    }
  }

  bool take(CanFrame& into) noexcept {
    for (;;) {
      const GatewayMessage message = parser_.next();
      switch (message.kind) {
        case Kind::None:
          return false;
        case Kind::Frame:
          if (!passes(message.frame.id)) break;
          into = message.frame;
          into.arrived_at = read_at_;
          ++health_.received;
          return true;
        case Kind::Error:
          note_can_error(message.error_class, {}, health_);
          break;
        case Kind::Hi:
        case Kind::Ok:
          break;
        case Kind::Refused:
        case Kind::Other:
        case Kind::Broken:
          ++health_.dropped;
          break;
      }
    }
  }

  [[nodiscard]] bool passes(std::uint16_t id) const {
    return filters_.empty() || std::any_of(filters_.begin(), filters_.end(),
                                           [&](const CanFilter& f) { return (id & f.mask) == f.id; });
  }

  Read read_some() noexcept {
    const std::span<char> room = parser_.room();
    for (;;) {
      const ssize_t n = ::recv(socket_, room.data(), room.size(), 0);
      if (n > 0) {
        read_at_ = clock_.now();
        parser_.filled(static_cast<std::size_t>(n));
        return Read::Some;
      }
      if (n < 0 && errno == EINTR) continue;
      if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK)) return Read::Nothing;
      (void)gone();
      return Read::Gone;
    }
  }

  // bytes that were taken, 0 when the buffer is full, -1 when the connection is gone
  ssize_t write_some(std::string_view text) noexcept {
    for (;;) {
      const ssize_t n = ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
      if (n >= 0) return n;
      if (errno == EINTR) continue;
      return errno == EAGAIN || errno == EWOULDBLOCK ? 0 : -1;
    }
  }

  Sent flush() noexcept {
    if (unsent_.empty()) return Sent::Yes;
    const ssize_t n = write_some(unsent_);
    if (n < 0) return gone();
    unsent_.remove_prefix(static_cast<std::size_t>(n));
    return unsent_.empty() ? Sent::Yes : Sent::Full;
  }

  Sent gone() noexcept {
    health_.state = State::Down;
    return Sent::Down;
  }

  std::string host_, bus_;
  std::uint16_t port_;
  std::vector<CanFilter> filters_;
  SteadyClock clock_;
  int socket_ = -1;
  Timestamp deadline_{0}, read_at_{0};
  GatewayParser parser_;
  std::array<char, 64> text_{};
  std::string_view unsent_;  ///< Into text_.
  CanHealth health_;
};

}  // namespace

std::unique_ptr<CanBus> make_socketcand_bus(const std::string& host, std::uint16_t port,
                                            const std::string& bus, const std::vector<CanFilter>& filters) {
  return std::make_unique<SocketcandBus>(host, port, bus, filters);
}

}  // namespace colift::hal
