#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "hal/types/time.hpp"

namespace colift::hal {

/// The system calls on a video device of Linux (V4L2): the seam under a driver and over an emulated device.
/// Each gives what the kernel gives, and -errno in place of -1. One thread, which some of them may block for
/// seconds.
class VideoCalls {
 public:
  virtual ~VideoCalls() = default;

  /// For reading and writing, without waiting; a descriptor.
  [[nodiscard]] virtual int open(const std::string& path) = 0;
  virtual int close(int descriptor) = 0;
  /// ioctl(2) with a request of linux/videodev2.h and its structure.
  [[nodiscard]] virtual int control(int descriptor, unsigned long request, void* argument) = 0;
  /// A buffer of the device as memory, readable; `to` is set when the result is 0.
  [[nodiscard]] virtual int map(int descriptor, std::size_t bytes, std::int64_t offset, const void*& to) = 0;
  virtual int unmap(const void* at, std::size_t bytes) = 0;
  /// Waits until a buffer is filled or the device is gone, no longer than `timeout`: poll(2)'s `revents`, 0
  /// when nothing happened.
  [[nodiscard]] virtual int wait(int descriptor, Duration timeout) = 0;
};

}  // namespace colift::hal
