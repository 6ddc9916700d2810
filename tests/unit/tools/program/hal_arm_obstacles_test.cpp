// Bring-up of the arm: what stands against command mode, what a start should know, and how a screen tells it.
#include <catch2/catch.hpp>
#include <functional>
#include <string>
#include <vector>

#include "tests/unit/tools/program/obstacle_of_kind.hpp"
#include "tools/bring_up/hal_arm_json.hpp"

namespace colift {
using namespace tools;
namespace {

/// What a healthy controller in monitor mode tells.
tools::ArmView healthy() {
  tools::ArmView v;
  v.status.session = hal::FriSession::Monitor;
  v.status.reason = hal::FriReason::NotAsked;
  v.status.state = v.m.state = hal::FriState::Monitor;
  v.status.quality = v.m.quality = hal::FriQuality::Perfect;
  v.status.control = v.m.control = hal::FriControl::JointImpedance;
  v.status.power = v.m.power = hal::kFriAllDrives;
  v.status.answer_rate = v.m.answer_rate = 1.0f;
  v.status.latency_s = v.m.latency_s = 0.0003f;
  v.status.period_s = 0.002;
  v.status.received = v.status.answered = 500;
  v.m.safety_limits = 1.0f;
  v.m.q_measured_rad = {0.1f, 0.7f, -0.2f, 1.4f, 0.1f, -0.9f, 0.3f};
  v.m.q_commanded_rad = v.m.q_measured_rad;
  v.m.temperature_c.fill(35.0f);
  v.m.krl.integer[0] = 10001;
  v.m.krl.integer[1] = 1;
  hal::FriMeasurement later = v.m;
  later.krl.integer[4] = 7;
  v.program.note(v.m, 0.0);
  v.program.note(later, 1.0);
  return v;
}

}  // namespace

TEST_CASE("a healthy controller has nothing against command mode", "[hal][arm]") {
  const auto found = obstacles(healthy(), hal::built_in_robot());
  INFO(obstacles_text(found));
  CHECK(found.empty());
}

TEST_CASE("each thing that stands against command mode is told with what to do", "[hal][arm]") {
  struct Case {
    const char* kind;
    std::function<void(tools::ArmView&)> spoil;
  };
  const std::vector<Case> cases{
      {"quality",
       [](auto& v) {
         v.status.quality = hal::FriQuality::Bad;
         v.status.answer_rate = 0.85f;
       }},
      {"quality",
       [](auto& v) {
         v.status.quality = hal::FriQuality::Unacceptable;
         v.status.latency_s = 0.0019f;
       }},
      {"drive-error", [](auto& v) { v.m.error = 0x04; }},
      {"drives",
       [](auto& v) {
         v.m.power = 0;  // and the program does not run any more, as after an emergency stop
         v.program = {};
       }},
      {"sender",
       [](auto& v) {
         v.status.doubt = hal::FriReason::SecondSender;
         v.status.rival = {0xC0A80063, 5555};
       }},
      {"sender", [](auto& v) { v.status.doubt = hal::FriReason::KrcNotNamed; }},
      {"drives", [](auto& v) { v.m.power = 0x7B; }},
      {"hot", [](auto& v) { v.m.temperature_c[2] = 90.0f; }},
      {"program", [](auto& v) { v.m.krl.integer[0] = 0; }},
      {"program", [](auto& v) { v.m.krl.integer[0] = 10002; }},
      {"program",
       [](auto& v) {
         v.program = {};
         v.program.note(v.m, 0.0);
         v.program.note(v.m, 1.0);
       }},
      {"control",
       [](auto& v) {
         v.config.script = "none";
         v.m.control = hal::FriControl::Position;
       }},
      {"pose", [](auto& v) { v.status.pose_mismatch_rad = 0.2; }},
      {"external-torque", [](auto& v) { v.m.tau_external_nm[1] = -31.0f; }},
      {"silence", [](auto& v) { v.status.session = hal::FriSession::Silent; }},
  };
  for (const Case& c : cases) {
    tools::ArmView v = healthy();
    c.spoil(v);
    const auto found = obstacles(v, hal::built_in_robot());
    INFO(c.kind << "\n" << obstacles_text(found));
    const auto* o = test::obstacle(found, c.kind);
    REQUIRE(o);
    CHECK(o->refuses);
    CHECK(o->what.size() > 10);
    CHECK(o->next.size() > 20);
  }
}

TEST_CASE("what a start should know is told with what to do, and does not refuse", "[hal][arm]") {
  tools::ArmView v = healthy();
  v.m.tau_external_nm[1] = 1.4f;
  v.status.torque_reversed = true;
  v.status.krc = {0x0A000001, 49938};
  v.status.drops[static_cast<std::size_t>(hal::FriDrop::Sender)] = 17;
  const auto found = obstacles(v, hal::built_in_robot());
  INFO(obstacles_text(found));
  for (const char* kind : {"unexplained-load", "torque-sign", "krc-address", "dropped"}) {
    CAPTURE(kind);
    REQUIRE(test::obstacle(found, kind));
    CHECK_FALSE(test::obstacle(found, kind)->refuses);
  }
  CHECK(test::obstacle(found, "unexplained-load")->next.find("hal arm load") != std::string::npos);
  CHECK(test::obstacle(found, "torque-sign")->what.find("should be on_environment") != std::string::npos);
  const auto& address = *test::obstacle(found, "krc-address");
  CHECK(address.what.find("10.0.0.1:49938") != std::string::npos);
  CHECK(address.what.find("17 datagrams of other senders") != std::string::npos);
  CHECK(address.next.find("krc: 10.0.0.1 ") != std::string::npos);
  CHECK(test::obstacle(found, "dropped")->next.find("17 came from another sender") != std::string::npos);
}

TEST_CASE("drives that are off while the program runs are idle brakes, which a start opens", "[hal][arm]") {
  tools::ArmView v = healthy();
  v.m.power = 0;
  const auto found = obstacles(v, hal::built_in_robot());
  REQUIRE(test::obstacle(found, "idle-brakes"));
  CHECK_FALSE(test::obstacle(found, "idle-brakes")->refuses);
  CHECK_FALSE(test::obstacle(found, "drives"));
}

TEST_CASE("an arm that stands straight, or near a limit, is worth a word and no refusal", "[hal][arm]") {
  tools::ArmView v = healthy();
  v.m.q_measured_rad = {2.96f, 0.02f, 0, 0.05f, 0, 0.5f, 0};
  const auto found = obstacles(v, hal::built_in_robot());
  REQUIRE(test::obstacle(found, "straight"));
  CHECK_FALSE(test::obstacle(found, "straight")->refuses);
  REQUIRE(test::obstacle(found, "joint-limit"));
  CHECK_FALSE(test::obstacle(found, "joint-limit")->refuses);
}

TEST_CASE("answer times fall into octaves, and none is lost", "[hal][arm]") {
  hal::AnswerTimes times;
  for (int us = 1; us <= 3000; us += 7) times.add(std::chrono::microseconds(us));
  const auto a = tools::summary_of(times);
  std::uint64_t sum = 0;
  for (const auto& bar : a.bars) sum += bar.count;
  CHECK(sum == a.count);
  CHECK(a.worst_us == 2997);
  CHECK(a.bars.back().up_to_us >= 2997);
  CHECK(a.bars.back().count > 0);
}

TEST_CASE("the document of a screen names its schema and every joint", "[hal][arm]") {
  const std::string text = arm_document("state", healthy(), hal::built_in_robot(), {}, {});
  CHECK(text.rfind("{\"schema\":\"colift.hal.arm/1\"", 0) == 0);
  for (const char* key :
       {"\"A1\"", "\"A7\"", "\"E1\"", "\"ready\":true", "\"tcp_wrench\"", "\"answer_rate\""})
    CHECK(text.find(key) != std::string::npos);
}

}  // namespace colift
