#include "sim_hal/emulator/hand/hand_gateway.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <sstream>

namespace colift::sim_hal {
namespace {

constexpr std::size_t kLongest = 200;       // of a command
constexpr std::size_t kMostUnread = 65536;  // that a client leaves lying
constexpr std::size_t kMostClients = 16;
// python-can reads the answer to rawmode whole: nothing may follow in the same segment
constexpr hal::Duration kAfterRawMode = std::chrono::milliseconds(20);

std::optional<std::uint32_t> hex(const std::string& word) {
  std::uint32_t v = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), v, 16);
  if (word.empty() || error != std::errc{} || end != word.data() + word.size()) return std::nullopt;
  return v;
}

// "send ID LENGTH BYTES ...", all of them hexadecimal
std::optional<hal::CanFrame> read_send(std::istringstream& words) {
  std::string id_word, length_word, byte_word;
  words >> id_word >> length_word;
  const auto id = hex(id_word), length = hex(length_word);
  if (!id || id_word.size() > 3 || *id > 0x7ff || !length || *length > 8) return std::nullopt;
  hal::CanFrame f;
  f.id = static_cast<std::uint16_t>(*id);
  while (words >> byte_word) {
    const auto byte = hex(byte_word);
    if (!byte || *byte > 255 || f.length >= *length) return std::nullopt;
    f.data[f.length++] = static_cast<std::uint8_t>(*byte);
  }
  if (f.length != *length) return std::nullopt;
  return f;
}

std::string frame_text(const hal::CanFrame& frame, hal::Timestamp at) {
  std::string text = fmt::format("< frame {:03X} {}.{:06} ", frame.id, at.count() / 1'000'000'000,
                                 at.count() / 1000 % 1'000'000);
  for (std::size_t i = 0; i < frame.length; ++i) text += fmt::format("{:02X}", frame.data[i]);
  return text + " >\n";
}

}  // namespace

hal::Result<HandGatewayConfig> gateway_config(const std::string& bus) {
  constexpr std::string_view kKind = "socketcand:";
  const std::string_view text =
      bus.starts_with(kKind) ? std::string_view(bus).substr(kKind.size()) : std::string_view();
  const auto refuse = [&] {
    return hal::failure(
        hal::ErrorCode::BadInput, "bus",
        fmt::format("\"{}\" is no bus; expected socketcand:IPV4:PORT/NAME or socketcan:IF", bus));
  };
  const std::size_t colon = text.find(':'), slash = text.find('/');
  if (colon == std::string_view::npos || slash == std::string_view::npos || slash < colon) return refuse();
  HandGatewayConfig config;
  config.address = std::string(text.substr(0, colon));
  config.bus = std::string(text.substr(slash + 1));
  const std::string_view port = text.substr(colon + 1, slash - colon - 1);
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), config.port);
  if (error != std::errc{} || end != port.data() + port.size() || config.bus.empty()) return refuse();
  return config;
}

HandGateway::~HandGateway() {
  close();
}

hal::Result<> HandGateway::open() {
  close();
  const auto lost = [&](hal::ErrorCode code, const char* what) {
    const int why = errno;
    close();
    return hal::failure(code, fmt::format("gateway {}:{}", config_.address, config_.port),
                        fmt::format("{}: {}", what, std::strerror(why)));
  };
  sockaddr_in at{};
  at.sin_family = AF_INET;
  // a gateway that was down comes back where it was
  at.sin_port = htons(port_ != 0 ? port_ : config_.port);
  errno = EINVAL;
  if (::inet_pton(AF_INET, config_.address.c_str(), &at.sin_addr) != 1)
    return lost(hal::ErrorCode::BadConfig, "not an IPv4 address");
  listening_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listening_ < 0) return lost(hal::ErrorCode::LinkLost, "no socket");
  const int on = 1;
  (void)::setsockopt(listening_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  if (::bind(listening_, reinterpret_cast<const sockaddr*>(&at), sizeof at) != 0 ||
      ::listen(listening_, static_cast<int>(kMostClients)) != 0)
    return lost(hal::ErrorCode::LinkLost, "cannot listen there");
  socklen_t size = sizeof at;
  if (::getsockname(listening_, reinterpret_cast<sockaddr*>(&at), &size) == 0) port_ = ntohs(at.sin_port);
  down_ = false;
  health_.state = hal::CanHealth::State::Active;
  return {};
}

void HandGateway::close() noexcept {
  for (const Client& c : clients_) ::close(c.socket);
  clients_.clear();
  heard_.clear();
  if (listening_ >= 0) ::close(listening_);
  listening_ = -1;
  health_.state = hal::CanHealth::State::Closed;
}

void HandGateway::set_down(bool down) noexcept {
  if (down == down_) return;
  if (down) {
    close();
    health_.state = hal::CanHealth::State::Down;
    down_ = true;
  } else {
    (void)open();
  }
}

hal::CanBus::Received HandGateway::receive(hal::CanFrame& into, hal::Duration timeout) noexcept {
  if (listening_ < 0) return Received::Down;
  if (heard_.empty()) look(timeout);
  if (heard_.empty()) return Received::Nothing;
  into = heard_.front();
  heard_.pop_front();
  ++health_.received;
  return Received::Frame;
}

hal::CanBus::Sent HandGateway::send(const hal::CanFrame& frame) noexcept {
  if (listening_ < 0) return Sent::Down;
  ++health_.sent;
  tell_all(frame_text(frame, clock_.now()), nullptr);
  return Sent::Yes;
}

void HandGateway::tell_error(std::uint32_t error_class) noexcept {
  const hal::Timestamp at = clock_.now();
  tell_all(fmt::format("< error {:08X} {}.{:06} >\n", error_class, at.count() / 1'000'000'000,
                       at.count() / 1000 % 1'000'000),
           nullptr);
}

void HandGateway::look(hal::Duration timeout) noexcept {
  std::vector<pollfd> polls{{listening_, POLLIN, 0}};
  for (const Client& c : clients_)
    polls.push_back({c.socket, static_cast<short>(c.out.empty() ? POLLIN : POLLIN | POLLOUT), 0});
  timeout = std::max(timeout, hal::Duration::zero());
  const timespec wait{static_cast<time_t>(timeout.count() / 1'000'000'000),
                      static_cast<long>(timeout.count() % 1'000'000'000)};
  if (::ppoll(polls.data(), polls.size(), &wait, nullptr) <= 0) return;
  for (std::size_t i = 1; i < polls.size(); ++i) {
    Client& c = clients_[i - 1];
    if ((polls[i].revents & POLLOUT) != 0) flush(c);
    if ((polls[i].revents & ~POLLOUT) != 0) read(c);
  }
  if ((polls[0].revents & POLLIN) != 0) accept_all();
  drop_gone();
}

void HandGateway::accept_all() {
  for (;;) {
    const int fd = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    if (clients_.size() >= kMostClients) {
      ::close(fd);
      continue;
    }
    const int on = 1;
    (void)::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    clients_.emplace_back();
    clients_.back().socket = fd;
    say(clients_.back(), "< hi >");
  }
}

void HandGateway::read(Client& c) {
  std::array<char, 4096> buffer;
  const ssize_t n = ::recv(c.socket, buffer.data(), buffer.size(), 0);
  if (n < 0 && (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)) return;
  if (n <= 0) {
    c.gone = true;
    return;
  }
  c.in.append(buffer.data(), static_cast<std::size_t>(n));
  for (;;) {
    const std::size_t begin = c.in.find('<');
    c.in.erase(0, begin == std::string::npos ? c.in.size() : begin);
    const std::size_t end = c.in.find('>');
    if (end == std::string::npos) break;
    const std::string inside = c.in.substr(1, end - 1);
    c.in.erase(0, end + 1);
    obey(c, inside);
    if (c.gone) return;
  }
  if (c.in.size() > kLongest) {
    ++health_.dropped;
    c.in.clear();
  }
}

void HandGateway::obey(Client& c, const std::string& inside) {
  std::istringstream words(inside);
  std::string command;
  words >> command;
  if (command == "open" && !c.opened) {
    std::string bus;
    words >> bus;
    if (bus == config_.bus) {
      c.opened = true;
      say(c, "< ok >");
    } else {
      say(c, "< error could not open bus >");
      flush(c);
      c.gone = true;
    }
  } else if (command == "rawmode" && c.opened) {
    say(c, "< ok >");
    c.raw = true;
    c.raw_since = clock_.now();
  } else if (command == "echo") {
    say(c, "< echo >");
  } else if (command == "send" && c.opened) {
    c.raw_since = hal::Timestamp(0);  // it has read the answer to rawmode: no reply of a puck may get lost
    if (const auto frame = read_send(words)) {
      heard_.push_back(*frame);
      heard_.back().arrived_at = clock_.now();
      tell_all(frame_text(*frame, clock_.now()), &c);
    } else {
      ++health_.dropped;
      say(c, "< error syntax error in send command >");
    }
  } else {
    ++health_.dropped;
    say(c, "< error unknown command >");
  }
}

void HandGateway::say(Client& c, const std::string& text) {
  if (c.out.size() + text.size() > kMostUnread) {
    ++health_.not_sent;
    return;
  }
  c.out += text;
  flush(c);
}

void HandGateway::flush(Client& c) {
  while (!c.out.empty()) {
    const ssize_t n = ::send(c.socket, c.out.data(), c.out.size(), MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      c.gone = c.gone || (errno != EAGAIN && errno != EWOULDBLOCK);
      return;
    }
    c.out.erase(0, static_cast<std::size_t>(n));
  }
}

void HandGateway::tell_all(const std::string& text, const Client* but) {
  const hal::Timestamp now = clock_.now();
  for (Client& c : clients_)
    if (c.raw && !c.gone && &c != but && now >= c.raw_since + kAfterRawMode) say(c, text);
}

void HandGateway::drop_gone() {
  std::erase_if(clients_, [](const Client& c) {
    if (c.gone) ::close(c.socket);
    return c.gone;
  });
}

}  // namespace colift::sim_hal
