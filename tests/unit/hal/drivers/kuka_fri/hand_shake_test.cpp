// The client's side of each KRL program, step by step, against the tables in docs/krl-hand-shakes.md.
#include "hal/drivers/kuka_fri/hand_shake.hpp"

#include <catch2/catch.hpp>

#include "hal/drivers/kuka_fri/wire/krl_channels.hpp"

namespace colift::hal {
namespace {

struct Talk {
  std::unique_ptr<HandShake> side;
  FriMeasurement m;
  KrlChannels out;

  explicit Talk(const char* script, std::int32_t strategy = 30) : side(make_hand_shake(script, strategy)) {
    m.state = FriState::Monitor;
    m.quality = FriQuality::Perfect;
  }
  ScriptSign say(Ask ask, double seconds = 0.002) {
    for (double t = 0.0; t < seconds - 1e-9; t += 0.002) side->step(ask, m, 0.002, 1.0, out);
    return side->sign();
  }
  std::int32_t& to(std::size_t i) { return m.krl.integer[i]; }
  [[nodiscard]] std::int32_t from(std::size_t i) const { return out.integer[i]; }
};

/// The colift program, answering: it echoes the heartbeat as the real one does.
struct CoLiftTalk : Talk {
  CoLiftTalk() : Talk("colift") {
    to(0) = 10001;
    to(1) = 1;
  }
  ScriptSign say(Ask ask, double seconds = 0.002) {
    for (double t = 0.0; t < seconds - 1e-9; t += 0.002) {
      to(4) = from(4);
      side->step(ask, m, 0.002, 1.0, out);
    }
    return side->sign();
  }
};

}  // namespace

TEST_CASE("colift: a start is a numbered request, which the program takes and ends", "[fri][krl]") {
  CoLiftTalk t;
  t.to(3) = 41;
  CHECK(t.say(Ask::Nothing) == ScriptSign::Unknown);
  CHECK(t.from(0) == 10001);
  CHECK(t.from(1) == 0);
  CHECK(t.from(3) == 41);
  CHECK(t.say(Ask::Start) == ScriptSign::Working);
  CHECK(t.from(1) == 1);
  CHECK(t.from(2) == 30);
  CHECK(t.from(3) == 42);
  t.to(3) = 42;
  t.to(1) = 2;
  CHECK(t.say(Ask::Start, 3.0) == ScriptSign::Working);
  t.to(1) = 3;
  t.to(5) = 1;
  CHECK(t.say(Ask::Start) == ScriptSign::Done);
  CHECK(t.from(3) == 42);
  CHECK(t.say(Ask::Stop) == ScriptSign::Working);
  CHECK(t.from(1) == 2);
  CHECK(t.from(3) == 43);
}

TEST_CASE("colift: numbers begin anew after 30000", "[fri][krl]") {
  CoLiftTalk t;
  t.to(3) = 30000;
  t.say(Ask::Start);
  CHECK(t.from(3) == 1);
}

TEST_CASE("colift: the heartbeat steps every 50 ms and begins anew after 30000", "[fri][krl]") {
  CoLiftTalk t;
  t.say(Ask::Nothing);
  const std::int32_t first = t.from(4);
  t.say(Ask::Nothing, 1.0);
  CHECK(t.from(4) == first + 20);
  for (int i = 0; i < 30000; ++i) {
    t.side->step(Ask::Nothing, t.m, 0.05, 1.0, t.out);
    REQUIRE(t.from(4) >= 1);
    REQUIRE(t.from(4) <= 30000);
  }
  CHECK(t.from(4) == first + 20);
}

TEST_CASE("colift: refusals, other programs, halts and restarts are told apart", "[fri][krl]") {
  CoLiftTalk t;
  SECTION("refused with a code") {
    t.say(Ask::Start);
    t.to(3) = t.from(3);
    t.to(5) = 4;
    CHECK(t.say(Ask::Start) == ScriptSign::Refused);
    CHECK(t.side->code() == 4);
  }
  SECTION("another program") {
    t.to(0) = 0;
    t.say(Ask::Start);
    t.to(3) = t.from(3);  // whatever that one does with its variables
    CHECK(t.say(Ask::Start, 1.1) == ScriptSign::Silent);
  }
  SECTION("no answer at all") {
    CHECK(t.say(Ask::Start, 1.1) == ScriptSign::Silent);
  }
  SECTION("halted at the panel: it neither takes the request nor echoes") {
    t.say(Ask::Nothing, 0.5);
    CHECK(t.Talk::say(Ask::Start, 1.3) == ScriptSign::Halted);
  }
  SECTION("begun anew: it shows the number, but waits") {
    t.say(Ask::Start);
    t.to(3) = t.from(3);
    t.to(1) = 1;
    t.to(5) = 0;
    CHECK(t.say(Ask::Start, 0.1) == ScriptSign::Working);
    CHECK(t.say(Ask::Start, 0.5) == ScriptSign::Restarted);
  }
}

TEST_CASE("stanford: strategy and 10 start, 20 stops, the close code is what it names", "[fri][krl]") {
  Talk t("stanford", 20);
  t.to(14) = 30;
  t.to(15) = 10;
  t.say(Ask::Nothing);
  CHECK(t.from(15) == 0);
  CHECK(t.say(Ask::Start) == ScriptSign::Working);
  CHECK(t.from(14) == 20);
  CHECK(t.from(15) == 10);
  t.to(15) = 20;
  CHECK(t.say(Ask::Start) == ScriptSign::Done);
  CHECK(t.from(15) == 10);
  CHECK(t.say(Ask::Stop) == ScriptSign::Working);
  CHECK(t.from(15) == 20);
  t.to(15) = 10;
  CHECK(t.say(Ask::Stop) == ScriptSign::Done);
  t.to(14) = 40;
  t.say(Ask::Close);
  CHECK(t.from(15) == 40);
  t.to(15) = 30;
  CHECK(t.say(Ask::Close) == ScriptSign::Ended);
}

TEST_CASE("stanford: a start that failed is taken back before the next", "[fri][krl]") {
  Talk t("stanford");
  t.to(15) = 20;  // it has called friStart once, the controller is in monitor mode
  t.say(Ask::Start);
  CHECK(t.from(15) == 20);
  t.to(15) = 10;
  t.say(Ask::Start);
  CHECK(t.from(15) == 10);
  CHECK(t.say(Ask::Start, 1.2) == ScriptSign::Silent);
}

TEST_CASE("tum: a request stands until it is seen, at most 4.5 s, and clears after a guard time",
          "[fri][krl]") {
  Talk t("tum");
  t.say(Ask::Nothing);
  CHECK(t.from(0) == 0);
  t.say(Ask::Start);
  CHECK(t.from(0) == 1);
  CHECK(t.out.boolean == 1);
  SECTION("seen") {
    t.m.krl.boolean = 1;
    CHECK(t.say(Ask::Start) == ScriptSign::Done);
    CHECK(t.out.boolean == 0);
    CHECK(t.from(0) == 1);
    t.m.krl.boolean = 0;
    t.m.state = FriState::Command;
    t.say(Ask::Start, 0.81);
    CHECK(t.from(0) == 0);
    CHECK(t.out.boolean == 1 << 7);
    t.say(Ask::Stop);
    CHECK(t.from(0) == 2);
    CHECK(t.out.boolean == ((1 << 7) | 1));
  }
  SECTION("never seen") {
    CHECK(t.say(Ask::Start, 4.4) == ScriptSign::Working);
    CHECK(t.say(Ask::Start, 0.2) == ScriptSign::Silent);
    CHECK(t.out.boolean == 0);
    CHECK(t.from(0) == 0);
  }
}

TEST_CASE("cep: begun anew it starts in position control, is stopped, and then takes the strategy",
          "[fri][krl]") {
  Talk t("cep", 30);
  t.to(1) = 10;
  CHECK(t.say(Ask::Nothing) == ScriptSign::Unknown);
  CHECK(t.from(1) == 0);
  CHECK(t.say(Ask::Start, 5.0) == ScriptSign::Working);  // it waits for perfect quality, as long as it takes
  CHECK(t.side->detour());
  CHECK(t.from(0) == 30);
  CHECK(t.from(1) == 1);
  t.m.state = FriState::Command;
  t.m.control = FriControl::Position;
  CHECK(t.say(Ask::Start, 0.6) == ScriptSign::Working);
  CHECK(t.from(1) == 1);
  t.to(1) = 1;
  CHECK(t.say(Ask::Start, 0.6) == ScriptSign::Working);
  CHECK(t.side->detour());
  CHECK(t.from(1) == 0);
  t.m.state = FriState::Monitor;
  CHECK(t.say(Ask::Start, 0.02) == ScriptSign::Working);  // friStop first, its acknowledgement then
  t.to(1) = 0;
  CHECK(t.say(Ask::Start) == ScriptSign::Working);
  CHECK_FALSE(t.side->detour());
  CHECK(t.from(1) == 1);
  t.m.state = FriState::Command;
  t.m.control = FriControl::JointImpedance;
  CHECK(t.say(Ask::Start, 0.1) == ScriptSign::Working);
  t.to(1) = 1;
  CHECK(t.say(Ask::Start) == ScriptSign::Done);
  CHECK(t.from(1) == 1);
  CHECK(t.say(Ask::Stop) == ScriptSign::Working);
  CHECK(t.from(1) == 0);
  t.m.state = FriState::Monitor;
  t.to(1) = 0;
  CHECK(t.say(Ask::Stop) == ScriptSign::Done);
}

TEST_CASE("cep: position control needs no detour, a start of before is taken back", "[fri][krl]") {
  Talk t("cep", 10);
  t.to(1) = 10;
  t.say(Ask::Start);
  CHECK_FALSE(t.side->detour());
  CHECK(t.from(1) == 1);
  Talk old("cep", 30);
  old.to(1) = 1;  // it has started once, the controller is in monitor mode
  old.say(Ask::Start);
  CHECK(old.from(1) == 0);
  CHECK_FALSE(old.side->detour());
  old.to(1) = 0;
  old.say(Ask::Start);
  CHECK(old.from(1) == 1);
}

TEST_CASE("cep: command mode that is lost on the detour, other programs, none at all", "[fri][krl]") {
  Talk t("cep", 30);
  t.to(1) = 10;
  t.say(Ask::Start, 0.1);
  t.m.state = FriState::Command;
  t.say(Ask::Start, 0.1);
  SECTION("before it says that it has started") {
    t.m.state = FriState::Monitor;
    CHECK(t.say(Ask::Start) == ScriptSign::Lost);
  }
  SECTION("after it") {
    t.to(1) = 1;
    t.say(Ask::Start, 0.1);
    t.m.state = FriState::Monitor;
    CHECK(t.say(Ask::Start, 0.2) == ScriptSign::Working);
    CHECK(t.say(Ask::Start, 0.2) == ScriptSign::Lost);
  }
  SECTION("taken back while it commands in position control: its flags stay until monitor mode") {
    t.to(1) = 1;
    CHECK(t.say(Ask::Stop, 0.1) == ScriptSign::Working);
    CHECK(t.side->detour());
    t.m.state = FriState::Monitor;
    t.to(1) = 0;
    CHECK(t.say(Ask::Stop) == ScriptSign::Done);
    CHECK_FALSE(t.side->detour());
  }
  SECTION("another program") {
    Talk other("cep");
    other.to(1) = 7;
    CHECK(other.say(Ask::Start, 1.1) == ScriptSign::Silent);
  }
  SECTION("nobody") {
    Talk none("cep");
    CHECK(none.say(Ask::Start, 2.0) == ScriptSign::Working);
    CHECK(none.say(Ask::Start, 1.0) == ScriptSign::Silent);
  }
}

TEST_CASE("openkc: the strategy, then friStart, each with a bit that is answered", "[fri][krl]") {
  Talk t("openkc", 20);
  const auto answer = [&](std::int32_t command) {
    t.m.krl.boolean = 1;
    t.to(14) = command;
    ++t.to(13);
  };
  CHECK(t.say(Ask::Nothing) == ScriptSign::Unknown);
  CHECK(t.out.boolean == 0);
  CHECK(t.say(Ask::Start) == ScriptSign::Working);
  CHECK(t.out.boolean == 1);
  CHECK(t.from(15) == 6);
  answer(6);
  CHECK(t.say(Ask::Start) == ScriptSign::Working);
  CHECK(t.out.boolean == 0);
  CHECK(t.from(15) == 0);
  t.m.krl.boolean = 0;
  t.say(Ask::Start, 0.004);
  CHECK(t.out.boolean == 1);
  CHECK(t.from(15) == 1);
  CHECK(t.from(13) == 1);
  answer(1);
  t.say(Ask::Start);
  t.m.krl.boolean = 0;
  CHECK(t.say(Ask::Start) == ScriptSign::Done);
  SECTION("and a stop") {
    CHECK(t.say(Ask::Stop) == ScriptSign::Working);
    CHECK(t.from(15) == 2);
    answer(2);
    t.say(Ask::Stop);
    t.m.krl.boolean = 0;
    CHECK(t.say(Ask::Stop) == ScriptSign::Done);
  }
  SECTION("an answer that stands there from before is none") {
    answer(2);
    CHECK(t.say(Ask::Stop, 0.1) == ScriptSign::Working);
    CHECK(t.out.boolean == 0);
    t.m.krl.boolean = 0;
    t.say(Ask::Stop);
    CHECK(t.from(15) == 2);
  }
  SECTION("an answer to something else is none, and none at all is silence") {
    t.say(Ask::Stop);
    answer(7);
    CHECK(t.say(Ask::Stop, 0.5) == ScriptSign::Working);
    CHECK(t.from(15) == 2);
    CHECK(t.say(Ask::Stop, 1.0) == ScriptSign::Silent);
    CHECK(t.out.boolean == 0);
  }
}

TEST_CASE("vendor: 1, then 10 once the quality is ok; a real is mirrored", "[fri][krl]") {
  Talk t("vendor");
  t.m.krl.real[1] = 3.5f;
  t.m.quality = FriQuality::Bad;
  t.say(Ask::Start);
  CHECK(t.from(0) == 1);
  CHECK(t.out.real[0] == 3.5f);
  t.m.quality = FriQuality::Ok;
  t.say(Ask::Start);
  CHECK(t.from(0) == 10);
  t.m.quality = FriQuality::Bad;  // keeps its word
  t.say(Ask::Start);
  CHECK(t.from(0) == 10);
  t.say(Ask::Stop);
  CHECK(t.from(0) == 1);
  t.to(0) = -1;
  CHECK(t.say(Ask::Start) == ScriptSign::Ended);
}

TEST_CASE("without a program nothing is said", "[fri][krl]") {
  Talk t("none");
  CHECK(t.say(Ask::Start, 1.0) == ScriptSign::Unknown);
  CHECK(t.out == KrlChannels{});
}

}  // namespace colift::hal
