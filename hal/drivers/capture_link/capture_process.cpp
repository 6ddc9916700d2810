#include "hal/drivers/capture_link/capture_process.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

extern char** environ;  // NOLINT: POSIX's own

namespace colift::hal::capture {
namespace {

constexpr int kRingFd = 3;
constexpr int kAsked_ms = 300, kKilled_ms = 200;
constexpr int kReads = 64;  // of one listen(): a process that never stops talking does not hold us

/// Our environment, where `added` wins.
std::vector<std::string> environment_with(const std::vector<std::string>& added) {
  std::vector<std::string> all;
  for (char** e = environ; *e != nullptr; ++e) {
    const std::string entry(*e);
    const std::string key = entry.substr(0, entry.find('=') + 1);
    if (std::none_of(added.begin(), added.end(), [&](const std::string& a) { return a.starts_with(key); }))
      all.push_back(entry);
  }
  all.insert(all.end(), added.begin(), added.end());
  return all;
}

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> p;
  for (std::string& t : texts) p.push_back(t.data());
  p.push_back(nullptr);
  return p;
}

struct Actions {
  posix_spawn_file_actions_t files{};
  posix_spawnattr_t how{};
  Actions() {
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&how);
  }
  Actions(const Actions&) = delete;
  Actions& operator=(const Actions&) = delete;
  ~Actions() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&how);
  }
};

}  // namespace

Result<CaptureProcess> CaptureProcess::start(const CaptureCall& call, int ring_fd) {
  constexpr auto kWhere = "capture.start";
  std::array<int, 2> in{-1, -1}, out{-1, -1};
  if (::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) {
    for (const int fd : {in[0], in[1], out[0], out[1]})
      if (fd >= 0) ::close(fd);
    return failure(ErrorCode::DeviceFault, kWhere, fmt::format("no pipe: {}", std::strerror(errno)));
  }
  // above what is given new numbers below
  const auto lift = [](int& fd) {
    const int high = ::fcntl(fd, F_DUPFD_CLOEXEC, 10);
    ::close(std::exchange(fd, high));
  };
  lift(in[0]);
  lift(out[1]);
  int ring = ::fcntl(ring_fd, F_DUPFD_CLOEXEC, 10);

  Actions a;
  posix_spawn_file_actions_adddup2(&a.files, in[0], STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&a.files, out[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&a.files, out[1], STDERR_FILENO);
  posix_spawn_file_actions_adddup2(&a.files, ring, kRingFd);
  posix_spawn_file_actions_addclosefrom_np(&a.files, kRingFd + 1);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  sched_param ordinary{};
  posix_spawnattr_setpgroup(&a.how, 0);
  posix_spawnattr_setsigmask(&a.how, &none);
  posix_spawnattr_setsigdefault(&a.how, &all);
  posix_spawnattr_setschedpolicy(&a.how, SCHED_OTHER);
  posix_spawnattr_setschedparam(&a.how, &ordinary);
  posix_spawnattr_setflags(&a.how, POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF |
                                       POSIX_SPAWN_SETSCHEDULER);

  std::vector<std::string> arguments{call.program, "--ring", std::to_string(kRingFd)};
  arguments.insert(arguments.end(), call.arguments.begin(), call.arguments.end());
  std::vector<std::string> environment = environment_with(call.environment);
  pid_t pid = -1;
  const int failed = ::posix_spawn(&pid, call.program.c_str(), &a.files, &a.how, pointers(arguments).data(),
                                   pointers(environment).data());
  for (const int fd : {in[0], out[1], ring}) ::close(fd);
  if (failed != 0) {
    ::close(in[1]);
    ::close(out[0]);
    return failure(ErrorCode::BadConfig, kWhere,
                   fmt::format("{} cannot be started: {}", call.program, std::strerror(failed)));
  }
  for (const int fd : {in[1], out[0]}) (void)::fcntl(fd, F_SETFL, O_NONBLOCK);
  return CaptureProcess(pid, in[1], out[0]);
}

CaptureProcess::CaptureProcess(CaptureProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      to_(std::exchange(other.to_, -1)),
      from_(std::exchange(other.from_, -1)),
      ended_(std::move(other.ended_)),
      lines_(std::move(other.lines_)) {}

CaptureProcess& CaptureProcess::operator=(CaptureProcess&& other) noexcept {
  std::swap(pid_, other.pid_);
  std::swap(to_, other.to_);
  std::swap(from_, other.from_);
  std::swap(ended_, other.ended_);
  std::swap(lines_, other.lines_);
  return *this;
}

CaptureProcess::~CaptureProcess() {
  if (to_ >= 0) ::close(std::exchange(to_, -1));  // the end of its input asks it to end
  const auto gone_within = [this](int ms) {
    for (int i = 0; i < ms; ++i) {
      if (!exists()) return true;
      ::poll(nullptr, 0, 1);
    }
    return !exists();
  };
  if (pid_ > 0 && !gone_within(kAsked_ms)) {
    kill();
    (void)gone_within(kKilled_ms);
  }
  close_pipes();
}

void CaptureProcess::close_pipes() {
  if (to_ >= 0) ::close(std::exchange(to_, -1));
  if (from_ >= 0) ::close(std::exchange(from_, -1));
}

void CaptureProcess::listen(CaptureNews& news) {
  std::array<char, 4096> bytes{};
  for (int i = 0; i < kReads && from_ >= 0; ++i) {
    const ssize_t n = ::read(from_, bytes.data(), bytes.size());
    if (n <= 0) break;
    lines_.take({bytes.data(), static_cast<std::size_t>(n)}, news);
  }
}

void CaptureProcess::wait(Duration timeout) const {
  const auto ms = std::chrono::ceil<std::chrono::milliseconds>(std::max(timeout, Duration(0))).count();
  pollfd p{from_, POLLIN, 0};
  const int ready = ::poll(&p, 1, static_cast<int>(std::min<long>(ms, 1000)));
  // a pipe whose other end is closed is always ready
  if (ready > 0 && (p.revents & POLLIN) == 0) ::poll(nullptr, 0, static_cast<int>(std::min<long>(ms, 5)));
}

bool CaptureProcess::exists() {
  if (pid_ <= 0) return false;
  int status = 0;
  const pid_t done = ::waitpid(pid_, &status, WNOHANG);
  if (done == 0) return true;
  if (done == pid_ && WIFSIGNALED(status))
    ended_ = fmt::format("signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)));
  else if (done == pid_)
    ended_ = fmt::format("status {}", WEXITSTATUS(status));
  else
    ended_ = "unknown";
  pid_ = -1;
  return false;
}

void CaptureProcess::send_line(const std::string& line) const {
  const std::string text = line + "\n";
  // who does not read closes its end: no signal for that
  sigset_t pipe, before;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &pipe, &before);
  const bool broken = to_ >= 0 && ::write(to_, text.data(), text.size()) < 0 && errno == EPIPE;
  if (broken) {
    const timespec now{0, 0};
    while (::sigtimedwait(&pipe, nullptr, &now) < 0 && errno == EINTR) {
    }
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
}

void CaptureProcess::kill() const {
  if (pid_ > 0) (void)::kill(pid_, SIGKILL);
}

}  // namespace colift::hal::capture
