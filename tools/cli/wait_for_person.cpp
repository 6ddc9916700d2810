#include "tools/cli/wait_for_person.hpp"

#include <poll.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "tools/cli/interrupt.hpp"

namespace colift::tools {

hal::Result<> wait_for_person(std::optional<double> pause_s) {
  using namespace std::chrono_literals;
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(pause_s.value_or(0.0));
  for (;;) {
    if (InterruptGuard::asked()) return hal::failure(hal::ErrorCode::NotReady, "wait", "asked to end");
    if (pause_s) {
      if (std::chrono::steady_clock::now() >= end) return {};
      std::this_thread::sleep_for(50ms);
      continue;
    }
    pollfd in{STDIN_FILENO, POLLIN, 0};
    if (::poll(&in, 1, 100) != 1) continue;
    char c = 0;
    const auto got = ::read(STDIN_FILENO, &c, 1);
    if (got == 1 && c == '\n') return {};
    if (got <= 0)
      return hal::failure(hal::ErrorCode::BadInput, "stdin",
                          "ended before the last step: answer each step with Enter, or say --pause S");
  }
}

}  // namespace colift::tools
