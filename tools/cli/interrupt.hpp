#pragma once

namespace colift::tools {

/// True once SIGINT or SIGTERM came while a guard lives. The second signal ends the program.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  [[nodiscard]] static bool asked();
};

}  // namespace colift::tools
