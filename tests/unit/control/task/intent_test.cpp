// A motion begins only when it was announced long enough before.

#include "control/task/intent.hpp"

#include <catch2/catch.hpp>

namespace {

using namespace colift;
using control::Intent;
using control::IntentAnnouncer;
using control::Motion;
using namespace std::chrono_literals;

}  // namespace

TEST_CASE("a motion begins half a second after its announcement, which is made once") {
  std::vector<Intent> said;
  IntentAnnouncer announcer(0.5, said);
  for (hal::Timestamp t = 0ms; t < 500ms; t += 4ms) CHECK_FALSE(announcer.may_begin(Motion::Lift, t));
  CHECK(announcer.may_begin(Motion::Lift, 500ms));
  REQUIRE(said.size() == 1);
  CHECK(said[0].motion == Motion::Lift);
  CHECK(said[0].at == 0ms);
  CHECK(said[0].in_s == 0.5);
  CHECK(said[0].says == "lifts the object");
}

TEST_CASE("a motion that was given up is announced again, and one does not stand for another") {
  std::vector<Intent> said;
  IntentAnnouncer announcer(0.5, said);
  CHECK_FALSE(announcer.may_begin(Motion::Lift, 0ms));
  CHECK_FALSE(announcer.may_begin(Motion::Lift, 600ms));  // nobody asked in between
  CHECK(said.size() == 2);
  for (hal::Timestamp t = 604ms; t < 1090ms; t += 4ms) CHECK_FALSE(announcer.may_begin(Motion::Lift, t));
  CHECK_FALSE(announcer.may_begin(Motion::Lower, 1096ms));
  CHECK(said.size() == 3);
}

TEST_CASE(
    "two motions that are asked for in turn both begin: the arm waits while the hand is about to close") {
  std::vector<Intent> said;
  IntentAnnouncer announcer(0.5, said);
  for (hal::Timestamp t = 0ms; t < 500ms; t += 4ms) {
    CHECK_FALSE(announcer.may_begin(Motion::Continue, t));
    CHECK_FALSE(announcer.may_begin(Motion::Close, t));
  }
  CHECK(announcer.may_begin(Motion::Continue, 500ms));
  CHECK(announcer.may_begin(Motion::Close, 500ms));
  CHECK(said.size() == 2);
}

TEST_CASE("without a lead nothing is announced and nothing waits") {
  std::vector<Intent> said;
  IntentAnnouncer announcer(0.0, said);
  CHECK(announcer.may_begin(Motion::Approach, 0ms));
  CHECK(said.empty());
  announcer.request("please step aside", 1s);
  REQUIRE(said.size() == 1);
  CHECK_FALSE(said[0].motion);
}
