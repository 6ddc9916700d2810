#include "sim_hal/scenario/scenario.hpp"

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

#include "sim_hal/scenario/object_parts.hpp"

using namespace colift::sim_hal;
using colift::hal::ErrorCode;

namespace {

const std::string kWhole = R"(schema: colift.scenario/1
object:
  kind: table
  size: [0.80, 0.50, 0.45]
  mass: 4.5
  cog_offset: [0.1, -0.05, 0.01]
  pose: {xyz: [0.75, 0.1, 0.2], yaw_deg: 20}
  friction: 0.6
  parts: []
clutter: [{shape: box, size: [0.1, 0.2, 0.3], xyz: [1, 2, 0.1], yaw_deg: 30}, {shape: cylinder, size: [0.1, 0.4], xyz: [0, 2, 0]}]
camera: {xyz: [2.2, -0.9, 1.4], look_at: [0.7, 0, 0.3], noise: none}
partner:
  kind: leader
  grasp: [-0.40, 0.0, 0.43]
  arrives_s: 2.5
  events: [{at_s: 5, do: let-go}, {at_s: 7, do: move, to: [0.4, 0, 0.43]}]
task: {kind: lift, height: 0.07, hold_s: 1.5}
faults: [{at_s: 4.0, device: camera, do: freeze, for_s: 0.25}]
)";

/// A scenario of which one piece of text is replaced; an empty `from` appends.
std::string with(const std::string& from, const std::string& to) {
  std::string text = kWhole;
  if (from.empty()) return text + to;
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

std::string refusal(const std::string& yaml) {
  const auto scenario = parse_scenario(yaml, "s.yaml");
  if (scenario) return "accepted";
  CHECK(scenario.error().code == ErrorCode::BadConfig);
  const std::string text = scenario.error().text();
  CHECK(text.find('\n') == std::string::npos);
  return text;
}

using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

}  // namespace

TEST_CASE("a whole scenario is read entry by entry", "[scenario]") {
  const auto s = parse_scenario(kWhole, "some/folder/my table.yaml");
  REQUIRE(s);
  CHECK(s->name == "my table");
  CHECK(s->object.kind == "table");
  CHECK(s->object.size == std::vector<double>{0.80, 0.50, 0.45});
  CHECK(s->object.mass == 4.5);
  CHECK(s->object.cog_offset == Vec3(0.1, -0.05, 0.01));
  CHECK(s->object.xyz == Vec3(0.75, 0.1, 0.2));
  CHECK(s->object.yaw_deg == 20);
  CHECK(s->object.friction == 0.6);
  REQUIRE(s->clutter.size() == 2);
  CHECK(s->clutter[0].size == std::vector<double>{0.1, 0.2, 0.3});
  CHECK(s->clutter[0].xyz == Vec3(1, 2, 0.1));
  CHECK(s->clutter[0].yaw_deg == 30);
  CHECK(s->clutter[1].shape == "cylinder");
  CHECK(s->camera.xyz == Vec3(2.2, -0.9, 1.4));
  CHECK(s->camera.look_at == Vec3(0.7, 0, 0.3));
  CHECK(s->camera.noise == "none");
  CHECK(s->partner.kind == "leader");
  CHECK(s->partner.grasp == Vec3(-0.40, 0.0, 0.43));
  CHECK(s->partner.arrives_s == 2.5);
  REQUIRE(s->partner.events.size() == 2);
  CHECK(s->partner.events[0].action == "let-go");
  CHECK_FALSE(s->partner.events[0].to);
  CHECK(s->partner.events[1].at_s == 7);
  CHECK(s->partner.events[1].to == Vec3(0.4, 0, 0.43));
  CHECK(s->task.height == 0.07);
  CHECK(s->task.hold_s == 1.5);
  REQUIRE(s->faults.size() == 1);
  CHECK(s->faults[0].device == "camera");
  CHECK(s->faults[0].action == "freeze");
  CHECK(s->faults[0].for_s == 0.25);
}

TEST_CASE("what a scenario leaves out has its default", "[scenario]") {
  const auto s = parse_scenario(
      "schema: colift.scenario/1\nobject: {kind: box, size: [0.5, 0.3, 0.3]}\npartner: {grasp: [0.2, 0, "
      "0.3]}\n",
      "s.yaml");
  REQUIRE(s);
  CHECK(s->object.mass == 4.0);
  CHECK(s->object.friction == 0.7);
  CHECK(s->camera.noise == "kinect");
  CHECK(s->partner.kind == "compliant");
  CHECK(s->task.height == 0.05);
  CHECK(s->clutter.empty());
  CHECK(s->faults.empty());
}

TEST_CASE("a scenario without a partner needs no grasp of his", "[scenario]") {
  CHECK(parse_scenario(
      "schema: colift.scenario/1\nobject: {kind: box, size: [0.5, 0.3, 0.3]}\npartner: {kind: none}\n", "s"));
  CHECK_THAT(refusal("schema: colift.scenario/1\nobject: {kind: box, size: [0.5, 0.3, 0.3]}\n"),
             Contains("partner.grasp is missing"));
}

TEST_CASE("every bad entry is refused at its place with what was found and what was expected", "[scenario]") {
  struct Bad {
    std::string from, to, place, found, expected;
  };
  const Bad bad[] = {
      {"  mass: 4.5", "  mas: 4.5", "s.yaml:5:3", "unknown key \"object.mas\"",
       "did you mean \"object.mass\"?"},
      {"clutter:", "cluter:", "s.yaml:10:1", "unknown key \"cluter\"", "\"clutter\""},
      {"yaw_deg: 20", "yaw: 20", "s.yaml:7:33", "object.pose.yaw", "\"object.pose.yaw_deg\""},
      {"do: let-go", "dos: let-go", "s.yaml:16:22", "partner.events[0].dos", "\"partner.events[0].do\""},
      {"kind: table", "kind: sofa", "s.yaml:3:9", "sofa", "one of table, box, cylinder, chair, bodies"},
      {"noise: none", "noise: snow", "s.yaml:11:64", "snow", "one of kinect, none"},
      {"do: let-go", "do: sneeze", "s.yaml:16:26", "sneeze", "one of let-go, move"},
      {"device: camera", "device: foot", "s.yaml:18:30", "foot", "one of camera, arm, hand"},
      {"do: freeze", "do: burn", "s.yaml:18:42", "burn", "one of freeze, drop, unplug"},
      {"device: camera, do: freeze", "device: arm, do: blind", "s.yaml:18:", "blind", "only a camera"},
      {"kind: leader", "kind: dog", "s.yaml:13:9", "dog", "compliant, leader, support, none"},
      {"kind: lift", "kind: throw", "s.yaml:17:14", "throw", "one of lift"},
      {"colift.scenario/1", "colift.scenario/2", "s.yaml:1:9", "colift.scenario/2", "colift.scenario/1"},
      {"schema: colift.scenario/1\n", "", "s.yaml:1:1", "schema is missing", "colift.scenario/1"},
      {"  kind: table\n", "", "s.yaml:3:", "object.kind is missing", "one of table, box"},
      {"mass: 4.5", "mass: heavy", "s.yaml:5:9", "\"heavy\"", "a number"},
      {"mass: 4.5", "mass: -1", "s.yaml:5:9", "-1", "from 0.001 to 100"},
      {"mass: 4.5", "mass: 0", "s.yaml:5:9", "is 0", "0.001 to 100"},
      {"mass: 4.5", "mass: 101", "s.yaml:5:9", "101", "to 100"},
      {"mass: 4.5", "mass: .nan", "s.yaml:5:9", ".nan", "a number"},
      {"mass: 4.5", "mass: .inf", "s.yaml:5:9", ".inf", "finite"},
      {"mass: 4.5", "mass: 1e999", "s.yaml:5:9", "1e999", "beyond what a computer's number holds"},
      {"mass: 4.5", "mass: [4]", "s.yaml:5:9", "a list of 1", "a number"},
      {"friction: 0.6", "friction: 0", "s.yaml:8:13", "is 0", "greater than 0 and at most 3"},
      {"friction: 0.6", "friction: 3.5", "s.yaml:8:13", "3.5", "at most 3"},
      {"size: [0.80, 0.50, 0.45]", "size: [0.80, 0.50]", "s.yaml:4:9", "has 2 numbers", "a table expects 3"},
      {"size: [0.80, 0.50, 0.45]", "size: [0.80, 0, 0.45]", "s.yaml:4:16", "is 0", "0.001 to 5"},
      {"size: [0.80, 0.50, 0.45]", "size: [0.80, 0.5, 6]", "s.yaml:4:21", "is 6", "to 5"},
      {"size: [0.80, 0.50, 0.45]", "size: [0.80, 0.5, .nan]", "s.yaml:4:21", ".nan", "number 3"},
      {"size: [0.80, 0.50, 0.45]", "size: 0.8", "s.yaml:4:9", "\"0.8\"", "a list of numbers"},
      {"size: [0.80, 0.50, 0.45]", "size: [0.10, 0.5, 0.4]", "s.yaml:4:9", "0.1 x 0.5 x 0.4", "at least"},
      {"size: [0.1, 0.2, 0.3]", "size: [0.1, 0.2]", "s.yaml:10:30", "has 2 numbers", "a box expects 3"},
      {"size: [0.1, 0.4]", "size: [0.1, 0.4, 1]", "s.yaml:10:", "has 3 numbers", "radius and length"},
      {"xyz: [0.75, 0.1, 0.2]", "xyz: [0.75, 0.1]", "s.yaml:7:15", "a list of 2", "a list of 3 numbers"},
      {"xyz: [0.75, 0.1, 0.2]", "xyz: [0.75, 0.1, 1e6]", "s.yaml:7:27", "1e+06", "-20 to 20"},
      {"pose: {xyz: [0.75, 0.1, 0.2], yaw_deg: 20}", "pose: 3", "s.yaml:7:9", "\"3\"", "a group of settings"},
      {"cog_offset: [0.1, -0.05, 0.01]", "cog_offset: [0.5, 0, 0]", "s.yaml:6:15", "0.500",
       "outside of the object"},
      {"parts: []", "parts: [{shape: box, size: [1, 1, 1], xyz: [0, 0, 0]}]", "s.yaml:9:10",
       "object.kind is table", "kind bodies"},
      {"at_s: 5,", "at_s: -5,", "s.yaml:16:19", "-5", "from 0 to"},
      {"at_s: 5, ", "", "s.yaml:16:12", "partner.events[0].at_s is missing", "a number"},
      {"arrives_s: 2.5", "arrives_s: .inf", "s.yaml:15:14", ".inf", "finite"},
      {", to: [0.4, 0, 0.43]", "", "s.yaml:16:", "partner.events[1].to is missing", "a list of 3 numbers"},
      {"do: let-go", "do: let-go, to: [0, 0, 0]", "s.yaml:16:38", "do: let-go", "belongs to do: move"},
      {"kind: leader", "kind: none", "s.yaml:16:", "partner.kind is none", "nobody"},
      {"height: 0.07", "height: 0.6", "s.yaml:17:28", "0.6", "greater than 0 and at most 0.5"},
      {"height: 0.07", "height: 0", "s.yaml:17:28", "is 0", "greater than 0"},
      {"for_s: 0.25", "for_s: -1", "s.yaml:18:57", "-1", "from 0 to"},
      {"look_at: [0.7, 0, 0.3]", "look_at: [2.2, -0.9, 1.4]", "s.yaml:11:42", "where the camera is",
       "5 cm away"},
      {"clutter: [", "clutter: 5 #", "s.yaml:10:10", "\"5\"", "a list of groups of settings"},
      {"  mass: 4.5", "  mass: 4.5\n  mass: 5", "s.yaml:6:3", "given twice", "line 5"},
      {"  mass: 4.5", "\tmass: 4.5", "s.yaml:5:", "no YAML", "tab"},
      {"kind: table", "kind: \xff", "s.yaml:3:9", "0xFF", "UTF-8"},
      {"kind: table", "kind: !!str table", "s.yaml:3:9", "tag", "plain values"},
      {"", "---\nschema: colift.scenario/1\n", "s.yaml:19:1", "a second document", "only one"},
      {"", "[", "s.yaml:", "no YAML", ""},
      {"", "x: &x [*x]\n", "s.yaml:19:8", "alias", "the value that it stands in"},
  };
  for (const Bad& b : bad) {
    CAPTURE(b.from, b.to);
    const std::string text = refusal(with(b.from, b.to));
    CHECK_THAT(text, StartsWith(b.place));
    CHECK_THAT(text, Contains(b.found));
    CHECK_THAT(text, Contains(b.expected));
  }
}

TEST_CASE("every field of a scenario refuses every wrong kind of value", "[scenario]") {
  // keys in the order of the text, each followed by its value up to the end of line or a comma outside
  // brackets
  const std::string wrong[] = {"\"quoted\"", "{a: 1}", "[[1]]", "", "~", "-.inf"};
  std::size_t refused = 0, tried = 0;
  for (std::size_t colon = kWhole.find(": "); colon != std::string::npos;
       colon = kWhole.find(": ", colon + 1)) {
    std::size_t end = colon + 2;
    for (int depth = 0; end < kWhole.size() && kWhole[end] != '\n'; ++end) {
      const char c = kWhole[end];
      if (c == '[' || c == '{') ++depth;
      if ((c == ']' || c == '}') && --depth < 0) break;
      if (c == ',' && depth == 0) break;
    }
    for (const std::string& value : wrong) {
      const std::string text = refusal(kWhole.substr(0, colon + 2) + value + kWhole.substr(end));
      ++tried;
      if (text == "accepted") continue;  // nothing given: the default holds
      ++refused;
      CHECK_THAT(text, StartsWith("s.yaml:"));
    }
  }
  CHECK(tried > 150);
  CHECK(refused > tried * 3 / 4);
}

TEST_CASE("cutting a scenario short at any byte never crashes", "[scenario]") {
  for (std::size_t n = 0; n < kWhole.size(); ++n) {
    const auto scenario = parse_scenario(kWhole.substr(0, n), "s.yaml");
    if (!scenario) CHECK(scenario.error().code == ErrorCode::BadConfig);
  }
}

TEST_CASE("an alias bomb is refused before it costs memory", "[scenario]") {
  std::string bomb = "a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 12; ++i) {
    const std::string before = fmt::format("*a{}", i - 1);
    bomb += fmt::format("a{0}: &a{0} [{1}, {1}, {1}, {1}, {1}, {1}, {1}, {1}, {1}, {1}]\n", i, before);
  }
  CHECK_THAT(refusal(bomb), StartsWith("s.yaml:1:1"));
  const std::string clutter = with("size: [0.1, 0.2, 0.3]", "size: &n [0.1, 0.2, 0.3]");
  CHECK(refusal(clutter) == "accepted");
}

TEST_CASE("files that are missing, empty, folders, huge or no text are refused", "[scenario]") {
  const auto folder = std::filesystem::temp_directory_path() / "colift_scenario_test";
  std::filesystem::create_directories(folder);
  const auto file = [&](const char* name, const std::string& text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return folder / name;
  };
  const auto text_of = [](const std::filesystem::path& path) {
    const auto s = load_scenario(path);
    REQUIRE_FALSE(s);
    CHECK(s.error().code == ErrorCode::BadConfig);
    CHECK_THAT(s.error().text(), StartsWith(path.string()));
    return s.error().detail;
  };
  CHECK_THAT(text_of(folder / "missing.yaml"), Contains("no such file"));
  CHECK_THAT(text_of(folder), Contains("directory"));
  CHECK_THAT(text_of(file("empty.yaml", "")), Contains("schema is missing"));
  CHECK_THAT(text_of(file("comment.yaml", "# nothing\n")), Contains("schema is missing"));
  CHECK_THAT(text_of(file("huge.yaml", kWhole + "#" + std::string(1 << 20, 'x'))), Contains("too large"));
  CHECK_THAT(text_of(file("binary.yaml", std::string("\x7f"
                                                     "ELF\0\1\2",
                                                     7))),
             Contains("UTF-8"));
  CHECK_THAT(text_of(file("list.yaml", "- 1\n- 2\n")), Contains("group of settings"));
  CHECK(load_scenario(file("good.yaml", kWhole)));
  std::filesystem::remove_all(folder);
}

TEST_CASE("the masses of bodies come from the parts, or are shared out by volume", "[scenario]") {
  const std::string head = "schema: colift.scenario/1\npartner: {kind: none}\nobject:\n  kind: bodies\n";
  const std::string two =
      "  parts:\n    - {shape: box, size: [0.2, 0.2, 0.1], xyz: [0, 0, 0.05]%s}\n"
      "    - {shape: box, size: [0.2, 0.2, 0.3], xyz: [0, 0, 0.25]%t}\n";
  const auto parts = [&](const std::string& first, const std::string& second) {
    std::string text = two;
    text.replace(text.find("%s"), 2, first);
    return text.replace(text.find("%t"), 2, second);
  };
  const auto given = parse_scenario(head + parts(", mass: 1.5", ", mass: 0.5"), "s.yaml");
  REQUIRE(given);
  CHECK(given->object.mass == Approx(2.0));
  CHECK(given->object.parts[0].mass == 1.5);
  const auto shared = parse_scenario(head + "  mass: 8\n" + parts("", ""), "s.yaml");
  REQUIRE(shared);
  CHECK(shared->object.parts[0].mass == Approx(2.0));
  CHECK(shared->object.parts[1].mass == Approx(6.0));

  CHECK_THAT(refusal(head + parts(", mass: 1.5", "")), Contains("1 of 2 parts have a mass"));
  CHECK_THAT(refusal(head + "  mass: 8\n" + parts(", mass: 1", ", mass: 1")), Contains("the parts weigh 2"));
  CHECK_THAT(refusal(head), Contains("at least one part"));
  CHECK_THAT(refusal(head + "  size: [1, 1, 1]\n" + parts("", "")), Contains("no meaning for kind bodies"));
}

TEST_CASE("a push has a force and a direction, and is on the arm", "[scenario]") {
  const std::string camera = "{at_s: 4.0, device: camera, do: freeze, for_s: 0.25}";
  const auto s = parse_scenario(
      with(camera, "{at_s: 9, device: arm, do: push, value: 150, direction: [0, 2, 0], link: 4, for_s: 1}"),
      "s");
  REQUIRE(s);
  CHECK(s->faults[0].value == 150.0);
  CHECK(s->faults[0].direction.y() == 2.0);
  CHECK(s->faults[0].link == 4);
  CHECK_THAT(refusal(with(camera, "{at_s: 9, device: hand, do: push, value: 150}")), Contains("device: arm"));
  CHECK_THAT(refusal(with(camera, "{at_s: 9, device: arm, do: push}")), Contains("a value above 0"));
  CHECK_THAT(refusal(with(camera, "{at_s: 9, device: arm, do: push, value: 9, direction: [0, 0, 0]}")),
             Contains("direction that is not zero"));
}

TEST_CASE("the built-in scenario is the shipped table", "[scenario]") {
  const Scenario built_in = built_in_scenario();
  const auto shipped = load_scenario(COLIFT_SOURCE_DIR "/config/scenario/table.yaml");
  REQUIRE(shipped);
  CHECK(built_in.name == "table");
  CHECK(built_in.object.size == shipped->object.size);
  CHECK(built_in.object.xyz == shipped->object.xyz);
  CHECK(built_in.partner.grasp == shipped->partner.grasp);
}

TEST_CASE("every shipped scenario can be read, and its partner holds the object's surface", "[scenario]") {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(COLIFT_SOURCE_DIR "/config/scenario")) {
    const auto s = load_scenario(entry.path());
    CAPTURE(entry.path().string(), (s ? "" : s.error().text()));
    REQUIRE(s);
    ++count;
    if (s->partner.kind == "none") continue;
    World world;
    const auto parts = object_parts(s->object);
    REQUIRE(parts);
    for (const auto& part : parts->parts) world.shapes.push_back(part.shape);
    CHECK(std::abs(distance(world, Label::Target, s->partner.grasp)) < 0.001);
    for (const auto& event : s->partner.events)
      if (event.to) CHECK(std::abs(distance(world, Label::Target, *event.to)) < 0.001);
    for (const Shape& clutter : clutter_shapes(*s)) {
      for (const auto& part : parts->parts)  // nothing stands in the object
        CHECK(distance(clutter, object_pose(s->object) * part.shape.X_WS.translation()) > 0.0);
    }
  }
  CHECK(count >= 18);
}
