#include "sim_hal/emulator/camera/client/camera_socket.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdlib>
#include <cstring>

namespace colift::sim_hal {
namespace {

constexpr int kHello_ms = 1000;

}  // namespace

bool CameraSocket::open() {
  if (fd_ >= 0) return true;
  const char* name = std::getenv(kCameraWireVariable);
  if (name == nullptr || *name == '\0') return false;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::size_t length = std::min(std::strlen(name), sizeof address.sun_path - 1);
  std::memcpy(address.sun_path, name, length);
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';  // a name that is no file
  const auto bytes = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + length);
  fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd_ < 0) return false;
  CameraHead head;
  std::vector<std::uint8_t> body;
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), bytes) == 0 &&
      receive(kHello_ms, head, body) == Got::Message && head.what == CameraMessage::Hello &&
      body.size() == sizeof hello_) {
    std::memcpy(&hello_, body.data(), sizeof hello_);
    hello_.serial[sizeof hello_.serial - 1] = '\0';
    return true;
  }
  close();
  return false;
}

void CameraSocket::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  partial_.clear();
}

CameraSocket::Got CameraSocket::receive(int timeout_ms, CameraHead& head, std::vector<std::uint8_t>& bytes) {
  if (fd_ < 0) return Got::Gone;
  for (;;) {
    std::size_t wanted = sizeof head;
    if (partial_.size() >= sizeof head) {
      std::memcpy(&head, partial_.data(), sizeof head);
      if (head.magic != kCameraWireMagic || head.bytes > kCameraWireMost) return Got::Gone;
      wanted += head.bytes;
      if (partial_.size() == wanted) {
        bytes.assign(partial_.begin() + sizeof head, partial_.end());
        partial_.clear();
        return Got::Message;
      }
    }
    pollfd p{fd_, POLLIN, 0};
    const int ready = ::poll(&p, 1, timeout_ms);
    if (ready == 0) return Got::Nothing;
    if (ready < 0) return errno == EINTR ? Got::Nothing : Got::Gone;
    const std::size_t have = partial_.size();
    partial_.resize(wanted);
    const ssize_t n = ::recv(fd_, partial_.data() + have, wanted - have, 0);
    partial_.resize(have + static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
    if (n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN)) return Got::Gone;
  }
}

void CameraSocket::send(CameraMessage what, std::uint32_t value) {
  CameraHead head;
  head.what = what;
  head.value = value;
  if (fd_ >= 0) (void)!::send(fd_, &head, sizeof head, MSG_NOSIGNAL | MSG_DONTWAIT);
}

}  // namespace colift::sim_hal
