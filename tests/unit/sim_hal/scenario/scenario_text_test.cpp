// A scenario that is written as a file and read again is the same scenario.

#include <catch2/catch.hpp>

#include <filesystem>
#include <string>

#include "sim_hal/scenario/random_scenario.hpp"
#include "sim_hal/scenario/scenario_text.hpp"

using namespace colift;
using namespace colift::sim_hal;

namespace {

Scenario read_again(const Scenario& s) {
  auto again = parse_scenario(yaml_of(s), s.name + ".yaml");
  if (!again) FAIL(again.error().text() << "\n" << yaml_of(s));
  return *again;
}

// numbers that have no short decimal form
constexpr double kThird = 1.0 / 3.0;

Scenario everything() {
  Scenario s;
  s.name = "everything";
  s.object.kind = "bodies";
  s.object.cog_offset = {0.01, -0.02 * kThird, 0.0};
  s.object.xyz = {0.9 * kThird, 0.1, 0.0};
  s.object.yaw_deg = -31.0 * kThird;
  s.object.friction = 0.5 * kThird;
  s.object.parts = {{"box", {1.0, 0.5, 0.2}, {0, 0, 0.1}, {0, 0, 10.0 * kThird}, 2.0 * kThird},
                    {"cylinder", {0.05, 0.5}, {0, 0, 0.45}, {1, 2, 3}, 1.25}};
  s.object.mass = 2.0 * kThird + 1.25;
  s.clutter = {
      {"cylinder", {0.1, 0.4}, {1.9, 1.0, 0.0}, 12.0, {{1.0, {1, 2, 0}, 0.3}, {2.0, {1, 1, 0}, kThird}}}};
  s.camera = {{2.0, 1.0, 1.5}, {0.7, kThird, 0.2}, "none"};
  s.more_cameras = {{{0.1, 2.0, 1.4}, {0.7, 0.0, 0.3}, "kinect"}};
  s.partner = {"leader", {-0.5, kThird, 0.6}, 1.5, true, {}};
  s.partner.events = {{2.0, "let-go", {}},
                      {0.7, "move", Vec3(0.1, 0.2, 0.3), "lift"},
                      {3.0, "stumble", {}, "", 60.0, 0.3, Vec3(0, 1, kThird)},
                      {4.0, "sway", {}, "hold", 80.0, 1.5, {}, 0.03}};
  s.task = {"lift", 0.04, 1.0 * kThird};
  ScenarioPerson walks;
  walks.enters_s = 1.25;
  walks.path = {{2.0, kThird}, {1.0, 0.5}};
  walks.leaves_s = 9.0;
  ScenarioPerson reaches = walks;
  reaches.in_state = "close";
  reaches.action = "reach";
  reaches.reach_to = "point";
  reaches.point = {0.4, 0.5, kThird};
  reaches.with_foot = true;
  ScenarioPerson foot = reaches;
  foot.reach_to = "under-object";
  foot.with_foot = false;
  s.people = {walks, reaches, foot};
  DeviceFaultEvent push{0.5, "arm", "push", 0.2, 40.0};
  push.direction = {0, kThird, 1};
  push.link = 3;
  push.in_state = "lift";
  DeviceFaultEvent hot{3.0, "hand", "hot", 1.0, 75.0};
  hot.puck = "F2";
  s.faults = {push, hot, {4.0, "camera2", "freeze", 0.4}};
  return s;
}

}  // namespace

TEST_CASE("a scenario with everything in it comes back, value by value") {
  const Scenario s = everything(), again = read_again(s);
  CHECK(again.name == s.name);
  CHECK(again.object.kind == s.object.kind);
  CHECK(again.object.mass == s.object.mass);
  CHECK(again.object.cog_offset == s.object.cog_offset);
  CHECK(again.object.xyz == s.object.xyz);
  CHECK(again.object.yaw_deg == s.object.yaw_deg);
  CHECK(again.object.friction == s.object.friction);
  REQUIRE(again.object.parts.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const ScenarioPart &a = again.object.parts[i], &b = s.object.parts[i];
    CHECK((a.shape == b.shape && a.size == b.size && a.xyz == b.xyz && a.rpy_deg == b.rpy_deg &&
           a.mass == b.mass));
  }
  REQUIRE(again.clutter.size() == 1);
  const ScenarioClutter &c = again.clutter[0], &d = s.clutter[0];
  CHECK((c.shape == d.shape && c.size == d.size && c.xyz == d.xyz && c.yaw_deg == d.yaw_deg));
  REQUIRE(c.moves.size() == 2);
  for (std::size_t i = 0; i < 2; ++i)
    CHECK((c.moves[i].at_s == d.moves[i].at_s && c.moves[i].to == d.moves[i].to &&
           c.moves[i].speed == d.moves[i].speed));
  REQUIRE(again.more_cameras.size() == 1);
  for (const auto& [a, b] :
       {std::pair{again.camera, s.camera}, std::pair{again.more_cameras[0], s.more_cameras[0]}})
    CHECK((a.xyz == b.xyz && a.look_at == b.look_at && a.noise == b.noise));
  CHECK((again.partner.kind == "leader" && again.partner.grasp == s.partner.grasp && again.partner.obliging));
  CHECK(again.partner.arrives_s == 1.5);
  REQUIRE(again.partner.events.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) {
    const PartnerScriptEvent &a = again.partner.events[i], &b = s.partner.events[i];
    INFO("event " << i);
    CHECK((a.at_s == b.at_s && a.action == b.action && a.to == b.to && a.in_state == b.in_state));
    CHECK(a.direction == b.direction);
    if (b.action == "stumble") CHECK((a.force_n == b.force_n && a.for_s == b.for_s));
    if (b.action == "sway") CHECK((a.by_m == b.by_m && a.for_s == b.for_s));
  }
  CHECK((again.task.height == s.task.height && again.task.hold_s == s.task.hold_s));
  REQUIRE(again.people.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const ScenarioPerson &a = again.people[i], &b = s.people[i];
    INFO("person " << i);
    CHECK((a.enters_s == b.enters_s && a.in_state == b.in_state && a.path == b.path && a.speed == b.speed));
    CHECK((a.action == b.action && a.reach_to == b.reach_to && a.with_foot == b.with_foot));
    if (b.reach_to == "point") CHECK(a.point == b.point);
    CHECK((a.hand_speed == b.hand_speed && a.leaves_s == b.leaves_s));
  }
  REQUIRE(again.faults.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    const DeviceFaultEvent &a = again.faults[i], &b = s.faults[i];
    INFO("fault " << i);
    CHECK((a.at_s == b.at_s && a.device == b.device && a.action == b.action && a.for_s == b.for_s));
    CHECK((a.value == b.value && a.puck == b.puck && a.direction == b.direction && a.link == b.link));
    CHECK(a.in_state == b.in_state);
  }
}

TEST_CASE("every shipped scenario, and drawn ones, are written as they were read") {
  int files = 0;
  for (const auto& file : std::filesystem::directory_iterator(COLIFT_SOURCE_DIR "/config/scenario")) {
    if (file.path().extension() != ".yaml") continue;
    INFO(file.path());
    const auto s = load_scenario(file.path());
    REQUIRE(s);
    CHECK(yaml_of(read_again(*s)) == yaml_of(*s));
    ++files;
  }
  CHECK(files > 20);
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Scenario s = random_scenario(seed % 2 == 0 ? RandomKind::Table : RandomKind::Box, seed);
    CHECK(yaml_of(read_again(s)) == yaml_of(s));
  }
}
