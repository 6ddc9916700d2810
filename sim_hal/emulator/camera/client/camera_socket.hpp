#pragma once

#include <cstdint>
#include <vector>

#include "sim_hal/emulator/camera/camera_wire.hpp"

namespace colift::sim_hal {

/// The library's end of the wire. Standard library and system calls only: it is loaded into other programs.
class CameraSocket {
 public:
  /// Connects to what the environment names, and hears whether there is a device. False: none.
  [[nodiscard]] bool open();
  void close();
  [[nodiscard]] bool is_open() const { return fd_ >= 0; }
  [[nodiscard]] const CameraHello& hello() const { return hello_; }

  enum class Got { Nothing, Message, Gone };
  /// Waits for a whole message, no longer than that.
  [[nodiscard]] Got receive(int timeout_ms, CameraHead& head, std::vector<std::uint8_t>& bytes);
  void send(CameraMessage what, std::uint32_t value);

  CameraSocket() = default;
  CameraSocket(const CameraSocket&) = delete;
  CameraSocket& operator=(const CameraSocket&) = delete;
  ~CameraSocket() { close(); }

 private:
  int fd_ = -1;
  CameraHello hello_;
  std::vector<std::uint8_t> partial_;
};

}  // namespace colift::sim_hal
