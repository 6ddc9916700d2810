#include "tools/visualization/file_output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <system_error>

namespace colift::picture {
namespace {

namespace fs = std::filesystem;

struct CloseFile {
  void operator()(std::FILE* f) const { std::fclose(f); }
};

tl::unexpected<hal::Error> refused(const fs::path& file, const std::string& why) {
  return hal::failure(hal::ErrorCode::BadInput, file.string(), "cannot be written: " + why);
}

hal::Result<> write_bytes(const fs::path& to, const fs::path& named, std::span<const std::uint8_t> bytes) {
  std::unique_ptr<std::FILE, CloseFile> out(std::fopen(to.c_str(), "wb"));
  if (!out) return refused(named, std::strerror(errno));
  errno = 0;
  const std::size_t written = std::fwrite(bytes.data(), 1, bytes.size(), out.get());
  const bool flushed = std::fflush(out.get()) == 0;
  const int reason = errno;
  const bool closed = std::fclose(out.release()) == 0;
  if (written != bytes.size() || !flushed || !closed)
    return refused(named, fmt::format("{} after {} of {} bytes", std::strerror(reason ? reason : EIO),
                                      written, bytes.size()));
  return {};
}

}  // namespace

hal::Result<> prepare_output(const fs::path& file) {
  if (file.empty()) return refused(file, "no file name is given");
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (fs::is_directory(status)) return refused(file, "it is a directory");
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, ignored) && !fs::create_directory(folder, ignored))
    return refused(file, fmt::format("the directory '{}' does not exist", folder.string()));
  if (!fs::exists(status) && access(folder.c_str(), W_OK) != 0)
    return refused(file, fmt::format("the directory '{}' allows no new files", folder.string()));
  return {};
}

hal::Result<> write_file(const fs::path& file, std::span<const std::uint8_t> bytes) {
  if (auto ready = prepare_output(file); !ready) return ready;
  std::error_code ignored;
  const fs::file_status status = fs::status(file, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status)) return write_bytes(file, file, bytes);

  // a link keeps pointing where it did, and its target is replaced
  const fs::path real = fs::exists(status) ? fs::canonical(file, ignored) : file;
  fs::path part = real;
  part += ".part";
  if (hal::Result<> done = write_bytes(part, file, bytes); !done) {
    fs::remove(part, ignored);
    return done;
  }
  std::error_code moved;
  fs::rename(part, real, moved);
  if (moved) {
    fs::remove(part, ignored);
    return refused(file, moved.message());
  }
  return {};
}

}  // namespace colift::picture
