#include "sim_hal/judge/judge.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "sim_hal/judge/force_limits.hpp"

using namespace colift;
using namespace colift::sim_hal;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

/// A world in the judge's eyes, led by the test.
struct Room {
  Judge judge{hal::built_in_robot(), true};
  SimTruth truth;
  std::vector<BodyContact> contacts;
  double people_m = INFINITY, partner_m = INFINITY;
  hal::JointVector command = SimConfig::home_rad(), set_point = command, speed = hal::JointVector::Zero();
  hal::ImpedanceCommand impedance;
  hal::JointVector pushed_rad = hal::JointVector::Zero();  // how far the arm is off its set point
  hal::HandState hand;
  double t_s = 0.0;

  Room() {
    truth.q_rad = command;
    truth.mass_kg = 4.0;
    impedance.stiffness_nm_rad.setConstant(1000.0);
  }
  void ms(int n = 1, const std::function<void()>& each_cycle = {}) {
    for (int i = 0; i < n; ++i) {
      t_s += 0.001;
      const bool cycle = static_cast<int>(std::lround(t_s * 1000.0)) % 5 == 0;
      if (cycle && each_cycle) each_cycle();
      truth.q_rad = set_point + pushed_rad;
      if (cycle) set_point = command;
      judge.tick(
          {t_s, truth, contacts, people_m, partner_m, command, cycle, set_point, speed, impedance, hand});
    }
  }
  /// A constant speed of A1, reached within limits.
  void drive(int n, double rad_s) {
    ms(n, [&] {
      const double off = rad_s - now_rad_s;
      now_rad_s += std::clamp(off, -0.025, 0.025);
      command[0] += 0.005 * now_rad_s;
      speed[0] = now_rad_s;
    });
  }
  void touch(BodyRegion region, double force_n, double other_m_s = 0.25,
             BodyContact::By by = BodyContact::By::Robot, const Vec3& to = Vec3::UnitX()) {
    BodyContact c;
    c.by = by;
    c.region = region;
    c.force_n = force_n;
    c.force_W = force_n * to;
    c.other_m_s = c.closing_m_s = other_m_s;
    contacts.push_back(c);
  }
  double now_rad_s = 0.0;
};

std::vector<std::string> breaches(const Room& room, bool lifted = false) {
  return room.judge.verdict(lifted).breaches;
}

}  // namespace

TEST_CASE("a short hit counts against the transient limit, a long or clamped one against the quasi-static") {
  Room room;
  room.ms(10);
  room.touch(BodyRegion::LowerArm, 200.0);
  room.ms(40);
  room.contacts.clear();
  room.ms(100);
  CHECK(breaches(room).empty());
  REQUIRE(room.judge.verdict(false).contacts.size() == 1);
  const JudgedContact hit = room.judge.verdict(false).contacts[0];
  CHECK(hit.region == "lower-arm");
  CHECK(hit.force_n == 200.0);
  CHECK(hit.limit_n == 320.0);
  CHECK(hit.clamped_s == 0.0);
  CHECK(hit.t_s == Approx(0.011));

  SECTION("pressed against something else") {
    room.touch(BodyRegion::Hand, 150.0);
    room.touch(BodyRegion::Hand, 150.0, 0.0, BodyContact::By::Object, -Vec3::UnitX());
    room.ms(100);
    const Verdict v = room.judge.verdict(false);
    CHECK_THAT(v.breaches.at(0), StartsWith("hand: 150 N clamped"));
    CHECK(v.contacts.at(1).clamped_s == Approx(0.1).margin(0.002));
  }
  SECTION("for longer than half a second") {
    room.touch(BodyRegion::LowerArm, 170.0);
    room.ms(499);
    CHECK(breaches(room).empty());
    room.ms(100);
    CHECK_THAT(breaches(room).at(0), StartsWith("lower-arm: 170 N clamped"));
  }
  SECTION("a face has no transient limit of its own") {
    room.touch(BodyRegion::Face, 70.0);
    room.ms(3);
    CHECK_THAT(breaches(room).at(0), StartsWith("face: 70 N hit"));
  }
  SECTION("who walks against an arm at rest does it himself") {
    room.touch(BodyRegion::Chest, 600.0, 0.0);
    room.ms(30);
    CHECK(breaches(room).empty());
    CHECK(room.judge.verdict(false).contacts.at(1).his_own);
  }
  SECTION("not so against one that its commands moved when he came, whichever way") {
    room.drive(20, -0.2);
    room.pushed_rad[0] = 0.02;
    room.drive(200, -0.2);
    room.drive(60, 0.0);
    room.touch(BodyRegion::Chest, 600.0, 0.0);
    room.ms(30);
    CHECK_THAT(breaches(room).at(0), StartsWith("chest: 600 N hit"));
  }
  SECTION("nor when the arm keeps him pressed for longer than half a second") {
    room.touch(BodyRegion::Chest, 150.0, 0.0);
    room.ms(600);
    CHECK_THAT(breaches(room).at(0), StartsWith("chest: 150 N clamped"));
    CHECK_FALSE(room.judge.verdict(false).contacts.at(1).his_own);
  }
  SECTION("an object counts while the robot touches it") {
    room.drive(200, -0.2);
    room.touch(BodyRegion::LowerLeg, 600.0, 0.25, BodyContact::By::Object);
    room.drive(30, -0.2);
    CHECK(breaches(room).empty());
    room.truth.robot_touches_object = true;
    room.drive(30, -0.2);
    CHECK_THAT(breaches(room).at(0), StartsWith("lower-leg: 600 N hit by the object"));
  }
}

TEST_CASE("what springs back from his own push is his, what commands drive at him is not") {
  Room room;
  room.ms(200);
  room.touch(BodyRegion::Thigh, 400.0, 0.0);
  room.speed[0] = 1.0;
  room.pushed_rad[0] = -0.05;
  room.ms(30);
  room.contacts.clear();
  room.ms(100);
  const bool driven = GENERATE(true, false);
  CAPTURE(driven);
  if (driven) room.drive(100, 0.2);  // 1000 N m/rad stretched by 0.05 rad: 10 W
  room.speed[0] = 0.5;
  room.touch(BodyRegion::Thigh, 600.0, 0.5);
  room.ms(10);
  const JudgedContact back = room.judge.verdict(false).contacts.at(1);
  CHECK(back.his_own != driven);
  CHECK(breaches(room).empty() != driven);
  CHECK(back.commanded_j == Approx(driven ? 0.95 : 0.0).margin(0.15));
}

TEST_CASE("who still leans on what has come to rest since his own push did that himself") {
  Room room;
  room.ms(200);
  room.touch(BodyRegion::Thigh, 400.0, 0.0);
  room.speed[0] = 1.0;
  room.ms(30);
  room.contacts.clear();
  room.ms(60);
  room.touch(BodyRegion::Thigh, 100.0, 0.0);
  room.ms(10);
  room.speed[0] = 0.0;
  room.ms(80);
  room.contacts.clear();
  room.touch(BodyRegion::Thigh, 600.0, 0.0);
  room.ms(10);
  CHECK(room.judge.verdict(false).contacts.at(1).force_n == 600.0);
  CHECK(room.judge.verdict(false).contacts.at(1).his_own);
  CHECK(breaches(room).empty());
}

TEST_CASE("who runs into what a standing robot holds does it himself, whom a moving one meets with it not") {
  Room room;
  room.truth.robot_touches_object = true;
  const bool moves = GENERATE(false, true);
  if (moves)
    room.drive(600, -0.1);  // lowered: no command puts energy into that
  else
    room.ms(600);
  room.touch(BodyRegion::LowerLeg, 600.0, 0.1, BodyContact::By::Object);  // it swings back once
  room.ms(20);
  const JudgedContact hit = room.judge.verdict(false).contacts.at(0);
  CHECK(hit.his_own != moves);
  CHECK(breaches(room).empty() != moves);
}

TEST_CASE("a hand thrust between a standing robot and its object is the robot's if it is kept there") {
  Room room;
  room.truth.robot_touches_object = true;
  room.ms(600);
  room.touch(BodyRegion::Hand, 300.0, 0.0);
  room.ms(5);
  room.contacts.clear();
  const double pressed_n = GENERATE(20.0, 200.0);
  room.touch(BodyRegion::Hand, pressed_n, 0.0);
  room.touch(BodyRegion::Hand, pressed_n, 0.0, BodyContact::By::Object, -Vec3::UnitX());
  room.ms(300);
  const JudgedContact soon = room.judge.verdict(false).contacts.at(0);
  CHECK(soon.clamped_s > 0.29);
  CHECK(soon.his_own);  // his own weight and speed
  room.ms(400);
  CHECK(room.judge.verdict(false).contacts.at(0).his_own == (pressed_n < 140.0));
}

TEST_CASE("what closing fingers do is the robot's, from the first millisecond") {
  Room room;
  room.ms(600);
  const bool near = GENERATE(true, false);
  room.touch(BodyRegion::Hand, 300.0, 0.0);
  if (near) room.contacts[0].at_W = hal::hand_pose(hal::built_in_robot(), room.truth.q_rad).translation();
  const bool driven = GENERATE(true, false);  // or pressed by him
  room.hand.moving = driven;
  for (int i = 0; i < 20; ++i) {
    for (double& q : room.hand.finger_rad) q += 0.001;
    room.ms();
  }
  CHECK(room.judge.verdict(false).contacts.at(0).his_own != (near && driven));
}

TEST_CASE("two legs that are pushed apart are not clamped") {
  Room room;
  room.ms(200);
  room.touch(BodyRegion::LowerLeg, 140.0, 0.0);
  room.touch(BodyRegion::LowerLeg, 140.0, 0.0, BodyContact::By::Robot, -Vec3::UnitX());
  const bool same = GENERATE(true, false);
  room.contacts.back().left = !same;
  room.ms(100);
  CHECK((room.judge.verdict(false).contacts.at(0).clamped_s > 0.0) == same);
}

TEST_CASE("limits are those of the reference table") {
  CHECK(force_limit(BodyRegion::Hand).quasi_static_n == 140.0);
  CHECK(force_limit(BodyRegion::Back).transient_n == 420.0);
  CHECK(force_limit(BodyRegion::Skull).transient_n == 130.0);
  CHECK(force_limit(BodyRegion::LowerLeg).quasi_static_n == 130.0);
}

TEST_CASE("commands beyond limits and steps are breaches of I1 and I2") {
  Room room;
  room.drive(500, 0.5);
  CHECK(breaches(room).empty());
  SECTION("not a number") {
    room.command[2] = NAN;
    room.ms(5);
    CHECK_THAT(breaches(room).at(0), StartsWith("I1: A3"));
  }
  SECTION("beyond the range") {
    room.command[3] = 3.0;
    room.ms(5);
    CHECK_THAT(breaches(room).at(0), StartsWith("I1: A4"));
  }
  SECTION("a step") {
    room.command[1] += 0.02;
    room.drive(5, 0.5);
    CHECK_THAT(breaches(room).at(0), StartsWith("I2: A2"));
  }
}

TEST_CASE("a first command far from the measured pose breaks I2") {
  Room room;
  room.command[1] += 0.05;
  room.ms(5);
  CHECK_THAT(breaches(room).at(0), Contains("first command"));
}

TEST_CASE("a push has to slow the arm within 10 ms") {
  Room room;
  room.drive(500, 0.5);
  room.touch(BodyRegion::LowerArm, 60.0);
  SECTION("it goes on") {
    room.drive(30, 0.5);
    CHECK_THAT(breaches(room).at(0), StartsWith("I10: 60 N"));
  }
  SECTION("it brakes") {
    room.drive(700, 0.0);
    CHECK(breaches(room).empty());
    CHECK(room.judge.verdict(false).stop_latency_s.value() <= 0.006);
  }
  SECTION("it follows who pushes") {
    room.pushed_rad[0] = 0.02;
    room.drive(30, 0.5);
    CHECK(breaches(room).empty());
  }
  SECTION("it drives against him") {
    room.pushed_rad[0] = -0.02;
    room.drive(30, 0.5);
    CHECK_THAT(breaches(room).at(0), StartsWith("I10: 60 N"));
  }
  SECTION("it brakes a little and goes on") {
    room.pushed_rad[0] = -0.02;
    room.drive(700, 0.4);
    CHECK_THAT(breaches(room).at(0), StartsWith("I10: still"));
  }
}

TEST_CASE("after a stop nothing moves, but for a person who pushes") {
  Room room;
  room.drive(500, 0.3);
  room.judge.task_state("stopped");
  room.drive(600, 0.0);
  CHECK(breaches(room).empty());
  const bool pushed = GENERATE(true, false);
  if (pushed) room.touch(BodyRegion::Hand, 20.0, 0.0);
  room.drive(300, 0.2);
  CHECK(breaches(room).empty() == pushed);
}

TEST_CASE("an arm that yields comes to rest after the last push") {
  Room room;
  room.judge.task_state("yield");
  room.touch(BodyRegion::Hand, 100.0, 0.0);
  room.ms(50);
  room.contacts.clear();
  const bool flies = GENERATE(true, false);
  room.speed[1] = 0.5;
  room.ms(900);
  CHECK(breaches(room).empty());
  if (!flies) room.speed[1] = 0.05;
  room.ms(300);
  REQUIRE(breaches(room).empty() != flies);
  if (flies) CHECK_THAT(breaches(room).at(0), StartsWith("I5: the arm still moves at 0.50 rad/s"));
}

TEST_CASE("a hand that opens while it bears something breaks I4, one whose object stands does not") {
  Room room;
  room.hand.finger_rad = {1.2, 1.2, 1.2};
  room.hand.held = true;
  room.truth.robot_touches_object = true;
  const bool stands = GENERATE(true, false);
  room.truth.robot_force_W = Vec3(0, 0, 18.0);
  room.truth.height_m = 0.02;
  room.ms(700);
  room.hand.held = false;
  room.hand.moving = true;
  room.hand.finger_rad = {1.1, 1.1, 1.1};
  room.truth.robot_force_W.setZero();
  room.ms(50);
  if (!stands) room.truth.height_m = 0.01;
  room.ms(50);
  if (stands) {
    CHECK(breaches(room).empty());
  } else {
    CHECK_THAT(breaches(room).at(0), StartsWith("I4: the hand opened"));
  }
}

TEST_CASE("lifted is said of what rose, with the partner, and of nobody's harm") {
  Room room;
  CHECK(breaches(room).empty());
  CHECK_THAT(breaches(room, true).at(0), StartsWith("I8: reported lifted, but the object rose"));
  room.truth.height_m = 0.05;
  room.truth.partner_W = Vec3::Zero();
  room.ms(10);
  CHECK(breaches(room, true).empty());
  SECTION("he let go on the way") {
    room.truth.partner_W.reset();
    room.ms(10);
    CHECK_THAT(breaches(room, true).at(0), Contains("partner did not hold"));
  }
  SECTION("he let go on the way, took hold again, and it was raised not quite as high") {
    room.truth.partner_W.reset();
    room.truth.height_m = 0.02;
    room.ms(10);
    room.truth.partner_W = Vec3::Zero();
    room.ms(10);
    room.truth.height_m = 0.045;
    room.ms(10);
    CHECK(breaches(room, true).empty());
  }
  SECTION("he let go on the way, and took hold again when it was nearly down") {
    room.truth.partner_W.reset();
    room.ms(10);
    room.truth.height_m = 0.02;
    room.ms(10);
    room.truth.partner_W = Vec3::Zero();
    room.ms(10);
    CHECK_THAT(breaches(room, true).at(0), Contains("partner did not hold"));
  }
  SECTION("somebody was hit") {
    room.touch(BodyRegion::Hand, 60.0);
    room.ms(10);
    CHECK_THAT(breaches(room, true).at(0), Contains("touched with 60 N"));
  }
}

TEST_CASE("distances are the smallest of the run, and unset where nobody was") {
  Room room;
  room.ms();
  CHECK_FALSE(room.judge.verdict(false).min_distance_m);
  room.people_m = 0.4;
  room.ms();
  room.people_m = 0.9;
  room.ms();
  CHECK(room.judge.verdict(false).min_distance_m == 0.4);
}

TEST_CASE("distance over time is the least of each tenth of a second") {
  Room room;
  room.ms(100);
  room.people_m = 0.4;
  room.ms(50);
  room.people_m = 0.9;
  room.ms(150);
  const auto distances = room.judge.verdict(false).distances;
  REQUIRE(distances.size() == 3);
  CHECK(std::isinf(distances[0].people_m));
  CHECK(distances[1].people_m == 0.4);
  CHECK(distances[2].people_m == 0.9);
  CHECK(distances[2].t_s == Approx(0.3));
  CHECK(std::isinf(distances[2].partner_m));
}
