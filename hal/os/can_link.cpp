#include "hal/os/can_link.hpp"

#include <fmt/format.h>
#include <net/if.h>  // before the kernel's headers, which then leave its names alone

#include <linux/can/netlink.h>
#include <linux/if_arp.h>
#include <linux/rtnetlink.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>

namespace colift::hal {
namespace {

// calls visit(type, payload, length) for each attribute; stops at the first that does not fit
template <class Visit>
void each_attribute(const char* data, std::size_t length, Visit visit) {
  while (length >= sizeof(rtattr)) {
    rtattr head;
    std::memcpy(&head, data, sizeof head);
    if (head.rta_len < sizeof head || head.rta_len > length) return;
    visit(head.rta_type & NLA_TYPE_MASK, data + RTA_LENGTH(0), head.rta_len - RTA_LENGTH(0));
    const std::size_t step = RTA_ALIGN(head.rta_len);
    if (step >= length) return;
    data += step;
    length -= step;
  }
}

template <class T>
std::optional<T> as(const char* data, std::size_t length) {
  if (length < sizeof(T)) return std::nullopt;
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

CanHealth::State state_of(std::uint32_t state) {
  switch (state) {
    case CAN_STATE_ERROR_ACTIVE:
      return CanHealth::State::Active;
    case CAN_STATE_ERROR_WARNING:
      return CanHealth::State::Warning;
    case CAN_STATE_ERROR_PASSIVE:
      return CanHealth::State::Passive;
    case CAN_STATE_BUS_OFF:
      return CanHealth::State::BusOff;
    default:
      return CanHealth::State::Down;
  }
}

void read_can_data(const char* data, std::size_t length, CanLink& link) {
  each_attribute(data, length, [&](int type, const char* at, std::size_t size) {
    if (type == IFLA_CAN_BITTIMING) {
      if (const auto t = as<can_bittiming>(at, size)) {
        link.bitrate = t->bitrate;
        link.sample_point = t->sample_point / 1000.0;
      }
    } else if (type == IFLA_CAN_STATE) {
      if (const auto s = as<std::uint32_t>(at, size)) link.state = state_of(*s);
    } else if (type == IFLA_CAN_RESTART_MS) {
      link.restart_ms = as<std::uint32_t>(at, size);
    } else if (type == IFLA_CAN_BERR_COUNTER) {
      if (const auto c = as<can_berr_counter>(at, size)) {
        link.send_errors = c->txerr;
        link.receive_errors = c->rxerr;
      }
    }
  });
}

void read_link_info(const char* data, std::size_t length, CanLink& link) {
  const char* can = nullptr;
  std::size_t can_length = 0;
  each_attribute(data, length, [&](int type, const char* at, std::size_t size) {
    if (type == IFLA_INFO_KIND) link.kind.assign(at, ::strnlen(at, size));
    if (type == IFLA_INFO_DATA) can = at, can_length = size;
  });
  if (link.kind == "can" && can != nullptr) read_can_data(can, can_length, link);
}

struct Socket {
  int fd = -1;
  Socket() : fd(::socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE)) {}
  ~Socket() {
    if (fd >= 0) ::close(fd);
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
};

}  // namespace

Result<CanLink> read_can_link(const std::string& interface) {
  CanLink link;
  link.index = static_cast<int>(::if_nametoindex(interface.c_str()));
  if (link.index == 0) return link;
  const auto failed = [&](const char* call) {
    return failure(ErrorCode::LinkLost, "can " + interface,
                   fmt::format("netlink {}: {}", call, std::strerror(errno)));
  };
  const Socket netlink;
  if (netlink.fd < 0) return failed("socket");
  const timeval limit{1, 0};
  (void)::setsockopt(netlink.fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  struct {
    nlmsghdr head;
    ifinfomsg what;
  } question{};
  question.head.nlmsg_len = sizeof question;
  question.head.nlmsg_type = RTM_GETLINK;
  question.head.nlmsg_flags = NLM_F_REQUEST;
  question.what.ifi_family = AF_UNSPEC;
  question.what.ifi_index = link.index;
  if (::send(netlink.fd, &question, sizeof question, 0) != sizeof question) return failed("send");
  alignas(nlmsghdr) std::array<char, 16384> answer{};
  const ssize_t n = ::recv(netlink.fd, answer.data(), answer.size(), 0);
  if (n < 0) return failed("receive");
  const auto head = as<nlmsghdr>(answer.data(), static_cast<std::size_t>(n));
  if (!head || head->nlmsg_type != RTM_NEWLINK || head->nlmsg_len > static_cast<std::size_t>(n) ||
      head->nlmsg_len < NLMSG_LENGTH(sizeof(ifinfomsg)))
    return link;  // it went away in between, or says nothing
  const auto about = as<ifinfomsg>(answer.data() + NLMSG_HDRLEN, sizeof(ifinfomsg));
  link.is_can = about->ifi_type == ARPHRD_CAN;
  link.up = (about->ifi_flags & IFF_UP) != 0;
  link.running = (about->ifi_flags & IFF_RUNNING) != 0;
  const std::size_t start = NLMSG_LENGTH(NLMSG_ALIGN(sizeof(ifinfomsg)));
  each_attribute(answer.data() + start, head->nlmsg_len - start,
                 [&](int type, const char* at, std::size_t size) {
                   if (type == IFLA_LINKINFO) read_link_info(at, size, link);
                 });
  return link;
}

Result<> check_can_link(const std::string& interface, const CanLink& link, std::uint32_t bitrate) {
  const std::string where = "can " + interface;
  const std::string set_up = fmt::format(
      "ip link set {} up type can bitrate {} sample-point 0.75 restart-ms 100", interface, bitrate);
  if (link.index == 0)
    return failure(ErrorCode::BadConfig, where,
                   fmt::format("there is no interface {}: is the adapter plugged in and its driver loaded "
                               "(ip -br link show type can)?",
                               interface));
  if (!link.is_can)
    return failure(ErrorCode::BadConfig, where,
                   fmt::format("{} is no CAN interface (ip -br link show type can lists them)", interface));
  if (!link.up) return failure(ErrorCode::LinkLost, where, fmt::format("the interface is down: {}", set_up));
  if (link.bitrate && *link.bitrate != bitrate)
    return failure(ErrorCode::BadConfig, where,
                   fmt::format("the bit rate is {} bit/s, the hand speaks {}: ip link set {} down; {}",
                               *link.bitrate, bitrate, interface, set_up));
  return {};
}

}  // namespace colift::hal
