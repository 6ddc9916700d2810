#include "control/task/posture_history.hpp"

#include <catch2/catch.hpp>

using namespace colift;
using namespace colift::control;
using namespace std::chrono_literals;

namespace {

RobotPosture at_angle(double rad) {
  RobotPosture p;
  p.q_rad.setConstant(rad);
  return p;
}

}  // namespace

TEST_CASE("a frame that comes late gets the posture of its exposure") {
  PostureHistory past;
  const RobotPosture now = at_angle(9.0);
  CHECK(past.at(5ms, now).q_rad[0] == 9.0);  // nothing is known
  for (int i = 0; i < 1000; ++i) past.add(std::chrono::milliseconds(5 * i), at_angle(0.001 * i));
  CHECK(past.at(4900ms, now).q_rad[0] == Approx(0.98));
  CHECK(past.at(4902500us, now).q_rad[0] == Approx(0.9805));
  CHECK(past.at(6000ms, now).q_rad[0] == Approx(0.999));  // after the newest
  // older than what is kept: the oldest one
  CHECK(past.at(0ms, now).q_rad[0] == Approx(0.744));
}
