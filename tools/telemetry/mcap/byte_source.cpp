#include "tools/telemetry/mcap/byte_source.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace colift::telemetry {
namespace {

class FileSource final : public ByteSource {
 public:
  FileSource(int fd, std::uint64_t size) : fd_(fd), size_(size) {}
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;
  ~FileSource() override { ::close(fd_); }
  [[nodiscard]] std::uint64_t size() const override { return size_; }
  [[nodiscard]] std::string read(std::uint64_t offset, std::uint64_t count) const override {
    if (offset >= size_) return {};
    std::string bytes(static_cast<std::size_t>(std::min(count, size_ - offset)), '\0');
    std::size_t have = 0;
    while (have < bytes.size()) {
      const ssize_t some =
          ::pread(fd_, bytes.data() + have, bytes.size() - have, static_cast<off_t>(offset + have));
      if (some < 0 && errno == EINTR) continue;
      if (some <= 0) break;
      have += static_cast<std::size_t>(some);
    }
    bytes.resize(have);
    return bytes;
  }

 private:
  int fd_;
  std::uint64_t size_;
};

class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::string bytes) : bytes_(std::move(bytes)) {}
  [[nodiscard]] std::uint64_t size() const override { return bytes_.size(); }
  [[nodiscard]] std::string read(std::uint64_t offset, std::uint64_t count) const override {
    if (offset >= bytes_.size()) return {};
    return bytes_.substr(static_cast<std::size_t>(offset),
                         static_cast<std::size_t>(std::min<std::uint64_t>(count, bytes_.size())));
  }

 private:
  std::string bytes_;
};

}  // namespace

hal::Result<std::unique_ptr<ByteSource>> open_file(const std::filesystem::path& file) {
  const auto refused = [&](const std::string& why) {
    return hal::failure(hal::ErrorCode::BadInput, file.string(), why);
  };
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return refused(fmt::format("cannot be read: {}", std::strerror(errno)));
  struct stat found {};
  if (::fstat(fd, &found) != 0 || !S_ISREG(found.st_mode)) {
    ::close(fd);
    return refused("is not a file; expected an MCAP recording");
  }
  return std::make_unique<FileSource>(fd, static_cast<std::uint64_t>(found.st_size));
}

std::unique_ptr<ByteSource> source_of(std::string bytes) {
  return std::make_unique<MemorySource>(std::move(bytes));
}

}  // namespace colift::telemetry
