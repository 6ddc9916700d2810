#include <catch2/catch.hpp>
#include <string>

#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/scenario/scenario.hpp"

using namespace colift::sim_hal;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

const std::string kWhole = R"(schema: colift.scenario/1
object: {kind: box, size: [0.5, 0.3, 0.3]}
partner: {kind: none}
people:
  - {enters_s: 4.0, path: [[0.5, -2.5], [0.5, 0.1]], speed: 1.6, do: reach, reach_to: under-object, leaves_s: 9}
  - {path: [[1, 2]], do: reach, reach_to: [0.5, 0.1, 0.9], hand_speed: 0.5, with: hand}
  - {path: [[1, 2]], do: crouch}
clutter: [{shape: box, size: [1, 1, 1], xyz: [3, 0, 0], moves: [{at_s: 1, to: [3, 2, 0]}, {at_s: 2, to: [0, 0, 0], speed: 1}]}]
)";

std::string refusal(const std::string& from, const std::string& to) {
  std::string text = kWhole;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  const auto scenario = parse_scenario(text.replace(at, from.size(), to), "s.yaml");
  return scenario ? "accepted" : scenario.error().text();
}

}  // namespace

TEST_CASE("people and moves of clutter are read entry by entry", "[scenario]") {
  const auto s = parse_scenario(kWhole, "s.yaml");
  INFO((s ? "" : s.error().text()));
  REQUIRE(s);
  REQUIRE(s->people.size() == 3);
  const ScenarioPerson& first = s->people[0];
  CHECK(first.enters_s == 4.0);
  REQUIRE(first.path.size() == 2);
  CHECK(first.path[1] == Eigen::Vector2d(0.5, 0.1));
  CHECK(first.speed == 1.6);
  CHECK(first.action == "reach");
  CHECK(first.reach_to == "under-object");
  CHECK(first.with_foot);
  CHECK(first.leaves_s == 9.0);
  CHECK(s->people[1].reach_to == "point");
  CHECK(s->people[1].point == Vec3(0.5, 0.1, 0.9));
  CHECK_FALSE(s->people[1].with_foot);
  CHECK(s->people[2].action == "crouch");
  REQUIRE(s->clutter[0].moves.size() == 2);
  CHECK(s->clutter[0].moves[0].speed == 0.5);
}

TEST_CASE("a bad entry about people is refused at its place", "[scenario]") {
  struct Bad {
    std::string from, to, place, found;
  };
  const Bad bad[] = {
      {"[[0.5, -2.5], [0.5, 0.1]]", "[[0.5, -2.5], [0.5]]", "s.yaml:5:41", "a list of 1"},
      {"[[0.5, -2.5], [0.5, 0.1]]", "[0.5, -2.5]", "s.yaml:5:28", "expects a point of the floor"},
      {"[[0.5, -2.5], [0.5, 0.1]]", "[[0.5, 99], [0.5, 0.1]]", "s.yaml:5:34", "99"},
      {"[[0.5, -2.5], [0.5, 0.1]]", "[]", "s.yaml:5:", "0 points"},
      {"path: [[0.5, -2.5], [0.5, 0.1]], ", "", "s.yaml:5:", "people[0].path is missing"},
      {"speed: 1.6", "speed: 16", "s.yaml:5:61", "16"},
      {"speed: 1.6", "sped: 1.6", "s.yaml:5:54", "people[0].speed"},
      {"do: crouch", "do: dance", "s.yaml:7:26", "one of walk, stand, crouch, reach, sit"},
      {"do: crouch", "do: crouch, reach_to: object", "s.yaml:7:", "belongs to do: reach"},
      {", reach_to: under-object", "", "s.yaml:5:", "reach_to is missing"},
      {"reach_to: under-object", "reach_to: point", "s.yaml:5:", "belong together"},
      {"[0.5, 0.1, 0.9]", "[0.5, 0.1]", "s.yaml:6:", "a list of 2"},
      {"leaves_s: 9", "leaves_s: 3", "s.yaml:5:", "at least enters_s"},
      {"with: hand", "with: head", "s.yaml:6:", "one of"},
      {"at_s: 2", "at_s: 0.5", "s.yaml:8:", "order of time"},
  };
  for (const Bad& b : bad) {
    CAPTURE(b.from, b.to);
    const std::string text = refusal(b.from, b.to);
    CHECK_THAT(text, StartsWith(b.place));
    CHECK_THAT(text, Contains(b.found));
  }
}

TEST_CASE("a move of clutter begins where the piece is", "[scenario]") {
  const auto s = parse_scenario(kWhole, "s.yaml");
  REQUIRE(s);
  const ScenarioClutter& c = s->clutter[0];
  CHECK(clutter_xyz(c, 0.9) == Vec3(3, 0, 0));
  CHECK(clutter_xyz(c, 1.5).isApprox(Vec3(3, 0.25, 0)));
  const Vec3 turned(3, 0.5, 0);
  CHECK(clutter_xyz(c, 3.0).isApprox(turned - turned.normalized()));
  CHECK(clutter_xyz(c, 100.0) == Vec3(0, 0, 0));
}

TEST_CASE("aliases in a path cost no memory", "[scenario]") {
  std::string path = "[";
  for (int i = 0; i < 3000; ++i) path += "&p" + std::to_string(i) + " [1, 1],";
  const std::string text = refusal("[[1, 2]]", path + "]");
  CHECK_THAT(text, StartsWith("s.yaml:6:"));
}

TEST_CASE("events and people may count from a state of the task", "[scenario]") {
  const std::string head = "schema: colift.scenario/1\nobject: {kind: box, size: [0.5, 0.3, 0.3]}\n";
  const std::string partner = "partner: {grasp: [0.25, 0, 0.3], events: [";
  const auto s =
      parse_scenario(head + partner +
                         "{at: lift+0.7, do: stumble, force: 60, for_s: 0.3, direction: [0, 1, 0]}, "
                         "{at: hold, do: steps-aside}, {at_s: 3, do: second-hand, to: [0.25, 0.1, 0.3]}]}\n"
                         "people: [{enters: approach+0.5, path: [[2, 2]]}]\n",
                     "s.yaml");
  INFO((s ? "" : s.error().text()));
  REQUIRE(s);
  REQUIRE(s->partner.events.size() == 3);
  CHECK(s->partner.events[0].in_state == "lift");
  CHECK(s->partner.events[0].at_s == 0.7);
  CHECK(s->partner.events[0].force_n == 60.0);
  CHECK(s->partner.events[1].in_state == "hold");
  CHECK(s->partner.events[1].at_s == 0.0);
  CHECK(s->partner.events[2].in_state.empty());
  CHECK(s->people[0].in_state == "approach");
  CHECK(relative_time(*s) == "partner.events[0].at");
  const auto refused = [&](const std::string& event) {
    const auto bad = parse_scenario(head + partner + event + "]}\n", "s.yaml");
    return bad ? "accepted" : bad.error().text();
  };
  CHECK_THAT(refused("{at: lift-0.7, do: let-go}"), StartsWith("s.yaml:3:48") && Contains("lift+0.7"));
  CHECK_THAT(refused("{at: lifting+1, do: let-go}"), Contains("await-partner"));
  CHECK_THAT(refused("{at: lift+, do: let-go}"), Contains("a state of the task and seconds"));
  CHECK_THAT(refused("{at: lift+1e9, do: let-go}"), Contains("a state of the task and seconds"));
  CHECK_THAT(refused("{at: lift+1, at_s: 2, do: let-go}"), Contains("expected one of them"));
  CHECK_THAT(refused("{at_s: 1, do: let-go, force: 3}"), Contains("belongs to do: stumble"));
  CHECK_THAT(refused("{at_s: 1, do: stumble, by: 0.02}"), Contains("belongs to do: sway"));
  CHECK_THAT(refused("{at_s: 1, do: second-hand}"), Contains(".to is missing"));
}
