#include "hal/drivers/capture_link/process/commands.hpp"

#include <fcntl.h>
#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <utility>

#include "hal/drivers/capture_link/process/words_out.hpp"

namespace colift::capture {
namespace {

/// Little is lost when the machine gives nothing: the libraries buffer some milliseconds.
void ask_for_priority() {
  sched_param request{};
  request.sched_priority = 10;  // below the arm's cycle
  if (::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &request) != 0)
    (void)::setpriority(PRIO_PROCESS, 0, -10);
}

}  // namespace

void Commands::listen() {
  std::thread([this] { run(); }).detach();
}

void Commands::run() {
  char bytes[256];
  std::string rest;
  for (;;) {
    const ssize_t n = ::read(STDIN_FILENO, bytes, sizeof bytes);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      {
        const std::lock_guard lock(mutex_);
        lines_.emplace_back("quit");
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(500));  // for an orderly end
      std::_Exit(0);
    }
    for (ssize_t i = 0; i < n; ++i) {
      if (bytes[i] != '\n') {
        if (rest.size() < 100) rest += bytes[i];
        continue;
      }
      const std::lock_guard lock(mutex_);
      if (lines_.size() < 20) lines_.push_back(rest);
      rest.clear();
    }
  }
}

std::vector<std::string> Commands::take() {
  const std::lock_guard lock(mutex_);
  return std::exchange(lines_, {});
}

hal::Result<hal::capture::FrameRingWriter> begin_capture(int fd) {
  std::signal(SIGPIPE, SIG_IGN);
  (void)::setvbuf(stdout, nullptr, _IOLBF, 0);
  (void)::fcntl(STDOUT_FILENO, F_SETFL, ::fcntl(STDOUT_FILENO, F_GETFL) | O_NONBLOCK);
  auto ring = hal::capture::FrameRingWriter::map(fd);
  if (!ring)
    say_end(hal::capture::CaptureEnd::BadCall, ring.error().text());
  else
    ask_for_priority();
  return ring;
}

}  // namespace colift::capture
