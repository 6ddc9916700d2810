#include "tools/telemetry/record/flight_request.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <utility>

namespace colift::telemetry {
namespace {

namespace fs = std::filesystem;

fs::path runtime_folder() {
  const char* given = std::getenv("XDG_RUNTIME_DIR");
  if (given && *given) return fs::path(given) / "colift";
  return fs::path("/tmp") / fmt::format("colift-{}", ::getuid());
}

hal::Result<fs::path> own_folder() {
  const fs::path folder = runtime_folder();
  (void)::mkdir(folder.c_str(), 0700);
  struct stat found {};
  if (::lstat(folder.c_str(), &found) != 0 || !S_ISDIR(found.st_mode) || found.st_uid != ::getuid() ||
      (found.st_mode & 022) != 0)
    return hal::failure(hal::ErrorCode::NotReady, folder.string(),
                        "is no folder that only this user can write; snapshots cannot be asked for");
  return folder;
}

fs::path announcement(const fs::path& folder, pid_t pid) {
  return folder / fmt::format("run-{}", pid);
}
fs::path request(const fs::path& folder, pid_t pid) {
  return folder / fmt::format("request-{}", pid);
}

// a run locks its announcement for its life: the number of a process that was killed may be another's today
bool announced(const fs::path& announcement) {
  const int fd = ::open(announcement.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool locked = ::flock(fd, LOCK_SH | LOCK_NB) != 0;
  ::close(fd);
  return locked;
}

/// Descriptor of the locked file; -1: it cannot be written.
int announce(const fs::path& announcement) {
  for (;;) {
    const int fd = ::open(announcement.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
    if (fd < 0 || ::flock(fd, LOCK_EX) != 0) return fd;
    // somebody who looked just before it was locked has removed it
    struct stat own {
    }, there{};
    if (::fstat(fd, &own) == 0 && ::stat(announcement.c_str(), &there) == 0 && own.st_ino == there.st_ino)
      return fd;
    ::close(fd);
  }
}

std::optional<pid_t> newest_run(const fs::path& folder) {
  std::optional<pid_t> best;
  fs::file_time_type best_time{};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("run-")) continue;
    const auto pid = static_cast<pid_t>(std::strtol(name.c_str() + 4, nullptr, 10));
    if (!announced(entry.path())) {
      fs::remove(entry.path(), error);  // left behind by a run that was killed
      continue;
    }
    const auto time = entry.last_write_time(error);
    if (best && time < best_time) continue;
    best = pid;
    best_time = time;
  }
  return best;
}

}  // namespace

FlightPost::FlightPost(fs::path folder)
    : announcement_(announcement(folder, ::getpid())), request_(request(folder, ::getpid())) {}

FlightPost::FlightPost(FlightPost&& other) noexcept
    : announcement_(std::move(other.announcement_)),
      request_(std::move(other.request_)),
      lock_(std::exchange(other.lock_, -1)),
      answering_(other.answering_) {
  other.announcement_.clear();
}

hal::Result<FlightPost> FlightPost::open() {
  const auto folder = own_folder();
  if (!folder) return tl::unexpected(folder.error());
  (void)newest_run(*folder);  // removes what killed runs have left behind
  FlightPost post(*folder);
  std::error_code ignored;
  fs::remove(post.request_, ignored);
  post.lock_ = announce(post.announcement_);
  if (post.lock_ < 0)
    return hal::failure(hal::ErrorCode::NotReady, post.announcement_.string(),
                        "cannot be written; snapshots cannot be asked for");
  return post;
}

FlightPost::~FlightPost() {
  if (announcement_.empty()) return;
  std::error_code ignored;
  fs::remove(announcement_, ignored);
  fs::remove(request_, ignored);
  if (lock_ >= 0) ::close(lock_);
}

std::optional<fs::path> FlightPost::asked() {
  std::error_code ignored;
  if (answering_) {
    answering_ = false;
    fs::remove(request_, ignored);
    return std::nullopt;
  }
  std::ifstream in(request_);
  if (!in) return std::nullopt;
  std::string file;
  std::getline(in, file);
  answering_ = true;
  if (file.empty() || file[0] != '/') return std::nullopt;
  return fs::path(file);
}

hal::Result<> ask_for_flight(const fs::path& file, std::optional<pid_t> run, double timeout_s) {
  const auto folder = own_folder();
  if (!folder) return tl::unexpected(folder.error());
  if (!run) run = newest_run(*folder);
  if (!run || !announced(announcement(*folder, *run)))
    return hal::failure(
        hal::ErrorCode::NotFound, "snapshot",
        run ? fmt::format("process {} is no run that records; start it with --record or --flight", *run)
            : "no run of this user records; start one with --record or --flight");
  std::error_code error;
  const fs::path target = fs::absolute(file, error);
  const auto before = fs::last_write_time(target, error);
  const bool was_there = !error;
  const fs::path asking = request(*folder, *run), part = asking.string() + ".part";
  std::ofstream(part) << target.string() << '\n';
  fs::rename(part, asking, error);
  if (error) return hal::failure(hal::ErrorCode::NotReady, asking.string(), error.message());

  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(timeout_s);
  while (fs::exists(asking, error)) {
    if (Clock::now() > end) {
      fs::remove(asking, error);
      return hal::failure(hal::ErrorCode::Timeout, "snapshot",
                          fmt::format("process {} did not answer within {:.0f} s", *run, timeout_s));
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const auto after = fs::last_write_time(target, error);
  if (error || (was_there && after == before))
    return hal::failure(hal::ErrorCode::BadInput, target.string(),
                        fmt::format("process {} could not write it", *run));
  return {};
}

fs::path flight_folder() {
  const char* state = std::getenv("XDG_STATE_HOME");
  if (state && *state) return fs::path(state) / "colift";
  const char* home = std::getenv("HOME");
  return (home && *home ? fs::path(home) / ".local" / "state" : fs::path("/tmp")) / "colift";
}

}  // namespace colift::telemetry
