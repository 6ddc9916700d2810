#include "tools/telemetry/record/flight_request.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>

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

bool alive(pid_t pid) {
  return pid > 0 && ::kill(pid, 0) == 0;
}

std::optional<pid_t> newest_run(const fs::path& folder) {
  std::optional<pid_t> best;
  fs::file_time_type best_time{};
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (!name.starts_with("run-")) continue;
    const auto pid = static_cast<pid_t>(std::strtol(name.c_str() + 4, nullptr, 10));
    if (!alive(pid)) {
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
      answering_(other.answering_) {
  other.announcement_.clear();
}

hal::Result<FlightPost> FlightPost::open() {
  const auto folder = own_folder();
  if (!folder) return tl::unexpected(folder.error());
  FlightPost post(*folder);
  std::error_code ignored;
  fs::remove(post.request_, ignored);
  std::ofstream(post.announcement_) << ::getpid() << '\n';
  return post;
}

FlightPost::~FlightPost() {
  if (announcement_.empty()) return;
  std::error_code ignored;
  fs::remove(announcement_, ignored);
  fs::remove(request_, ignored);
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
  if (!run || !alive(*run) || !fs::exists(announcement(*folder, *run)))
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
