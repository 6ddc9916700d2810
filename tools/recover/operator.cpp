#include "tools/recover/operator.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <cstdio>
#include <thread>

#include "hal/types/time.hpp"

namespace colift::tools {
namespace {

using control::Confirmation;
using control::RecoveryStep;

void print(const std::string& line) {
  std::fprintf(stderr, "%s\n", line.c_str());
}

}  // namespace

struct KeyboardOperator::Impl {
  double hold_s;
  termios before{};
  bool raw = false;
  hal::SteadyClock clock;
  hal::Timestamp space_at{0};

  /// The keys that were pressed since the last call; 0: none.
  char key() {
    pollfd in{STDIN_FILENO, POLLIN, 0};
    char c = 0;
    if (::poll(&in, 1, 0) != 1 || ::read(STDIN_FILENO, &c, 1) != 1) return 0;
    return c;
  }
  void forget_keys() {
    while (key() != 0) {
    }
    space_at = hal::Timestamp(0);
  }

  Confirmation ask(RecoveryStep step, const std::string& what, const std::function<bool()>& interrupted) {
    print(fmt::format("next: {}", what));
    if (step == RecoveryStep::Lower)
      print("  hold SPACE to do it; p: a person holds the object, open the hand here; n: no");
    else if (step == RecoveryStep::TakeOver)
      print("  p: a person holds the object; n: no");
    else if (step == RecoveryStep::Release)
      print("  y: open the hand; n: no");
    else
      print("  hold SPACE to do it, release it to stop; n: no");
    forget_keys();
    for (;;) {
      if (interrupted()) return Confirmation::No;
      const char c = key();
      if (c == 'n' || c == 'N') return Confirmation::No;
      const bool may_be_held = step == RecoveryStep::Lower || step == RecoveryStep::TakeOver;
      if (may_be_held && (c == 'p' || c == 'P')) return Confirmation::PersonHolds;
      if (step == RecoveryStep::Release && (c == 'y' || c == 'Y')) return Confirmation::Yes;
      if (step != RecoveryStep::Release && step != RecoveryStep::TakeOver && c == ' ') {
        space_at = clock.now();
        return Confirmation::Yes;
      }
      if (c == 0) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
  }

  bool held() {
    for (char c = key(); c != 0; c = key())
      if (c == ' ') space_at = clock.now();
    return hal::seconds(clock.now() - space_at) < hold_s;
  }
};

KeyboardOperator::KeyboardOperator(double hold_s) : impl_(std::make_unique<Impl>()) {
  impl_->hold_s = hold_s;
  if (::tcgetattr(STDIN_FILENO, &impl_->before) != 0) return;
  termios now = impl_->before;
  now.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  impl_->raw = ::tcsetattr(STDIN_FILENO, TCSANOW, &now) == 0;
}

KeyboardOperator::~KeyboardOperator() {
  if (impl_->raw) (void)::tcsetattr(STDIN_FILENO, TCSANOW, &impl_->before);
}

bool KeyboardOperator::is_there() {
  return ::isatty(STDIN_FILENO) == 1;
}

control::RecoveryHooks KeyboardOperator::hooks(const std::function<bool()>& interrupted) {
  control::RecoveryHooks hooks;
  hooks.confirm = [this, interrupted](RecoveryStep step, const std::string& what) {
    return impl_->ask(step, what, interrupted);
  };
  hooks.may_move = [this] { return impl_->held(); };
  hooks.interrupted = interrupted;
  hooks.say = print;
  return hooks;
}

control::RecoveryHooks confirm_everything(const std::function<bool()>& interrupted, bool quiet) {
  control::RecoveryHooks hooks;
  hooks.confirm = [quiet](RecoveryStep, const std::string& what) {
    if (!quiet) print("next: " + what);
    return Confirmation::Yes;
  };
  hooks.may_move = [] { return true; };
  hooks.interrupted = interrupted;
  hooks.say = [quiet](const std::string& line) {
    if (!quiet) print(line);
  };
  return hooks;
}

}  // namespace colift::tools
