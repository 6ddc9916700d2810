#pragma once

namespace colift::tools {

/// While a guard lives, SIGINT, SIGTERM, SIGHUP, or output that nobody can read any more (a closed terminal,
/// a pipe whose reader ended) ask the program to end; it does so in its own time, arm at rest, files closed.
/// A second SIGINT or SIGTERM ends it at once. SIGHUP stays ignored where it was (nohup), and never ends it
/// at once: a closing terminal may send several. From the first guard on, writing to a closed pipe is an
/// error and no signal, to the end of the program.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  /// Costs a system call.
  [[nodiscard]] static bool asked();
};

}  // namespace colift::tools
