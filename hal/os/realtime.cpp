#include "hal/os/realtime.hpp"

#include <alloca.h>
#include <fmt/format.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <vector>

namespace colift::hal {
namespace {

constexpr std::size_t kMostStack = 4194304;

/// Writes one byte to each page, so that the pages are there.
void touch(volatile char* from, std::size_t bytes) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  for (std::size_t i = 0; i < bytes; i += page) from[i] = 0;
}

__attribute__((noinline)) void touch_stack(std::size_t bytes) {
  touch(static_cast<volatile char*>(alloca(bytes)), bytes);
}

bool kernel_is_realtime() {
  std::ifstream file("/sys/kernel/realtime");
  int value = 0;
  return file >> value && value == 1;
}

}  // namespace

void name_thread(const char* name) noexcept {
  (void)::pthread_setname_np(::pthread_self(), name);
}

bool stay_on_cpu(int cpu) noexcept {
  if (cpu < 0 || cpu >= CPU_SETSIZE) return false;
  cpu_set_t only;
  CPU_ZERO(&only);
  CPU_SET(cpu, &only);
  return ::sched_setaffinity(0, sizeof only, &only) == 0;
}

RealtimeReport ask_for_realtime(const RealtimeRequest& request) {
  RealtimeReport report;
  report.realtime_kernel = kernel_is_realtime();

  if (request.lock_memory) {
    // the allocator keeps what it has, so that a page once touched stays
    (void)::mallopt(M_TRIM_THRESHOLD, -1);
    (void)::mallopt(M_MMAP_MAX, 0);
    report.locked = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
    report.words.push_back(
        report.locked ? "memory: locked, as asked"
                      : fmt::format("memory: not locked ({}); raise the limit memlock for this user in "
                                    "/etc/security/limits.d",
                                    std::strerror(errno)));
  }
  if (request.stack_bytes > 0) touch_stack(std::min(request.stack_bytes, kMostStack));
  if (request.heap_bytes > 0) {
    std::vector<char> heap(request.heap_bytes);
    touch(heap.data(), heap.size());
  }

  if (request.priority > 0) {
    sched_param wanted{};
    wanted.sched_priority = request.priority;
    const int error = ::sched_setscheduler(0, SCHED_FIFO, &wanted) == 0 ? 0 : errno;
    sched_param got{};
    report.fifo = ::sched_getscheduler(0) == SCHED_FIFO && ::sched_getparam(0, &got) == 0;
    report.priority = report.fifo ? got.sched_priority : 0;
    if (error == 0)
      report.words.push_back(
          fmt::format("scheduling: SCHED_FIFO with priority {}, as asked", report.priority));
    else
      report.words.push_back(
          fmt::format("scheduling: ordinary, SCHED_FIFO {} was refused ({}); raise the limit rtprio for this "
                      "user in /etc/security/limits.d",
                      request.priority, std::strerror(error)));
  }
  report.words.push_back(report.realtime_kernel
                             ? "kernel: PREEMPT_RT"
                             : "kernel: ordinary; single answers may come late by milliseconds");
  return report;
}

}  // namespace colift::hal
