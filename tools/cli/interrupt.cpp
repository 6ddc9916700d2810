#include "tools/cli/interrupt.hpp"

#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <csignal>

namespace colift::tools {
namespace {

std::atomic<bool> interrupted{false};

void on_signal(int number) {
  const bool second = interrupted.exchange(true);
  if (second && number != SIGHUP) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

/// Nobody can read what is written to stdout or stderr: the other end of the pipe is closed, the terminal
/// gone.
bool nobody_reads() {
  pollfd outputs[] = {{STDOUT_FILENO, 0, 0}, {STDERR_FILENO, 0, 0}};
  if (::poll(outputs, 2, 0) <= 0) return false;
  constexpr short kGone = POLLERR | POLLHUP;
  return ((outputs[0].revents | outputs[1].revents) & kGone) != 0;
}

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupted = false;
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
  if (std::signal(SIGHUP, on_signal) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
  if (std::signal(SIGHUP, SIG_DFL) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);
}

bool InterruptGuard::asked() {
  if (!interrupted && nobody_reads()) interrupted = true;
  return interrupted;
}

}  // namespace colift::tools
