#include "hal/os/socketcan_bus.hpp"

#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <utility>

#include "hal/os/can_error.hpp"
#include "hal/os/can_link.hpp"

namespace colift::hal {
namespace {

using State = CanHealth::State;

Duration read_clock(clockid_t clock) {
  timespec t{};
  ::clock_gettime(clock, &t);
  return std::chrono::seconds(t.tv_sec) + std::chrono::nanoseconds(t.tv_nsec);
}

class SocketcanBus final : public CanBus {
 public:
  SocketcanBus(std::string interface, std::vector<CanFilter> filters, std::uint32_t bitrate)
      : interface_(std::move(interface)), filters_(std::move(filters)), bitrate_(bitrate) {}
  ~SocketcanBus() override { close(); }
  SocketcanBus(const SocketcanBus&) = delete;
  SocketcanBus& operator=(const SocketcanBus&) = delete;

  Result<> open() override {
    close();
    // index 0, that of a name that does not exist, would listen on every bus of the machine
    const auto link = read_can_link(interface_);
    if (!link) return tl::unexpected(link.error());
    if (auto usable = check_can_link(interface_, *link, bitrate_); !usable) return usable;
    socket_ = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW);
    if (socket_ < 0) return failed("socket");
    if (auto ready = prepare(link->index); !ready) {
      close();
      return ready;
    }
    health_.state = link->state.value_or(State::Active);
    carrier_seen_ = link->running;
    looked_at_carrier_ = read_clock(CLOCK_MONOTONIC);
    overflow_ = 0;
    return {};
  }

  void close() noexcept override {
    if (socket_ >= 0) ::close(socket_);
    socket_ = -1;
    health_.state = State::Closed;
  }

  Received receive(CanFrame& into, Duration timeout) noexcept override {
    if (socket_ < 0) return Received::Down;
    const Timestamp until = read_clock(CLOCK_MONOTONIC) + timeout;
    for (;;) {
      if (const auto got = read_one(into)) return *got;
      const Timestamp now = read_clock(CLOCK_MONOTONIC);
      watch_carrier(now);
      if (health_.state == State::Down) return Received::Down;
      const Duration left = until - now;
      if (left <= Duration::zero()) return Received::Nothing;
      const timespec wait{static_cast<time_t>(left.count() / 1'000'000'000),
                          static_cast<long>(left.count() % 1'000'000'000)};
      pollfd poll{socket_, POLLIN, 0};
      (void)::ppoll(&poll, 1, &wait, nullptr);
    }
  }

  Sent send(const CanFrame& frame) noexcept override {
    if (socket_ < 0) return Sent::Down;
    can_frame raw{};
    raw.can_id = frame.id & CAN_SFF_MASK;
    raw.can_dlc = std::min<std::uint8_t>(frame.length, CAN_MAX_DLEN);
    std::copy_n(frame.data.begin(), raw.can_dlc, raw.data);
    for (int tries = 0; tries < 3; ++tries) {
      if (::write(socket_, &raw, sizeof raw) == sizeof raw) {
        ++health_.sent;
        return Sent::Yes;
      }
      if (errno == EINTR) continue;
      if (errno != ENOBUFS && errno != EAGAIN && errno != EWOULDBLOCK) break;
      ++health_.not_sent;
      return Sent::Full;
    }
    health_.state = State::Down;
    return Sent::Down;
  }

  CanHealth health() const noexcept override { return health_; }

 private:
  Result<> prepare(int index) {
    const auto set = [&](int level, int option, const auto* value, std::size_t size) {
      return ::setsockopt(socket_, level, option, value, static_cast<socklen_t>(size)) == 0;
    };
    std::vector<can_filter> filters;
    for (const CanFilter& f : filters_) filters.push_back({f.id, f.mask | CAN_EFF_FLAG | CAN_RTR_FLAG});
    if (!filters.empty() &&
        !set(SOL_CAN_RAW, CAN_RAW_FILTER, filters.data(), filters.size() * sizeof(can_filter)))
      return failed("filter");
    const can_err_mask_t errors = CAN_ERR_MASK;
    if (!set(SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors)) return failed("error filter");
    const int on = 1, receive_buffer = 1 << 20;
    if (!set(SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on)) return failed("time stamps");
    (void)set(SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);  // without them a loss is not counted, no more
    (void)set(SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = index;
    if (::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
      return failed("bind");
    return {};
  }

  // nullopt: nothing there; frames of no use and error frames are taken in on the way
  std::optional<Received> read_one(CanFrame& into) noexcept {
    for (;;) {
      can_frame raw{};
      alignas(cmsghdr) std::array<char, 256> control{};
      iovec io{&raw, sizeof raw};
      msghdr message{};
      message.msg_iov = &io;
      message.msg_iovlen = 1;
      message.msg_control = control.data();
      message.msg_controllen = control.size();
      const ssize_t n = ::recvmsg(socket_, &message, 0);
      if (n < 0) {
        if (errno == EINTR) continue;
        if (errno == EAGAIN || errno == EWOULDBLOCK) return std::nullopt;
        health_.state = State::Down;  // ENETDOWN: set down, or gone; ENODEV: gone
        return Received::Down;
      }
      if (n != sizeof raw) {
        ++health_.dropped;
        continue;
      }
      const Timestamp arrived = read_control(message);
      if (raw.can_id & CAN_ERR_FLAG) {
        note_can_error(raw.can_id & CAN_ERR_MASK, {raw.data, std::min<std::size_t>(raw.can_dlc, 8)}, health_);
        continue;
      }
      if ((raw.can_id & (CAN_EFF_FLAG | CAN_RTR_FLAG)) || raw.can_dlc > 8) {
        ++health_.dropped;
        continue;
      }
      into = CanFrame{};
      into.id = static_cast<std::uint16_t>(raw.can_id & CAN_SFF_MASK);
      into.length = raw.can_dlc;
      std::copy_n(raw.data, raw.can_dlc, into.data.begin());
      into.arrived_at = arrived;
      ++health_.received;
      return Received::Frame;
    }
  }

  // The kernel stamps with the wall clock. Only the frame's age is taken from it, so that a step of that
  // clock while a frame waits is the worst that can happen, and that is bounded.
  Timestamp read_control(msghdr& message) noexcept {
    const Timestamp now = read_clock(CLOCK_MONOTONIC);
    Timestamp arrived = now;
    for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
      if (c->cmsg_level != SOL_SOCKET) continue;
      if (c->cmsg_type == SO_TIMESTAMPNS) {
        timespec stamp{};
        std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
        const Duration at = std::chrono::seconds(stamp.tv_sec) + std::chrono::nanoseconds(stamp.tv_nsec);
        const Duration age = read_clock(CLOCK_REALTIME) - at;
        arrived = now - std::clamp<Duration>(age, Duration::zero(), std::chrono::seconds(1));
      } else if (c->cmsg_type == SO_RXQ_OVFL) {
        std::uint32_t lost = 0;
        std::memcpy(&lost, CMSG_DATA(c), sizeof lost);
        health_.dropped += lost - overflow_;
        overflow_ = lost;
      }
    }
    return arrived;
  }

  // Bus-off without an error frame, and a lost adapter that nobody writes to, show in the carrier alone.
  void watch_carrier(Timestamp now) noexcept {
    if (now - looked_at_carrier_ < std::chrono::milliseconds(10)) return;
    looked_at_carrier_ = now;
    ifreq request{};
    interface_.copy(request.ifr_name, IFNAMSIZ - 1);
    if (::ioctl(socket_, SIOCGIFFLAGS, &request) != 0 || (request.ifr_flags & IFF_UP) == 0) {
      health_.state = State::Down;
      return;
    }
    const bool carrier = (request.ifr_flags & IFF_RUNNING) != 0;
    if (carrier_seen_ && !carrier && health_.state != State::BusOff) {
      health_.state = State::BusOff;
      ++health_.bus_offs;
    }
    if (!carrier_seen_ && carrier && health_.state == State::BusOff) health_.state = State::Active;
    carrier_seen_ = carrier;
  }

  tl::unexpected<Error> failed(const char* step) const {
    const std::string where = "can " + interface_;
    if (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT)
      return failure(
          ErrorCode::LinkLost, where,
          "this kernel has no SocketCAN: modprobe can-raw, or use a gateway (socketcand:host:port/can0)");
    if (errno == EPERM || errno == EACCES)
      return failure(ErrorCode::LinkLost, where, "no permission to open a CAN socket here");
    return failure(ErrorCode::LinkLost, where, fmt::format("{}: {}", step, std::strerror(errno)));
  }

  std::string interface_;
  std::vector<CanFilter> filters_;
  std::uint32_t bitrate_;
  int socket_ = -1;
  std::uint32_t overflow_ = 0;
  bool carrier_seen_ = false;
  Timestamp looked_at_carrier_{0};
  CanHealth health_;
};

}  // namespace

std::unique_ptr<CanBus> make_socketcan_bus(const std::string& interface,
                                           const std::vector<CanFilter>& filters, std::uint32_t bitrate) {
  return std::make_unique<SocketcanBus>(interface, filters, bitrate);
}

}  // namespace colift::hal
