#include <catch2/catch.hpp>
#include <cmath>

#include "fri_peer.hpp"

using namespace colift;
using namespace colift::sim_hal;
using test::Bench;
using test::Seen;

TEST_CASE("the controller sends first and counts from 1", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  const auto first = b.receive(), second = b.receive();
  REQUIRE(first);
  REQUIRE(second);
  CHECK(first->bytes.size() == 916);
  CHECK(first->send() == 1);
  CHECK(first->reflected() == 0);
  CHECK(second->send() == 2);
  CHECK(second->reflected() == 0);
  CHECK(first->get<std::uint16_t>(4) == 916);
  CHECK(first->get<std::uint16_t>(6) == 0x2006);
  CHECK(first->state() == 1);
  CHECK(first->quality() == 0);
  CHECK(first->power() == 0x7F);
  CHECK(first->get<float>(148) == 0.002f);
  CHECK(first->get<float>(152) == 0.002f);
  CHECK(first->get<float>(188) == 30.0f);
  CHECK((first->q() - Bench::bent().start_rad).norm() < 1e-6);
  CHECK((first->q_total() - first->q()).norm() < 1e-6);
  CHECK(b.clock.now() == test::milliseconds(2));
}

TEST_CASE("answers raise the quality step by step, and it falls again without them", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  std::array<int, 4> first{-1, -1, -1, -1};
  for (int i = 0; i < 150; ++i) {
    const auto m = b.turn();
    int& seen = first[static_cast<std::size_t>(m->quality())];
    if (seen < 0) seen = i;
  }
  CHECK(first == std::array<int, 4>{0, 80, 95, 99});
  CHECK(b.last.get<float>(160) == Approx(1.0));
  CHECK(b.last.get<float>(164) == Approx(0.0002).margin(1e-7));
  CHECK(b.last.get<float>(168) == Approx(0.0).margin(1e-7));
  CHECK(b.last.reflected() == 149);
  CHECK(b.last.get<std::uint32_t>(176) == 0);
  b.say_nothing(6);
  CHECK(b.last.quality() == 1 + 1);
  CHECK(b.last.get<std::uint32_t>(176) == 5);
  b.say_nothing(20);
  CHECK(b.last.quality() == 0);
  CHECK(b.broken().empty());  // nobody has to answer in monitor mode
}

TEST_CASE("an answer after the next measurement is late: used, but it does not count", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(120);
  for (int i = 0; i < 40; ++i) {
    const auto old = b.receive();
    REQUIRE(old);
    run_until(*b.krc, b.clock, b.krc->next_cycle());
    b.reply(b.answer(*old));
    b.krc->poll(b.clock.now());
    b.receive();
  }
  const KrcReport r = b.krc->report();
  CHECK(r.late == 40);
  CHECK(r.answer_rate < 0.5);
}

TEST_CASE("a slow answer caps the quality at OK", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  for (int i = 0; i < 200; ++i) {
    const auto m = b.receive();
    run_until(*b.krc, b.clock, b.clock.now() + test::microseconds(1900));
    b.reply(b.answer(*m));
    b.krc->poll(b.clock.now());
    b.last = *m;
  }
  CHECK(b.last.quality() == 2);
  CHECK(b.last.get<float>(160) == 1.0f);
}

TEST_CASE("by Stanford's hand-shake into command mode, to a motion, and out again", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(10);
  CHECK(b.last.to_int(14) == 30);
  CHECK(b.last.to_int(15) == 10);
  REQUIRE(b.command());
  CHECK(b.last.control() == 3);
  const hal::JointVector start = b.last.q_total(), krl = b.last.joints(292);
  for (int i = 0; i < 1000; ++i) {
    hal::JointVector q = start;
    q[3] += 0.1 * (1.0 - std::cos(0.002 * i * 3.0));
    b.q = q;
    b.turn();
    REQUIRE(b.last.state() == 2);
  }
  // what KRL commands stands still, the motion is FRI's
  CHECK((b.last.joints(292) - krl).norm() < 1e-6);
  CHECK(std::abs(b.last.joints(320)[3]) > 1e-3);
  CHECK((b.last.q() - b.last.q_total()).norm() < 0.02);
  CHECK(b.last.to_int(15) == 20);
  b.q.reset();
  b.from_int[15] = 20;
  REQUIRE(b.until([](const Seen& m) { return m.state() == 1; }));
  CHECK(b.last.power() == 0x7F);
  b.turns(200);
  CHECK(b.last.to_int(15) == 10);
  CHECK(std::abs(b.last.joints(320)[3]) > 1e-3);  // the arm stays, and so does the offset
  b.from_int[15] = 30;
  REQUIRE(b.until([](const Seen& m) { return m.to_int(15) == 30; }));
  const hal::Timestamp closing = b.clock.now();
  // it lingers, then it is silent
  while (b.turn()) {
  }
  CHECK(hal::seconds(b.clock.now() - closing) == Approx(1.5 + 0.25).margin(0.1));
  CHECK(b.krc->ended());
  CHECK(b.broken().empty());
  const KrcReport r = b.krc->report();
  REQUIRE(r.mode_changes.size() == 4);
  CHECK(r.mode_changes[1].to == FriState::Command);
  CHECK(r.mode_changes[2].reason == "the client asked for a stop");
  CHECK(r.missed <= 1);
}

TEST_CASE("a close request from the run before does not end the next one", "[krc]") {
  KrcConfig config = Bench::stanford();
  config.program.linger_s = 0.1;
  config.restart_s = 0.5;
  Bench b(config);
  REQUIRE(b.krc->start(b.clock.now()));
  b.from_int[15] = 30;
  b.turns(100);
  int silent = 0;
  while (!b.turn()) ++silent;
  CHECK(silent >= 1);
  CHECK_FALSE(b.krc->ended());
  CHECK(b.last.send() == 1);
}

TEST_CASE("the commanded motion goes on over three missing answers and ends with the fourth", "[krc]") {
  for (const int missing : {1, 3, 4}) {
    Bench b;
    REQUIRE(b.krc->start(b.clock.now()));
    REQUIRE(b.command());
    hal::JointVector q = b.last.q_total();
    const auto move = [&] {
      q[0] += 0.001;
      b.q = q;
    };
    for (int i = 0; i < 200; ++i) {
      move();
      b.turn();
    }
    const double before = b.last.q_total()[0];
    b.say_nothing(missing);
    for (int i = 0; i < missing; ++i) move();
    b.turn();
    CAPTURE(missing);
    if (missing <= 3) {
      CHECK(b.last.state() == 2);
      CHECK(b.last.q_total()[0] - before == Approx(0.001 * (missing + 1)).margin(1e-5));
      move();
      b.turns(5);
      CHECK(b.broken().empty());
      CHECK(b.last.state() == 2);
    } else {
      CHECK(b.last.state() == 1);
      b.q.reset();
      REQUIRE(b.until([](const Seen& m) { return m.power() == 0; }));
      CHECK(b.broken() == "missed-answers");
      CHECK(b.was_told("brakes closed"));
      // it came to rest where it was, not with a jump
      CHECK(b.last.q()[0] - before < 0.05);
      const hal::JointVector rest = b.last.q();
      b.turns(50);
      CHECK((b.last.q() - rest).norm() < 1e-6);
      CHECK(b.last.state() == 1);
    }
  }
}

TEST_CASE("after a fault the drives stay off until an operator acknowledges", "[krc]") {
  for (const bool operator_there : {false, true}) {
    KrcConfig config = Bench::stanford();
    if (operator_there) config.restart_s = 1.0;
    Bench b(config);
    REQUIRE(b.krc->start(b.clock.now()));
    REQUIRE(b.command());
    b.say_nothing(8);
    b.from_int[15] = 20;
    b.turns(400);
    b.from_int[15] = 0;
    b.turns(400);
    CHECK(b.command() == operator_there);
    CHECK(b.was_told("the drives are off") == !operator_there);
  }
}

TEST_CASE("Cartesian impedance is entered with zeros in jntPos and follows frames", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  b.q = hal::JointVector::Zero();
  REQUIRE(b.command(20, 0x3500));
  CHECK(b.last.control() == 2);
  const float z0 = b.last.get<float>(244 + 4 * 11);
  float z = z0;
  std::array<float, 12> frame{};
  for (std::size_t i = 0; i < 12; ++i) frame[i] = b.last.get<float>(244 + 4 * i);
  b.change = [&](std::vector<std::byte>& c) {
    for (std::size_t i = 0; i < 12; ++i) test::set<float>(c, 172 + 4 * i, i == 11 ? z : frame[i]);
  };
  for (int i = 0; i < 250; ++i) {
    z += 0.0002f;
    b.turn();
  }
  b.turns(250);
  CHECK(b.last.state() == 2);
  CHECK(b.last.get<float>(244 + 4 * 11) - z0 == Approx(0.05).margin(0.002));
  CHECK(b.last.get<float>(244 + 4 * 3) == Approx(frame[3]).margin(0.002));
  // the commanded frame is the program's times FRI's
  CHECK(b.last.get<float>(348 + 4 * 11) == Approx(z0).margin(1e-4));
  CHECK(b.broken().empty());
}

TEST_CASE("a superposed wrench pushes against the spring", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command(20, 0x3500));
  const float z0 = b.last.get<float>(244 + 4 * 11);
  std::array<float, 12> frame{};
  for (std::size_t i = 0; i < 12; ++i) frame[i] = b.last.get<float>(244 + 4 * i);
  b.change = [&](std::vector<std::byte>& c) {
    for (std::size_t i = 0; i < 12; ++i) test::set<float>(c, 172 + 4 * i, frame[i]);
    test::set<float>(c, 248 + 4 * 2, 20.0f);
  };
  b.turns(1500);
  // 20 N on 2000 N/m
  CHECK(b.last.get<float>(244 + 4 * 11) - z0 == Approx(0.01).margin(0.0005));
  CHECK(b.last.state() == 2);
}

TEST_CASE("a push shows in torques and as a wrench at the tool in the order Fx Fy Fz Tz Ty Tx", "[krc]") {
  KrcConfig config = Bench::stanford();
  config.faults.push_back(parse_krc_fault("0.5:contact=20:5").value());
  Bench b(config);
  REQUIRE(b.krc->start(b.clock.now()));
  b.turns(2000);
  CHECK(b.last.get<float>(500 + 8) == Approx(-20.0).margin(0.05));
  for (const std::size_t i : {0U, 1U, 3U, 4U, 5U}) CHECK(std::abs(b.last.get<float>(500 + 4 * i)) < 0.05);
  const hal::JointVector sensors = b.last.joints(444), outside = b.last.joints(472);
  // at rest the sensors hold gravity and the push
  CHECK((sensors - b.last.joints(888) + outside).norm() < 0.05);
}

TEST_CASE("Jacobian, mass matrix and gravity are those of the pose", "[krc]") {
  Bench b;
  REQUIRE(b.krc->start(b.clock.now()));
  const auto m = b.receive();
  const hal::JointVector q = m->q();
  const hal::ArmJacobian J = b.dynamics.jacobian(q);
  const hal::JointMatrix M = b.dynamics.mass_matrix(q);
  const int rows[] = {0, 1, 2, 5, 4, 3};
  for (int r = 0; r < 6; ++r)
    for (int i = 0; i < 7; ++i)
      CHECK(m->get<float>(524 + 4 * std::size_t(7 * r + i)) == Approx(J(rows[r], i)).margin(1e-5));
  for (int r = 0; r < 7; ++r)
    for (int i = 0; i < 7; ++i)
      CHECK(m->get<float>(692 + 4 * std::size_t(7 * r + i)) == Approx(M(r, i)).margin(1e-5));
  CHECK((m->joints(888) - b.dynamics.gravity_nm(q)).norm() < 1e-4);
  CHECK((m->joints(444) - b.dynamics.gravity_nm(q)).norm() < 1e-4);
}

TEST_CASE("any cycle from 1 to 100 ms, and nothing else", "[krc]") {
  for (const int ms : {1, 2, 4, 10, 100}) {
    KrcConfig config = Bench::stanford();
    config.cycle = test::milliseconds(ms);
    Bench b(config);
    REQUIRE(b.krc->start(b.clock.now()));
    CHECK(b.command());
    CHECK(b.last.get<float>(148) == static_cast<float>(0.001 * ms));
    b.turns(5);
    CHECK(b.last.state() == 2);
  }
  for (const auto bad : {test::microseconds(500), test::microseconds(2500), test::microseconds(101000)}) {
    KrcConfig config = Bench::stanford();
    config.cycle = bad;
    Bench b(config);
    CHECK(b.krc->start(b.clock.now()).error().code == hal::ErrorCode::BadConfig);
  }
  KrcConfig config;
  config.script = "stanfrod";
  CHECK(Bench(config).krc->start(hal::Timestamp(0)).error().detail.find("stanford") != std::string::npos);
}

TEST_CASE("counters run through 65535 without a hitch", "[krc]") {
  KrcConfig config = Bench::stanford();
  config.cycle = test::milliseconds(1);
  Bench b(config);
  b.send = 65000;
  REQUIRE(b.krc->start(b.clock.now()));
  REQUIRE(b.command());
  bool wrapped = false;
  for (int i = 0; i < 66000; ++i) {
    const auto m = b.turn();
    REQUIRE(m->state() == 2);
    wrapped = wrapped || m->send() == 0;
  }
  CHECK(wrapped);
  CHECK(b.krc->report().missed == 0);
  CHECK(b.krc->report().reordered == 0);
}
