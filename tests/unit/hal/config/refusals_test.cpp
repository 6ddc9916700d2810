#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>

#include "example_config.hpp"
#include "hal/config/yaml_tree.hpp"

using namespace colift::hal;
using namespace colift::hal::example;

namespace {

std::string repeated(const std::string& text, int times) {
  std::string out;
  for (int i = 0; i < times; ++i) out += text;
  return out;
}

}  // namespace

TEST_CASE("an unknown key is refused with its place and the nearest known name", "[config]") {
  CHECK(refusal_of("ground:\n  max_tlit_deg: 3\n") ==
        "a.yaml:2:3: unknown key \"ground.max_tlit_deg\"; did you mean \"ground.max_tilt_deg\"?");
  CHECK(refusal_of("epsilon: 1\nmax_tilt_deg: 3\n") ==
        "a.yaml:2:1: unknown key \"max_tilt_deg\"; did you mean \"ground.max_tilt_deg\"?");
  CHECK(refusal_of("gruond: {}\n") == "a.yaml:1:1: unknown key \"gruond\"; did you mean \"ground\"?");
  CHECK(refusal_of("Epsilon: 1\n") == "a.yaml:1:1: unknown key \"Epsilon\"; did you mean \"epsilon\"?");
  CHECK(refusal_of("parts: [{size: [1, 1, 1]}]\n") ==
        "a.yaml:1:10: unknown key \"parts[0].size\"; did you mean \"parts[0].size_m\"?");
}

TEST_CASE("a key that resembles nothing is refused with the names known there", "[config]") {
  CHECK(refusal_of("ground:\n  refine:\n    quux_quux: 1\n") ==
        "a.yaml:3:5: unknown key \"ground.refine.quux_quux\"; known here: rounds, robust, up");
  CHECK_THAT(refusal_of("zzzzzzzz: 1\n"),
             Catch::Contains("known at the top: ") && Catch::Contains("epsilon"));
  CHECK_THAT(refusal_of("<<: {epsilon: 2}\n"), Catch::Contains("unknown key \"<<\""));
}

TEST_CASE("a dotted key in a file is refused with the way to write it", "[config]") {
  CHECK_THAT(refusal_of("ground.max_tilt_deg: 3\n"), Catch::Contains("written as nested groups"));
}

TEST_CASE("a value of the wrong type is refused with what was found and what was expected", "[config]") {
  CHECK(refusal_of("ground:\n  max_tilt_deg: steep\n") ==
        "a.yaml:2:17: ground.max_tilt_deg expects a number from 0 to 90, but found \"steep\"");
  CHECK(refusal_of("ground: {refine: {rounds: 3.5}}") ==
        "a.yaml:1:27: ground.refine.rounds expects a whole number from 0 to 100, but found \"3.5\"");
  CHECK(refusal_of("ground: {refine: {robust: yes}}") ==
        "a.yaml:1:27: ground.refine.robust expects true or false, but found \"yes\"");
  CHECK(refusal_of("epsilon: \"5\"") ==
        "a.yaml:1:10: epsilon expects a number greater than 0, but found the quoted text \"5\"");
  CHECK(refusal_of("epsilon:\nat: [1, 2, 3]\n") ==
        "a.yaml:1:1: epsilon expects a number greater than 0, but found no value");
  CHECK(refusal_of("method: thseis") ==
        "a.yaml:1:9: method expects one of fast, thesis, but found \"thseis\"");
  CHECK(refusal_of("title: ~") == "a.yaml:1:1: title expects a text, but found no value");
  for (const char* text :
       {"1,5", "1 2", "--5", "+-5", "0x10", "1e", "inf", "nan", "infinity", ".", "1.5m", "-x", "+"}) {
    INFO(text);
    CHECK_THAT(refusal_of(std::string("epsilon: ") + text), Catch::Contains("expects a number"));
  }
}

TEST_CASE("a group where a value belongs is refused, and the other way round", "[config]") {
  CHECK(refusal_of("epsilon: {a: 1}") ==
        "a.yaml:1:10: epsilon expects a number greater than 0, but found a group of settings");
  CHECK_THAT(refusal_of("ground: 5"), Catch::StartsWith("a.yaml:1:9: ground expects a group of settings (") &&
                                          Catch::EndsWith("found \"5\""));
  CHECK_THAT(refusal_of("ground: [1, 2]"), Catch::EndsWith("found a list of 2"));
  CHECK(refusal_of("epsilon: [1]") ==
        "a.yaml:1:10: epsilon expects a number greater than 0, but found a list of 1");
  CHECK_THAT(refusal_of("hello"),
             Catch::StartsWith("a.yaml:1:1: the configuration expects a group of settings"));
  CHECK_THAT(refusal_of("- 1\n- 2\n"), Catch::EndsWith("found a list of 2"));
  CHECK(refusal_of("parts: {}") ==
        "a.yaml:1:8: parts expects a list of groups of settings, but found a group of settings");
  CHECK_THAT(refusal_of("parts: [5]"), Catch::StartsWith("a.yaml:1:9: parts[0] expects a group of settings"));
}

TEST_CASE("a number out of its range is refused with the number and the range", "[config]") {
  CHECK(refusal_of("ground: {max_tilt_deg: 120}") ==
        "a.yaml:1:24: ground.max_tilt_deg is 120, but has to be a number from 0 to 90");
  CHECK(refusal_of("epsilon: 0") == "a.yaml:1:10: epsilon is 0, but has to be a number greater than 0");
  CHECK(refusal_of("share: 1.0000001") ==
        "a.yaml:1:8: share is 1.0000001, but has to be a number from 0 to 1");
  CHECK(refusal_of("weights: [1, 2,\n  -1]") ==
        "a.yaml:2:3: weights is -1, but has to be a number of at least 0 (number 3 of the list)");
  CHECK(refusal_of("parts: [{size_m: [1, 0, 1]}]") ==
        "a.yaml:1:22: parts[0].size_m is 0, but has to be a number greater than 0 (number 2 of the list)");
  CHECK(refusal_of("ground: {max_tilt_deg: 90, refine: {rounds: 100}}") == "accepted");
}

TEST_CASE("not finite is refused unless the default says that it means something", "[config]") {
  CHECK_THAT(refusal_of("epsilon: .nan"), Catch::EndsWith("but found .nan"));
  CHECK_THAT(refusal_of("epsilon: .inf"), Catch::EndsWith("that is finite, but found .inf"));
  CHECK_THAT(refusal_of("at: [0, .nan, 0]"), Catch::StartsWith("a.yaml:1:9: "));
  CHECK_THAT(refusal_of("share: .nan"), Catch::EndsWith("but found .nan"));
  CHECK_THAT(refusal_of("unset: .inf"), Catch::EndsWith("but found .inf"));
  CHECK(refusal_of("unset: .nan") == "accepted");
  CHECK(refusal_of("ground: {reach_m: .inf}") == "accepted");
  CHECK_THAT(refusal_of("ground: {reach_m: -.inf}"), Catch::EndsWith("but found -.inf"));
  CHECK_THAT(refusal_of("epsilon: 1e999"), Catch::Contains("1e999"));
  CHECK_THAT(refusal_of("ground: {refine: {rounds: 99999999999}}"), Catch::Contains("99999999999"));
}

TEST_CASE("a list of the wrong length is refused with both lengths", "[config]") {
  CHECK(refusal_of("at: [1, 2]") == "a.yaml:1:5: at expects a list of 3 numbers, but found a list of 2");
  CHECK(refusal_of("at: [1, 2, 3, 4]") ==
        "a.yaml:1:5: at expects a list of 3 numbers, but found a list of 4");
  CHECK(refusal_of("at: [1, [2], 3]") ==
        "a.yaml:1:9: at expects a list of 3 numbers, but found a list of 1 (number 2 of the list)");
}

TEST_CASE("a key given twice is refused with both lines", "[config]") {
  CHECK(refusal_of("epsilon: 1\nat: [0, 0, 0]\nepsilon: 2\n") ==
        "a.yaml:3:1: epsilon is given twice, first in line 1");
  CHECK(refusal_of("ground:\n  max_tilt_deg: 1\nground:\n  reach_m: 2\n") ==
        "a.yaml:3:1: ground is given twice, first in line 1");
  CHECK(refusal_of("ground: {max_tilt_deg: 1, \"max_tilt_deg\": 1}") ==
        "a.yaml:1:27: ground.max_tilt_deg is given twice, first in line 1");
}

TEST_CASE("what an element of a list needs has to be there", "[config]") {
  CHECK(refusal_of("parts:\n  - size_m: [1, 1, 1]\n  - shape: box\n") ==
        "a.yaml:3:5: parts[1].size_m is missing, expected a list of 3 numbers, each greater than 0");
  CHECK(
      refusal_of("groups: [{parts: [{}]}]") ==
      "a.yaml:1:19: groups[0].parts[0].size_m is missing, expected a list of 3 numbers, each greater than 0");
}

TEST_CASE("a text that is no YAML is refused with the parser's place", "[config]") {
  CHECK_THAT(refusal_of("epsilon: 1\nat: [1, 2"), Catch::StartsWith("a.yaml:2:1: this is no YAML: "));
  CHECK_THAT(refusal_of("epsilon: 1\n  at: 2"),
             Catch::StartsWith("a.yaml:2:5: this is no YAML: ") && Catch::Contains("indentation"));
  CHECK_THAT(refusal_of("ground:\n\tmax_tilt_deg: 3\n"),
             Catch::StartsWith("a.yaml:2:") && Catch::Contains("indented with a tab"));
  CHECK_THAT(refusal_of("title: \"open"), Catch::StartsWith("a.yaml:1:"));
  CHECK_THAT(refusal_of("@foo"), Catch::StartsWith("a.yaml:1:1: "));
  CHECK_THAT(refusal_of("epsilon: *nobody"), Catch::StartsWith("a.yaml:1:10: "));
  CHECK_THAT(refusal_of("? [a]\n: 1\n"), Catch::EndsWith("a key has to be a name"));
  CHECK_THAT(refusal_of("epsilon: !!int 5"), Catch::Contains("tag"));
}

TEST_CASE("more than one document is refused", "[config]") {
  CHECK(refusal_of("epsilon: 1\n---\nepsilon: 2\n") ==
        "a.yaml:2:1: a second document starts here, expected only one");
  CHECK(refusal_of("---\nepsilon: 1\n...\n") == "accepted");
}

TEST_CASE("bytes that are no text are refused with the first such byte", "[config]") {
  CHECK(refusal_of(std::string("ab\0c", 4)) ==
        "a.yaml:1:3: byte 2 is 0x00, which no UTF-8 text file holds; is this a YAML file?");
  CHECK_THAT(refusal_of("# ok\n\x89PNG\r\n\x1a\n"), Catch::StartsWith("a.yaml:2:1: byte 5 is 0x89"));
  CHECK_THAT(refusal_of("\xff\xfe"
                        "a"),
             Catch::Contains("0xFF"));
  CHECK_THAT(refusal_of("title: \xc0\xaf"), Catch::Contains("0xC0"));
  CHECK_THAT(refusal_of("title: \xed\xa0\x80"), Catch::Contains("0xED"));
  CHECK(app_from("title: gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\xa4\x96").title ==
        "gr\xc3\xbc\xc3\x9f \xe2\x82\xac \xf0\x9f\xa4\x96");
}

TEST_CASE("a text built to exhaust the reader is refused", "[config]") {
  CHECK_THAT(refusal_of(repeated("[", 100'000)), Catch::Contains("nested deeper than 32 levels"));
  CHECK_THAT(refusal_of("a: " + repeated("{a: ", 50'000)), Catch::Contains("nested deeper than 32 levels"));
  CHECK_THAT(refusal_of(repeated("- ", 50'000) + "1"), Catch::Contains("nested deeper than 32 levels"));
  CHECK_THAT(refusal_of(repeated("? ", 50'000) + "1"), Catch::Contains("nested deeper than 32 levels"));
  std::string stairs;
  for (int i = 0; i < 1000; ++i) stairs += std::string(static_cast<std::size_t>(i), ' ') + "a:\n";
  CHECK_THAT(refusal_of(stairs), Catch::StartsWith("a.yaml:33:33: nested deeper than 32 levels"));
  CHECK_THAT(refusal_of("weights: [" + repeated("1,", 200'000) + "1]"),
             Catch::Contains("more than 100000 values"));
  CHECK_THAT(refusal_of(std::string(kMaxYamlBytes + 1, '#')), Catch::Contains("larger than 1048576 bytes"));
}

TEST_CASE("aliases are followed, but neither in a circle nor into the millions", "[config]") {
  const App app = app_from("parts: [{size_m: &s [1, 2, 3]}, {size_m: *s}]");
  CHECK(app.parts[1].size_m == Vec3(1, 2, 3));
  CHECK_THAT(refusal_of("weights: &w [1, *w]"),
             Catch::Contains("alias points to the value that it stands in"));

  // each level takes the one before it many times: a billion parts in a few hundred bytes
  std::string bomb = "groups:\n  - parts: &p [";
  for (int i = 0; i < 400; ++i) bomb += "{size_m: [1, 1, 1]},";
  bomb += "]\n";
  for (int i = 0; i < 1000; ++i) bomb += "  - {parts: *p}\n";
  CHECK_THAT(refusal_of(bomb), Catch::Contains("more than 100000 values"));
}

TEST_CASE("a path that is no readable file is refused by its kind", "[config]") {
  namespace fs = std::filesystem;
  const fs::path folder = fs::temp_directory_path() / ("colift_config_test_" + std::to_string(::getpid()));
  fs::create_directories(folder);
  App app;
  FieldTable table = table_of(app);
  const auto refusal = [&](const fs::path& path) {
    const auto done = apply_yaml_file(table, path);
    if (done) return std::string("accepted");
    CHECK(done.error().code == ErrorCode::BadConfig);
    CHECK(done.error().where == path.string());
    return done.error().detail;
  };

  CHECK(refusal(folder / "none.yaml") == "there is no such file");
  CHECK(refusal(folder) == "this is a directory, expected a YAML file");
  CHECK(refusal("/dev/zero") == "the text is larger than 1048576 bytes, too large for a configuration");
  { std::ofstream(folder / "empty.yaml"); }
  CHECK(refusal(folder / "empty.yaml") == "accepted");
  { std::ofstream(folder / "secret.yaml") << "epsilon: 2\n"; }
  fs::permissions(folder / "secret.yaml", fs::perms::none);
  // root reads everything
  if (::geteuid() != 0) CHECK(refusal(folder / "secret.yaml") == "cannot be opened: Permission denied");
  fs::remove_all(folder);
}

TEST_CASE("a refused file changes nothing", "[config]") {
  App app;
  FieldTable table = table_of(app);
  const std::string before = effective_yaml(table, true);

  CHECK_FALSE(apply_yaml_text(table, "epsilon: 7\nparts: [{size_m: [1, 1, 1]}]\nat: [1, 2]\n", "a.yaml"));
  CHECK(effective_yaml(table, true) == before);
  CHECK_FALSE(apply_setting(table, "ground={max_tilt_deg: 3, reach_m: -1}"));
  CHECK(effective_yaml(table, true) == before);
}

TEST_CASE("a setting that cannot be done names itself", "[config]") {
  CHECK(refusal_of_setting("ground.max_tlit_deg=3") ==
        "--set ground.max_tlit_deg=3: unknown key \"ground.max_tlit_deg\"; did you mean "
        "\"ground.max_tilt_deg\"?");
  CHECK_THAT(refusal_of_setting("epsilon"), Catch::Contains("a setting is written name=value"));
  CHECK_THAT(refusal_of_setting("=3"), Catch::Contains("a setting is written name=value"));
  CHECK_THAT(refusal_of_setting("  =3"), Catch::Contains("no name before"));
  CHECK_THAT(refusal_of_setting(""), Catch::Contains("a setting is written name=value"));
  CHECK(refusal_of_setting("epsilon=") ==
        "--set epsilon=: epsilon expects a number greater than 0, but found no value");
  CHECK_THAT(refusal_of_setting("epsilon=-1"),
             Catch::EndsWith("epsilon is -1, but has to be a number greater than 0"));
  CHECK_THAT(refusal_of_setting("at=[1, 2"), Catch::Contains("this is no YAML"));
  CHECK_THAT(refusal_of_setting("epsilon=1\nat: 2"), Catch::Contains("this is no YAML"));
  CHECK_THAT(refusal_of_setting("title=\xff"), Catch::Contains("UTF-8"));
  CHECK_THAT(refusal_of_setting("parts[2].mass_kg=1"),
             Catch::Contains("the list has 2 entries, counted from 0"));
  CHECK_THAT(refusal_of_setting("parts[99999999999999999999].mass_kg=1"), Catch::Contains("parts[0].NAME"));
  CHECK_THAT(refusal_of_setting("parts.mass_kg=1"), Catch::Contains("parts[0].NAME"));
  CHECK_THAT(refusal_of_setting("parts[0].mas_kg=1"), Catch::Contains("did you mean \"parts[0].mass_kg\"?"));
  CHECK_THAT(refusal_of_setting("epsilon[0].x=1"), Catch::Contains("epsilon is no list of groups"));
}
