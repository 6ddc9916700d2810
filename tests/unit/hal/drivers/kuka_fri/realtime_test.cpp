#include "hal/os/realtime.hpp"

#include <sched.h>
#include <sys/mman.h>

#include <catch2/catch.hpp>
#include <thread>

namespace colift::hal {

TEST_CASE("what was asked of the system and what it gave is told as it is", "[os][realtime]") {
  RealtimeReport report;
  bool fifo = false;
  int priority = 0;
  // a thread of its own: the answer depends on the machine, the report must agree with the system in any case
  std::thread([&] {
    report = ask_for_realtime(
        {.priority = 3, .lock_memory = true, .stack_bytes = 64 * 1024, .heap_bytes = 100000});
    sched_param p{};
    fifo = ::sched_getscheduler(0) == SCHED_FIFO;
    ::sched_getparam(0, &p);
    priority = p.sched_priority;
  }).join();
  (void)::munlockall();
  CHECK(report.fifo == fifo);
  CHECK(report.priority == priority);
  REQUIRE(report.words.size() == 3);
  CHECK(report.words[0].find(report.locked ? "locked, as asked" : "not locked") != std::string::npos);
  CHECK(report.words[1].find(fifo ? "SCHED_FIFO with priority 3" : "refused") != std::string::npos);
  CHECK(report.all_of({.priority = 0, .lock_memory = false}));
}

TEST_CASE("what was not asked for is not said", "[os][realtime]") {
  const RealtimeReport report =
      ask_for_realtime({.priority = 0, .lock_memory = false, .stack_bytes = 0, .heap_bytes = 0});
  CHECK_FALSE(report.locked);
  CHECK(report.words.size() == 1);
}

}  // namespace colift::hal
