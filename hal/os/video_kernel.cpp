#include "hal/os/video_kernel.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>

namespace colift::hal {
namespace {

int result_of(int returned) {
  return returned < 0 ? -errno : returned;
}

class VideoKernel final : public VideoCalls {
 public:
  int open(const std::string& path) override {
    return result_of(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
  }
  int close(int descriptor) override { return result_of(::close(descriptor)); }

  int control(int descriptor, unsigned long request, void* argument) override {
    return result_of(::ioctl(descriptor, request, argument));
  }

  int map(int descriptor, std::size_t bytes, std::int64_t offset, const void*& to) override {
    void* const at = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, descriptor, offset);
    if (at == MAP_FAILED) return -errno;
    to = at;
    return 0;
  }
  int unmap(const void* at, std::size_t bytes) override {
    return result_of(::munmap(const_cast<void*>(at), bytes));
  }

  int wait(int descriptor, Duration timeout) override {
    pollfd fd{descriptor, POLLIN, 0};
    const auto left = std::max(timeout, Duration{0});
    const auto whole = std::chrono::duration_cast<std::chrono::seconds>(left);
    const timespec longest{static_cast<std::time_t>(whole.count()),
                           static_cast<long>((left - whole).count())};
    const int ready = ::ppoll(&fd, 1, &longest, nullptr);
    return ready < 0 ? -errno : fd.revents;
  }
};

}  // namespace

std::unique_ptr<VideoCalls> make_video_kernel() {
  return std::make_unique<VideoKernel>();
}

}  // namespace colift::hal
