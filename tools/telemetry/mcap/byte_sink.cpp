#include "tools/telemetry/mcap/byte_sink.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <ctime>

namespace colift::telemetry {
namespace {

/// Keeps the limit of a file's size (ulimit -f) from ending the program, which may move an arm: write() then
/// says EFBIG, as it says ENOSPC for a full disk.
class NoSizeSignal {
 public:
  NoSizeSignal() {
    ::sigemptyset(&signal_);
    ::sigaddset(&signal_, SIGXFSZ);
    ::pthread_sigmask(SIG_BLOCK, &signal_, &before_);
  }
  ~NoSizeSignal() {
    // what waits for this thread is taken before it may come through again
    const timespec at_once{};
    if (::sigismember(&before_, SIGXFSZ) == 0) {
      while (::sigtimedwait(&signal_, nullptr, &at_once) == SIGXFSZ) {
      }
    }
    ::pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoSizeSignal(const NoSizeSignal&) = delete;
  NoSizeSignal& operator=(const NoSizeSignal&) = delete;

 private:
  sigset_t signal_{}, before_{};
};

class FileSink final : public ByteSink {
 public:
  FileSink(int fd, std::string name) : fd_(fd), name_(std::move(name)) {}
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;
  ~FileSink() override { ::close(fd_); }

  hal::Result<> write(std::string_view bytes) override {
    const std::size_t all = bytes.size();
    const NoSizeSignal quiet;
    while (!bytes.empty()) {
      const ssize_t done = ::write(fd_, bytes.data(), bytes.size());
      if (done < 0 && errno == EINTR) continue;
      if (done <= 0) {
        const int reason = done < 0 ? errno : ENOSPC;
        return hal::failure(hal::ErrorCode::BadInput, name_,
                            fmt::format("cannot be written: {} after {} of {} bytes", std::strerror(reason),
                                        all - bytes.size(), all));
      }
      bytes.remove_prefix(static_cast<std::size_t>(done));
    }
    return {};
  }

  hal::Result<> cut_to(std::uint64_t length) override {
    if (::ftruncate(fd_, static_cast<off_t>(length)) != 0 ||
        ::lseek(fd_, static_cast<off_t>(length), SEEK_SET) < 0)
      return failed("cut back");
    return {};
  }

  hal::Result<> flush() override {
    // a pipe has nothing to flush
    if (::fdatasync(fd_) != 0 && errno != EINVAL && errno != EROFS) return failed("flushed");
    return {};
  }

 private:
  [[nodiscard]] tl::unexpected<hal::Error> failed(const char* what) const {
    const int reason = errno;
    return hal::failure(hal::ErrorCode::BadInput, name_,
                        fmt::format("cannot be {}: {}", what, std::strerror(reason)));
  }
  int fd_;
  std::string name_;
};

}  // namespace

hal::Result<std::unique_ptr<ByteSink>> create_file(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) {
    const int reason = errno;
    return hal::failure(hal::ErrorCode::BadInput, file.string(),
                        fmt::format("cannot be written: {}", std::strerror(reason)));
  }
  return std::make_unique<FileSink>(fd, file.string());
}

}  // namespace colift::telemetry
