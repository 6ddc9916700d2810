#include "hal/dds/loopback.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <optional>

namespace colift::hal::dds {
namespace {

// RTPS 2.2, 9.6.1: well-known ports of a domain
constexpr int kPortBase = 7400, kPortsOfDomain = 250;
constexpr char kDevice[] = "lo";

/// The UDP port of a socket that is bound to every address of IPv4.
std::optional<int> wildcard_port(int fd) {
  int type = 0;
  socklen_t size = sizeof type;
  if (::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) return std::nullopt;
  sockaddr_in address{};
  size = sizeof address;
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) != 0 || address.sin_family != AF_INET ||
      address.sin_addr.s_addr != htonl(INADDR_ANY))
    return std::nullopt;
  return ntohs(address.sin_port);
}

}  // namespace

Result<> tie_to_loopback(int domain) {
  constexpr auto kWhere = "ros2.loopback";
  const int first = kPortBase + kPortsOfDomain * domain, end = first + kPortsOfDomain;
  int tied = 0;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const std::string name = entry.path().filename().string();
    int fd = -1;
    std::from_chars(name.data(), name.data() + name.size(), fd);
    const auto port = fd < 0 ? std::nullopt : wildcard_port(fd);
    if (!port || *port < first || *port >= end) continue;
    if (::setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, kDevice, sizeof kDevice) != 0)
      return failure(
          ErrorCode::DeviceFault, kWhere,
          fmt::format("port {} cannot be tied to the loopback device: {}", *port, std::strerror(errno)));
    ++tied;
  }
  if (tied == 0)
    return failure(ErrorCode::DeviceFault, kWhere, "no socket of the domain was found in /proc/self/fd");
  return {};
}

}  // namespace colift::hal::dds
