#include "perception/partner/partner_tracker.hpp"

#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <vector>

namespace colift::perception {
namespace {

using namespace std::chrono_literals;
using Kind = PartnerEvent::Kind;
using State = PartnerTracker::State;

constexpr hal::Duration kFrame = 33ms;
const Vec3 kLeftEnd(0.4, 0.1, 0.45);

PartnerObservation hand_at(const Vec3& position, double sigma_m = 0.006) {
  PartnerObservation seen;
  seen.kind = PartnerKind::Grasp;
  seen.grasp = PartnerGrasp{position, Eigen::Matrix3d::Identity() * sigma_m * sigma_m, 500};
  return seen;
}

PartnerObservation nobody() {
  PartnerObservation seen;
  seen.reason = "nothing changed";
  return seen;
}

// Hands frames to a tracker, one every 33 ms, and keeps the events.
struct Story {
  PartnerTracker tracker{TrackerConfig{}};
  hal::Timestamp now{0};
  std::vector<PartnerEvent> events;

  Story& show(const PartnerObservation& seen, hal::Duration during) {
    for (const hal::Timestamp end = now + during; now < end; now += kFrame) {
      if (auto event = tracker.update(now, seen)) events.push_back(*event);
    }
    return *this;
  }

  Story& hide(hal::Duration during) {
    for (const hal::Timestamp end = now + during; now < end; now += kFrame) {
      if (auto event = tracker.update_hidden(now)) events.push_back(*event);
    }
    return *this;
  }
};

TEST_CASE("a brief touch is not a grasp", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 250ms);
  CHECK(story.tracker.state() == State::Touching);
  story.show(nobody(), 400ms);
  CHECK(story.events.empty());
  CHECK(story.tracker.state() == State::Away);
  CHECK_FALSE(story.tracker.grasp());
}

TEST_CASE("a touch that stays for the dwell is a grasp, once", "[partner][tracker]") {
  Story story;
  story.show(nobody(), 200ms).show(hand_at(kLeftEnd), 2s);
  REQUIRE(story.events.size() == 1);
  CHECK(story.events[0].kind == Kind::Grasped);
  CHECK(hal::seconds(story.events[0].at - story.tracker.since()) >= 0.3);
  CHECK(hal::seconds(story.events[0].at - story.tracker.since()) < 0.3 + 0.034);
  CHECK(story.events[0].reason.find("(0.40, 0.10, 0.45) m") != std::string::npos);
  REQUIRE(story.tracker.grasp());
  CHECK((story.tracker.grasp()->position - kLeftEnd).norm() < 1e-9);
}

TEST_CASE("two brief touches do not add up to a grasp", "[partner][tracker]") {
  Story story;
  for (int i = 0; i < 5; ++i) story.show(hand_at(kLeftEnd), 200ms).show(nobody(), 250ms);
  CHECK(story.events.empty());
}

TEST_CASE("a single frame without the hand neither delays nor ends a grasp", "[partner][tracker]") {
  Story story;
  for (int i = 0; i < 20; ++i) story.show(hand_at(kLeftEnd), 3 * kFrame).show(nobody(), kFrame);
  REQUIRE(story.events.size() == 1);
  CHECK(story.events[0].kind == Kind::Grasped);
  CHECK(story.events[0].at <= 363ms);
  CHECK(story.tracker.state() == State::Holding);
}

TEST_CASE("a hand that goes away has let go, with the reason of the frame", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 600ms);
  const auto last = story.now - kFrame;
  story.show(nobody(), 1s);
  REQUIRE(story.events.size() == 2);
  CHECK(story.events[1].kind == Kind::LetGo);
  CHECK(hal::seconds(story.events[1].at - last) > 0.15);
  CHECK(hal::seconds(story.events[1].at - last) <= 0.15 + 0.034);
  CHECK(story.events[1].reason.find("nothing changed") != std::string::npos);
  CHECK(story.tracker.state() == State::Away);
}

TEST_CASE("a hand that moves along the edge has to rest again", "[partner][tracker]") {
  Story story;
  const Vec3 elsewhere = kLeftEnd + Vec3(0.0, 0.08, 0.0);
  story.show(hand_at(kLeftEnd), 600ms).show(hand_at(elsewhere), 200ms);
  REQUIRE(story.events.size() == 2);
  CHECK(story.events[1].kind == Kind::Moved);
  CHECK(story.events[1].reason.find("80 mm (limit 30 mm)") != std::string::npos);
  CHECK(story.tracker.state() == State::Touching);
  story.show(hand_at(elsewhere), 400ms);
  REQUIRE(story.events.size() == 3);
  CHECK(story.events[2].kind == Kind::Grasped);
  CHECK((story.tracker.grasp()->position - elsewhere).norm() < 1e-9);
}

TEST_CASE("a hand that slides slowly does not creep away with the mean unnoticed", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 1s);
  for (int i = 1; i <= 60; ++i) story.show(hand_at(kLeftEnd + Vec3(0.0, 0.002 * i, 0.0)), kFrame);
  REQUIRE(story.events.size() >= 2);
  CHECK(story.events[1].kind == Kind::Moved);
}

TEST_CASE("one frame that sees the hand elsewhere does not move the grasp", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 600ms)
      .show(hand_at(kLeftEnd + Vec3(0.1, 0, 0)), kFrame)
      .show(hand_at(kLeftEnd), 300ms);
  CHECK(story.events.size() == 1);
  CHECK(story.tracker.state() == State::Holding);
  CHECK((story.tracker.grasp()->position - kLeftEnd).norm() < 1e-9);
}

TEST_CASE(
    "some frames in a row that see it elsewhere do not either; a hand that stays there rests from the first",
    "[partner][tracker]") {
  Story story;
  const Vec3 elsewhere = kLeftEnd + Vec3(0.1, 0, 0);
  story.show(hand_at(kLeftEnd), 600ms);
  for (int i = 0; i < 5; ++i) story.show(hand_at(elsewhere), 4 * kFrame).show(hand_at(kLeftEnd), 2 * kFrame);
  CHECK(story.events.size() == 1);
  CHECK((story.tracker.grasp()->position - kLeftEnd).norm() < 1e-9);
  const hal::Timestamp left = story.now;
  story.show(hand_at(elsewhere), 600ms);
  REQUIRE(story.events.size() == 3);
  CHECK(story.events[1].kind == Kind::Moved);
  CHECK(story.events[2].kind == Kind::Grasped);
  CHECK(story.tracker.since() == left);
}

TEST_CASE("a hand that looks like a leg from frame to frame holds on; a leg in its place does not",
          "[partner][tracker]") {
  PartnerObservation leg = nobody();
  leg.kind = PartnerKind::Near;
  if (GENERATE(true, false))
    leg.legs = {kLeftEnd + Vec3(0.01, 0, 0)};
  else
    leg.nearest_m = 0.04;  // of a hand behind an edge too little touches
  Story story;
  story.show(leg, 1s);
  CHECK(story.tracker.state() == State::Away);
  story.show(hand_at(kLeftEnd), 600ms);
  for (int i = 0; i < 10; ++i) story.show(leg, 10 * kFrame).show(hand_at(kLeftEnd), kFrame);
  CHECK(story.events.size() == 1);
  CHECK(story.tracker.state() == State::Holding);
  const hal::Timestamp last = story.now - kFrame;
  story.show(leg, 2s);
  REQUIRE(story.events.size() == 2);
  CHECK(story.events[1].kind == Kind::LetGo);
  CHECK(hal::seconds(story.events[1].at - last) > 0.6);
  CHECK(hal::seconds(story.events[1].at - last) < 0.6 + 0.15 + 2 * 0.034);
}

TEST_CASE("an uncertain sighting needs more than three centimetres to be a movement", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd, 0.03), 600ms).show(hand_at(kLeftEnd + Vec3(0.05, 0, 0), 0.03), 300ms);
  REQUIRE(story.events.size() == 1);
  CHECK(story.events[0].kind == Kind::Grasped);
}

TEST_CASE("a hand that never rests is never a grasp", "[partner][tracker]") {
  Story story;
  for (int i = 0; i < 60; ++i) story.show(hand_at(kLeftEnd + Vec3(0.02 * i, 0, 0)), kFrame);
  CHECK(story.events.empty());
}

TEST_CASE("resting frames sharpen the position, but not beyond what they share", "[partner][tracker]") {
  Story story;
  const double one = 0.006 * 0.006;
  for (int i = 0; i < 100; ++i) {
    story.show(hand_at(kLeftEnd + Vec3(i % 2 == 0 ? 0.004 : -0.004, 0, 0)), kFrame);
  }
  const auto grasp = story.tracker.grasp();
  REQUIRE(grasp);
  CHECK((grasp->position - kLeftEnd).norm() < 0.0005);
  CHECK(grasp->covariance(0, 0) < 0.7 * one);
  CHECK(grasp->covariance(0, 0) > 0.5 * one);
}

TEST_CASE("a camera that fell silent does not keep a grasp alive", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 600ms);
  CHECK_FALSE(story.tracker.tick(story.now + 50ms));
  const auto event = story.tracker.tick(story.now + 500ms);
  REQUIRE(event);
  CHECK(event->kind == Kind::LetGo);
  CHECK_FALSE(story.tracker.tick(story.now + 600ms));
}

TEST_CASE("a contact after a gap in the frames has to rest again", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 600ms);
  story.now += 2s;
  story.show(hand_at(kLeftEnd), 2 * kFrame);
  REQUIRE(story.events.size() == 2);
  CHECK(story.events[1].kind == Kind::LetGo);
  CHECK(story.tracker.state() == State::Touching);
}

TEST_CASE("a frame that is not newer than the last one changes nothing", "[partner][tracker]") {
  PartnerTracker tracker{TrackerConfig{}};
  CHECK_FALSE(tracker.update(1s, hand_at(kLeftEnd)));
  for (int i = 0; i < 50; ++i) CHECK_FALSE(tracker.update(1s, hand_at(kLeftEnd)));
  CHECK_FALSE(tracker.update(500ms, nobody()));
  CHECK(tracker.state() == State::Touching);
}

TEST_CASE("a grasp that his body hides stays one, less certain, until the place is seen without him",
          "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 500ms);
  REQUIRE(story.tracker.state() == State::Holding);
  const double before = story.tracker.grasp()->covariance.trace();
  story.hide(5s);
  CHECK(story.tracker.state() == State::Holding);
  CHECK(story.tracker.is_hidden());
  CHECK((story.tracker.grasp()->position - kLeftEnd).norm() < 1e-9);
  CHECK(story.tracker.grasp()->covariance.trace() > before + 2.9 * 0.03 * 0.03);
  story.show(nobody(), 300ms);
  REQUIRE(story.events.size() == 2);
  CHECK(story.events[1].kind == Kind::LetGo);
  CHECK_FALSE(story.tracker.is_hidden());
}

TEST_CASE("a hand that is seen again where it was is no new grasp", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 500ms).hide(2s).show(hand_at(kLeftEnd), 200ms);
  CHECK(story.events.size() == 1);
  CHECK_FALSE(story.tracker.is_hidden());
}

TEST_CASE("a touch that is hidden before it was a grasp becomes one after a longer dwell",
          "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 100ms).hide(400ms);
  CHECK(story.tracker.state() == State::Touching);
  story.hide(200ms);
  REQUIRE(story.events.size() == 1);
  CHECK(story.events[0].kind == Kind::Grasped);
}

TEST_CASE("a grasp is not believed for ever without being seen", "[partner][tracker]") {
  Story story;
  story.show(hand_at(kLeftEnd), 500ms).hide(61s);
  REQUIRE(story.events.size() == 2);
  CHECK(story.events[1].kind == Kind::LetGo);
  CHECK(story.events[1].reason.find("hidden") != std::string::npos);
}

TEST_CASE("nobody who was not seen is hidden", "[partner][tracker]") {
  Story story;
  story.hide(5s);
  CHECK(story.tracker.state() == State::Away);
  CHECK_FALSE(story.tracker.is_hidden());
}

PartnerGrasp estimate(const Vec3& position) {
  return {position, Eigen::Matrix3d::Identity() * 0.08 * 0.08, 40};
}

TEST_CASE("a grasp that nobody saw holds as long as his body hides the place", "[partner][tracker][hidden]") {
  Story story;
  story.show(nobody(), 1s);
  const auto held = story.tracker.hold_unseen(story.now, estimate(kLeftEnd), "the object rose");
  REQUIRE(held);
  CHECK(held->kind == Kind::Grasped);
  CHECK(story.tracker.is_unseen());
  CHECK(story.tracker.is_hidden());
  REQUIRE(story.tracker.grasp());
  CHECK(story.tracker.grasp()->position.isApprox(kLeftEnd));
  CHECK(std::sqrt(story.tracker.grasp()->covariance(0, 0)) > 0.08);  // and what he may have slid since
  CHECK_FALSE(story.tracker.hold_unseen(story.now, estimate(kLeftEnd), "again"));
  story.now += kFrame;
  story.hide(5s);
  CHECK(story.events.empty());
  CHECK(story.tracker.state() == State::Holding);
  story.show(nobody(), 1s);  // he stepped aside, and no hand is there
  REQUIRE(story.events.size() == 1);
  CHECK(story.events[0].kind == Kind::LetGo);
  CHECK_FALSE(story.tracker.is_unseen());
}

TEST_CASE("a hand that comes into view where it was thought to be replaces the estimate",
          "[partner][tracker][hidden]") {
  Story story;
  story.tracker.hold_unseen(story.now, estimate(kLeftEnd), "the object rose");
  story.now += kFrame;
  const Vec3 seen = kLeftEnd + Vec3(0.06, 0.0, 0.0);
  story.show(hand_at(seen), 500ms);
  CHECK(story.events.empty());
  CHECK(story.tracker.state() == State::Holding);
  CHECK_FALSE(story.tracker.is_unseen());
  CHECK(story.tracker.grasp()->position.isApprox(seen));
  CHECK(std::sqrt(story.tracker.grasp()->covariance(0, 0)) < 0.01);
}

TEST_CASE("a hand that is seen far from the estimate has moved", "[partner][tracker][hidden]") {
  Story story;
  story.tracker.hold_unseen(story.now, estimate(kLeftEnd), "the object rose");
  story.now += kFrame;
  story.show(hand_at(kLeftEnd + Vec3(0.5, 0.0, 0.0)), 500ms);
  REQUIRE(!story.events.empty());
  CHECK(story.events[0].kind == Kind::Moved);
  CHECK_FALSE(story.tracker.is_unseen());
}

}  // namespace
}  // namespace colift::perception
