#include "tools/emulate/emulate.hpp"

#include <fmt/format.h>

#include <atomic>
#include <csignal>
#include <cstdio>

namespace colift::tools {
namespace {

std::atomic<bool> interrupted{false};

void on_signal(int number) {
  if (interrupted.exchange(true)) {
    std::signal(number, SIG_DFL);
    std::raise(number);
  }
}

void line(const CommonOptions& common, const std::string& text) {
  std::FILE* out = common.json ? stderr : stdout;
  std::fputs((text + "\n").c_str(), out);
  std::fflush(out);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  interrupted = false;
  std::signal(SIGINT, on_signal);
  std::signal(SIGTERM, on_signal);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

bool InterruptGuard::asked() {
  return interrupted;
}

void EmulateLines::ready(const std::string& what) const {
  line(common_, fmt::format("ready: {}", what));
}

void EmulateLines::event(double t_s, const std::string& what) const {
  if (!common_.quiet) line(common_, fmt::format("t={:.3f} {}", t_s, what));
}

void EmulateLines::say(const std::string& what) const {
  line(common_, what);
}

}  // namespace colift::tools
