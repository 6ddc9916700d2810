// Entries that had another name once, and texts that another version of the program wrote.
#include <catch2/catch.hpp>

#include "hal/config/config_file.hpp"

using namespace colift::hal;

namespace {

struct Partner {
  double timeout_s = 30.0;
  std::vector<double> places;
  template <class Visitor>
  void visit(Visitor& v) {
    v("timeout_s", timeout_s, Range{0.1, 3600}, "How long a partner is waited for.");
    v.renamed("patience_s", "timeout_s");
    v("places", places, kAny, "Where he may stand.");
  }
};

struct Part {
  double mass_kg = 1.0;
  template <class Visitor>
  void visit(Visitor& v) {
    v("mass_kg", mass_kg, kPositive, "Mass.");
    v.renamed("weight", "mass_kg");
  }
};

struct Robot {
  Partner partner;
  double speed_m_s = 0.1, force_n = 5.0;
  std::vector<Part> parts;
  template <class Visitor>
  void visit(Visitor& v) {
    v("partner", partner, "The person.");
    v("speed_m_s", speed_m_s, kPositive, "How fast.");
    v("force_n", force_n, kPositive, "How hard.");
    v("parts", parts, "What it is made of.");
    v.or_infinite("force_n");
    v.renamed("human", "partner");                // a group
    v.renamed("partner.speed_m_s", "speed_m_s");  // out of a group that is there
    v.renamed("arm.speed_m_s", "speed_m_s");      // out of one that is gone
  }
};

struct Read {
  Robot robot;
  FieldTable table = table_of(robot);
  Result<> file(const std::string& text, UnknownKeys unknown = UnknownKeys::Refused) {
    return apply_yaml_text(table, text, "a.yaml", unknown);
  }
};

}  // namespace

TEST_CASE("an old name is read, with a warning that names the new one and the place", "[config][renamed]") {
  Read r;
  REQUIRE(r.file("partner:\n  patience_s: 12\n"));
  CHECK(r.robot.partner.timeout_s == 12.0);
  CHECK(r.table.find("partner.timeout_s")->origin == "a.yaml:2");
  REQUIRE(r.table.warnings.size() == 1);
  CHECK(r.table.warnings[0] ==
        "a.yaml:2:3: partner.patience_s is called partner.timeout_s now; the old name is still read");

  Read set;
  REQUIRE(apply_setting(set.table, "partner.patience_s=13"));
  CHECK(set.robot.partner.timeout_s == 13.0);
  REQUIRE(set.table.warnings.size() == 1);
  CHECK_THAT(set.table.warnings[0], Catch::StartsWith("--set partner.patience_s=13: "));

  Read quiet;
  REQUIRE(quiet.file("partner: {timeout_s: 12}"));
  CHECK(quiet.table.warnings.empty());
}

TEST_CASE("groups are renamed whole, and entries go from group to group", "[config][renamed]") {
  Read r;
  REQUIRE(r.file("human: {timeout_s: 4, places: [1, 2]}\narm: {speed_m_s: 0.5}\nparts: [{weight: 3}]\n"));
  CHECK(r.robot.partner.timeout_s == 4.0);
  CHECK(r.robot.partner.places.size() == 2);
  CHECK(r.robot.speed_m_s == 0.5);
  REQUIRE(r.robot.parts.size() == 1);
  CHECK(r.robot.parts[0].mass_kg == 3.0);
  CHECK(r.table.warnings.size() == 3);
  REQUIRE(r.file("partner: {speed_m_s: 0.7}\n"));
  CHECK(r.robot.speed_m_s == 0.7);
  REQUIRE(apply_setting(r.table, "human.timeout_s=9"));
  CHECK(r.robot.partner.timeout_s == 9.0);
}

TEST_CASE("the old and the new name together are refused with the place", "[config][renamed]") {
  Read r;
  const auto both = r.file("partner:\n  timeout_s: 1\n  patience_s: 2\n");
  REQUIRE_FALSE(both);
  CHECK(both.error().text() == "a.yaml:3:3: partner.timeout_s is given under its old and its new name");
  CHECK(r.robot.partner.timeout_s == 30.0);
  CHECK(r.table.warnings.empty());
  CHECK_FALSE(r.file("speed_m_s: 1\narm: {speed_m_s: 2}\n"));
  CHECK_FALSE(r.file("arm: {sped_m_s: 2}\n"));
  // one after the other, the later wins, as always
  REQUIRE(r.file("partner: {patience_s: 2}"));
  REQUIRE(apply_setting(r.table, "partner.timeout_s=3"));
  CHECK(r.robot.partner.timeout_s == 3.0);
}

TEST_CASE("a new name has to exist, an old one must not", "[config][renamed]") {
  Robot robot;
  FieldTable table = table_of(robot);
  CHECK_THROWS(table.add_renamed({"old", "nowhere"}));
  CHECK_THROWS(table.add_renamed({"speed_m_s", "force_n"}));
}

TEST_CASE("what nobody knows can be left out of a text that another version wrote", "[config][renamed]") {
  Read r;
  REQUIRE(
      r.file("speed_m_s: 2\nfuture: {deep: 1}\npartner: {mood: 3, timeout_s: 5}\n", UnknownKeys::LeftOut));
  CHECK(r.robot.speed_m_s == 2.0);
  CHECK(r.robot.partner.timeout_s == 5.0);
  REQUIRE(r.table.warnings.size() == 2);
  CHECK_THAT(r.table.warnings[0], Catch::StartsWith("a.yaml:2:1: unknown key \"future\""));
  CHECK_THAT(r.table.warnings[1], Catch::EndsWith("; it is left out"));
  // a value of the wrong kind is refused all the same
  CHECK_FALSE(r.file("speed_m_s: fast\n", UnknownKeys::LeftOut));
}

TEST_CASE("no limit may be said where the default is one", "[config]") {
  Read r;
  REQUIRE(r.file("force_n: .inf"));
  CHECK_FALSE(r.file("speed_m_s: .inf"));
  CHECK_FALSE(r.file("force_n: -.inf"));
}

TEST_CASE("an option of a command line is a value with its own origin and place", "[config]") {
  Read r;
  REQUIRE(apply_value(r.table, "speed_m_s", "0.3", "--speed 0.3", "--speed"));
  CHECK(r.table.find("speed_m_s")->origin == "--speed");
  const auto bad = apply_value(r.table, "speed_m_s", "slow", "--speed slow", "--speed");
  REQUIRE_FALSE(bad);
  CHECK(bad.error().where == "--speed slow");
}

TEST_CASE("with help the unit stands beside the range", "[config]") {
  Robot robot;
  const std::string yaml = effective_yaml(table_of(robot), true);
  CHECK_THAT(yaml, Catch::Contains("(a number from 0.1 to 3600; s)"));
  CHECK_THAT(yaml, Catch::Contains("(a number greater than 0; m/s)"));
}
