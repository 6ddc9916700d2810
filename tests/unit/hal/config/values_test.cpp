#include <catch2/catch.hpp>
#include <stdexcept>

#include "example_config.hpp"
#include "hal/config/nearest_name.hpp"

using namespace colift::hal;
using namespace colift::hal::example;

TEST_CASE("a file sets what it names and leaves the rest at the defaults", "[config]") {
  const App app = app_from(
      "# a comment\n"
      "method: thesis\n"
      "ground:\n"
      "  refine: {up: [0, 0, 1], robust: false}\n"
      "share: 0.25\n"
      "weights: []\n");
  CHECK(app.method == "thesis");
  CHECK(app.ground.max_tilt_deg == 50.0);
  CHECK(app.ground.refine.rounds == 3);
  CHECK_FALSE(app.ground.refine.robust);
  CHECK(app.ground.refine.up == Vec3(0, 0, 1));
  CHECK(app.share == 0.25);
  CHECK(app.weights.empty());
  CHECK(std::isnan(app.unset));
}

TEST_CASE("an empty file, a comment, an empty group are all defaults", "[config]") {
  App defaults;
  for (const char* text : {"", "\n\n", "# nothing\n", "---\n", "~", "{}", "ground:\n",
                           "ground:\n  # max_tilt_deg: 3\n", "ground: {}"}) {
    INFO(text);
    App app = app_from(text);
    CHECK(yaml_of(app) == yaml_of(defaults));
  }
}

TEST_CASE("numbers are read as YAML 1.2 writes them", "[config]") {
  CHECK(app_from("epsilon: +2").epsilon == 2.0);
  CHECK(app_from("epsilon: 1e-3").epsilon == 0.001);
  CHECK(app_from("epsilon: .5").epsilon == 0.5);
  CHECK(app_from("epsilon: 2.").epsilon == 2.0);
  CHECK(app_from("epsilon: 0.1").epsilon == 0.1);
  CHECK(app_from("weights: [4.9406564584124654e-324]").weights[0] ==
        std::numeric_limits<double>::denorm_min());
  CHECK(std::signbit(app_from("at: [-0, -0.0, 0]").at.x()));
  CHECK(app_from("ground: {refine: {rounds: +7}}").ground.refine.rounds == 7);
  CHECK(app_from("ground: {refine: {rounds: 007}}").ground.refine.rounds == 7);
}

TEST_CASE("windows line ends and a byte order mark do not matter", "[config]") {
  CHECK(app_from("epsilon: 2\r\nshare: 0.5\r\n").share == 0.5);
  CHECK(app_from("\xef\xbb\xbf"
                 "epsilon: 2\n")
            .epsilon == 2.0);
}

TEST_CASE("an optional value can be taken back", "[config]") {
  App app;
  FieldTable table = table_of(app);
  REQUIRE(apply_yaml_text(table, "share: 0.5\nunset: 3\n", "a.yaml"));
  REQUIRE(apply_yaml_text(table, "share: ~\nunset: .nan\n", "b.yaml"));
  CHECK_FALSE(app.share.has_value());
  CHECK(std::isnan(app.unset));
}

TEST_CASE("a list of structs is read, each element from its own defaults", "[config]") {
  const App app = app_from(
      "parts:\n"
      "  - {shape: cylinder, size_m: [0.1, 0.1, 1], mass_kg: 2}\n"
      "  - size_m: [1, 2, 3]\n"
      "groups:\n"
      "  - name: legs\n"
      "    parts: [{size_m: [4, 5, 6]}]\n"
      "  -\n");
  REQUIRE(app.parts.size() == 2);
  CHECK(app.parts[0].shape == "cylinder");
  CHECK(app.parts[0].mass_kg == 2.0);
  CHECK(app.parts[1].shape == "box");
  CHECK(std::isnan(app.parts[1].mass_kg));
  REQUIRE(app.groups.size() == 2);
  CHECK(app.groups[0].name == "legs");
  REQUIRE(app.groups[0].parts.size() == 1);
  CHECK(app.groups[0].parts[0].size_m == Vec3(4, 5, 6));
  CHECK(app.groups[1].parts.empty());
}

TEST_CASE("a text setting is taken as it stands", "[config]") {
  App app;
  FieldTable table = table_of(app);
  REQUIRE(apply_setting(table, "title=~/frames/{a}: b # c=d"));
  CHECK(app.title == "~/frames/{a}: b # c=d");
  REQUIRE(apply_setting(table, "title=\"two\\nlines\""));
  CHECK(app.title == "two\nlines");
  REQUIRE(apply_setting(table, "title="));
  CHECK(app.title.empty());
}

TEST_CASE("a setting reaches groups, lists and elements of lists", "[config]") {
  App app;
  app.parts.resize(2);
  FieldTable table = table_of(app);
  REQUIRE(apply_setting(table, "ground={max_tilt_deg: 3, refine: {rounds: 9}}"));
  CHECK(app.ground.max_tilt_deg == 3.0);
  CHECK(app.ground.refine.rounds == 9);
  REQUIRE(apply_setting(table, "at=[4, 5, 6]"));
  CHECK(app.at == Vec3(4, 5, 6));
  REQUIRE(apply_setting(table, " ground.refine.rounds = 8 # why not"));
  CHECK(app.ground.refine.rounds == 8);
  REQUIRE(apply_setting(table, "parts[1].mass_kg=2.5"));
  CHECK(app.parts[1].mass_kg == 2.5);
  CHECK(table.find("parts")->origin == "--set");
  REQUIRE(apply_setting(table, "parts[1].mass_kg=.nan"));
  CHECK(std::isnan(app.parts[1].mass_kg));
  REQUIRE(apply_setting(table, "groups=[{name: x, parts: [{size_m: [1, 1, 1]}]}]"));
  REQUIRE(apply_setting(table, "groups[0].parts[0].shape=cylinder"));
  CHECK(app.groups[0].parts[0].shape == "cylinder");
}

TEST_CASE("the table is flat, in the order of visit, with help and range", "[config]") {
  App app;
  const FieldTable table = table_of(app);
  CHECK(table.fields()[0].path == "method");
  CHECK(table.fields()[2].path == "ground.max_tilt_deg");
  CHECK(table.fields()[4].path == "ground.refine.rounds");
  CHECK(table.find("ground.max_tilt_deg")->help == "Largest angle between the normal and up.");
  CHECK(table.find("ground.max_tilt_deg")->range.high == 90.0);
  CHECK(table.find("ground") == nullptr);
  CHECK(table.find_group("ground.refine")->help == "After the first fit.");
}

TEST_CASE("a struct that names a field twice is a mistake in code", "[config]") {
  struct Twice {
    int a = 0;
    void visit(TableVisitor& v) {
      v("a", a, "One.");
      v("a", a, "Two.");
    }
  } twice;
  CHECK_THROWS_AS(table_of(twice), std::logic_error);
  struct Dotted {
    int a = 0;
    void visit(TableVisitor& v) { v("a.b", a, "One."); }
  } dotted;
  CHECK_THROWS_AS(table_of(dotted), std::logic_error);
}

TEST_CASE("values that code wrote are held to the same ranges", "[config]") {
  App app;
  FieldTable table = table_of(app);
  CHECK(check_fields(table));
  app.epsilon = -2;
  REQUIRE_FALSE(check_fields(table));
  CHECK(check_fields(table).error().text() ==
        "configuration: epsilon is -2, but has to be a number greater than 0 (default)");
  app.epsilon = 1;
  app.parts.resize(1);
  app.parts[0].size_m = Vec3(1, 1, 1);
  app.parts[0].rpy_deg = {0, std::numeric_limits<double>::quiet_NaN()};
  REQUIRE_FALSE(check_fields(table));
  CHECK_THAT(check_fields(table).error().detail, Catch::StartsWith("parts[0].rpy_deg expects"));
}

TEST_CASE("a distance between words counts slips of the finger", "[config]") {
  CHECK(edit_distance("", "") == 0);
  CHECK(edit_distance("abc", "") == 3);
  CHECK(edit_distance("kitten", "sitting") == 3);
  CHECK(edit_distance("tilt", "tlit") == 1);
  CHECK(edit_distance("Tilt", "tilt") == 0);
  CHECK(edit_distance("ca", "abc") == 3);
}

TEST_CASE("the nearest name is a slip away, not just the least far", "[config]") {
  const std::vector<std::string> known = {"ground.seed", "target.seed", "target.max_gap_m", "x"};
  CHECK(nearest_path("target.sede", known) == "target.seed");
  CHECK(nearest_path("ground.max_gap_m", known) == "target.max_gap_m");
  CHECK(nearest_path("seed", known) == "ground.seed");
  CHECK_FALSE(nearest_path("target.voxel_size", known).has_value());
  CHECK_FALSE(nearest_path("y", known).has_value());
  CHECK_FALSE(nearest_path(std::string(100'000, 'a'), known).has_value());
  CHECK_FALSE(nearest_path("a", {}).has_value());
}
