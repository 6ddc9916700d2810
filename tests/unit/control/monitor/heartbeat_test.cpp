#include "control/monitor/heartbeat.hpp"

#include <catch2/catch.hpp>

using namespace colift::control;
using namespace std::chrono_literals;

TEST_CASE("a missing beat is counted in the observer's own time", "[monitor]") {
  Heartbeat heart;
  BeatMonitor monitor;
  colift::hal::Timestamp now = 7s;
  CHECK(monitor.update(heart.count(), now) == 0.0);
  for (int i = 0; i < 60; ++i) monitor.update(heart.count(), now += 2ms);
  CHECK(monitor.silent_s() == Approx(0.12));
  heart.beat();
  CHECK(monitor.update(heart.count(), now += 2ms) == 0.0);
  CHECK(monitor.update(heart.count(), now += 2ms) == Approx(0.002));
}

TEST_CASE("an observer that stood still itself accuses nobody", "[monitor]") {
  BeatMonitor monitor;
  monitor.update(1, 0ms);
  CHECK(monitor.update(1, 5s) == Approx(0.02));
  // a clock that runs backwards takes nothing back
  CHECK(monitor.update(1, 4s) == Approx(0.02));
}
