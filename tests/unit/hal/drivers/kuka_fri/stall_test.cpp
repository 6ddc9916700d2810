// The PC stood still, not the KRC: who is told so looks at the right machine.

#include <chrono>
#include <utility>

#include "fri_arm_rig.hpp"
#include "moving_driver.hpp"

namespace colift {

using namespace test;
using namespace std::chrono_literals;

namespace {

/// Time passes while the driver waits, as for a process that got SIGSTOP.
void stall(Moving& run, std::chrono::milliseconds by) {
  bool once = true;
  run.krc.tamper = [&](hal::FriMeasurement&) {
    if (std::exchange(once, false)) run.krc.clock.advance(by);
    return true;
  };
  run.cycles(2);
  run.krc.tamper = nullptr;
}

}  // namespace

TEST_CASE("a stall of this machine is named with its length, not as an emergency stop", "[fri][faults]") {
  Moving run;
  run.cycles(100);
  CHECK(run.arm->status().stall_s == 0.0);
  const auto by = GENERATE(50ms, 200ms, 2000ms);
  CAPTURE(by.count());
  stall(run, by);
  CHECK(run.arm->status().stall_s == Approx(1e-3 * static_cast<double>(by.count())).epsilon(0.1));
  // what a KRC does then
  run.krc.m.power = 0;
  run.krc.m.misses = 40;
  run.krc.monitor_mode();
  run.cycles(20);
  const std::string words = run.arm->health().last_error;
  CAPTURE(words);
  CHECK(words.find("this program did not run for ") == 0);
  CHECK(words.find("40 missed") != std::string::npos);
}

TEST_CASE("a KRC that is silent, or loses datagrams, is no stall of this machine", "[fri][faults]") {
  Moving run;
  run.cycles(100);
  const int n = GENERATE(3, 30, 200);
  run.note_device(n);
  run.cycles(20);
  CHECK(run.arm->status().stall_s == 0.0);
}

TEST_CASE("answers that get lost on the network are said before an emergency stop", "[fri][faults]") {
  Moving run;
  run.krc.m.misses = 5000;  // of hours before
  run.cycles(1500);
  CHECK(run.arm->status().recent_misses == 0);
  CHECK(run.arm->status().may_command);
  const bool lossy = GENERATE(true, false);
  if (lossy) run.krc.m.misses += 60;
  run.krc.m.power = 0;
  run.krc.monitor_mode();
  run.cycles(20);
  const std::string words = run.arm->health().last_error;
  CAPTURE(words);
  CHECK((words.find("60 answers of this machine never came") == 0) == lossy);
  CHECK((words.find("the drives are off") != std::string::npos));
}

TEST_CASE("answers that the KRC missed before this program listened are not said to be lost",
          "[fri][faults]") {
  FakeKrc krc;
  krc.m.misses = 5000;
  krc.m.power = 0;
  krc.start_when_good = false;
  const auto arm = krc.arm();
  REQUIRE(arm->configure());
  (void)arm->activate();
  for (int i = 0; i < 3000; ++i) (void)arm->wait_cycle();
  const std::string words = arm->health().last_error;
  CAPTURE(words);
  CHECK(arm->status().recent_misses == 0);
  CHECK_FALSE(words.empty());
  CHECK(words.find("never came") == std::string::npos);
}

TEST_CASE("a stall is forgotten once the arm is commanded again for a while", "[fri][faults]") {
  Moving run;
  run.cycles(100);
  stall(run, 30ms);
  CHECK(run.arm->status().stall_s > 0.0);
  run.cycles(2000);
  CHECK(run.arm->status().stall_s == 0.0);
}

TEST_CASE("a short stall is the cause only where the KRC counts answers that never came", "[fri][faults]") {
  Moving run;
  run.cycles(100);
  const double period_s = run.arm->status().period_s;
  stall(run, std::chrono::milliseconds(static_cast<int>(3.5e3 * period_s)));
  const bool missed = GENERATE(true, false);
  if (missed) run.krc.m.misses += 4;
  run.krc.m.power = 0;
  run.krc.monitor_mode();
  run.cycles(20);
  const std::string words = run.arm->health().last_error;
  CAPTURE(words, period_s, run.arm->status().stall_s);
  CHECK((words.find("this program did not run for ") == 0) == missed);
}

}  // namespace colift
