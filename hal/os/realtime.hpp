#pragma once

#include <string>
#include <vector>

namespace colift::hal {

struct RealtimeRequest {
  int priority = 80;  ///< SCHED_FIFO, 1 to 99; 0: not asked for. Below the kernel's own threads (50 of irq
                      ///< threads is usual).
  bool lock_memory = true;           ///< mlockall: nothing is paged out or in.
  std::size_t stack_bytes = 262144;  ///< Of the calling thread, touched beforehand.
  std::size_t heap_bytes = 8388608;  ///< Taken once and kept by the allocator.
};

/// What was asked for and what the system gave, read back from it.
struct RealtimeReport {
  bool fifo = false;               ///< The calling thread runs under SCHED_FIFO now.
  int priority = 0;                ///< Its priority there.
  bool locked = false;             ///< mlockall succeeded.
  bool realtime_kernel = false;    ///< /sys/kernel/realtime says 1.
  std::vector<std::string> words;  ///< One sentence each; what is missing says how to get it.

  [[nodiscard]] bool all_of(const RealtimeRequest& asked) const {
    return (asked.priority == 0 || fifo) && (!asked.lock_memory || locked);
  }
};

/// Makes the calling thread ready for a cycle: scheduling, locked memory, touched stack and heap. Never
/// fails; the report tells what is missing. Before the cycle: this allocates and touches files.
[[nodiscard]] RealtimeReport ask_for_realtime(const RealtimeRequest& request);

/// Gives the calling thread a name of at most 15 characters, for top, ps and debuggers.
void name_thread(const char* name) noexcept;

/// Keeps the calling thread on one CPU (from 0). False: there is no such CPU for this program.
bool stay_on_cpu(int cpu) noexcept;

}  // namespace colift::hal
