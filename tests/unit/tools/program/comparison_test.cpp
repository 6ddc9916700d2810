// Two recordings held against each other: what differs is found and nothing else, and a recording that lies
// about its messages is read as far as it can be.

#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <random>

#include "tests/unit/tools/telemetry/made_recording.hpp"
#include "tools/log/comparison.hpp"

namespace comparison_trials {

using namespace colift;
using namespace colift::tools;

using Line = tests::MadeMessage;

std::string recording(const std::vector<Line>& lines, const std::string& config = "",
                      const std::string& outcome = "lifted") {
  return tests::bytes_of({lines, config, outcome});
}

RecordedRun read(const std::string& bytes) {
  const auto reader = telemetry::McapReader::open(telemetry::source_of(bytes), "made");
  REQUIRE(reader);
  auto run = recorded_run_of(*reader, "made.mcap");
  REQUIRE(run);
  return std::move(*run);
}

std::string change(const char* state) {
  return fmt::format(R"({{"state": "{}", "because": "test"}})", state);
}

/// Observes for 1 s, lifts for 2 s up to `height`, holds for 1 s; load 30 N and the share at 30 Hz.
std::vector<Line> lift(double begins_s, double height_m, double share) {
  std::vector<Line> out{{"/task/change", begins_s, change("observe")},
                        {"/task/change", begins_s + 1, change("lift")},
                        {"/task/change", begins_s + 3, change("hold")}};
  for (int i = 0; i <= 120; ++i) {
    const double t = i / 30.0, h = height_m * std::clamp(t - 1.0, 0.0, 2.0) / 2.0;
    out.push_back(
        {"/load", begins_s + t,
         fmt::format(R"({{"load_n": 30, "share": {}, "height_m": {}, "tilt_deg": null}})", share, h)});
  }
  out.push_back({"/task/change", begins_s + 4, change("done")});
  return out;
}

std::vector<Line> with_decision(std::vector<Line> lines, int chosen, const char* verdict_of_2,
                                double x_of_2 = 0.8) {
  lines.push_back(
      {"/decision", 1.0,
       fmt::format(
           R"({{"chosen": {}, "share": 0.5, "cost": 3, "because": "best", "partner": [1.5, 0, 0.4], "candidates": [
               {{"id": 1, "kind": "edge", "verdict": "ok", "position": [0.7, 0, 0.4]}},
               {{"id": 2, "kind": "edge", "verdict": "{}", "because": "in the way", "position": [{}, 0, 0.4]}}]}})",
           chosen, verdict_of_2, x_of_2)});
  return lines;
}

const FigureComparison& figure(const Comparison& c, const std::string& name) {
  for (const FigureComparison& f : c.figures)
    if (f.name == name) return f;
  FAIL("no figure " << name);
  return c.figures.front();
}

const CurveComparison& curve(const Comparison& c, Quantity quantity) {
  for (const CurveComparison& k : c.curves)
    if (k.quantity == quantity) return k;
  FAIL("no curve " << style_of(quantity).name);
  return c.curves.front();
}

}  // namespace comparison_trials

using namespace comparison_trials;

TEST_CASE("a run compared with itself is the same", "[compare]") {
  const RecordedRun run =
      read(recording(with_decision(lift(0.5, 0.05, 0.5), 1, "ok"), "task:\n  hold_s: 2\n"));
  const Comparison c = compare(run, run);
  CHECK(c.same());
  CHECK(c.config.empty());
  CHECK(c.aligned == "lift");
  REQUIRE(c.decision);
  CHECK(c.decision->same_candidates);
  CHECK(c.decision->verdicts.empty());
  CHECK(curve(c, Quantity::Height).max_difference == 0.0);
  CHECK(figure(c, "held_share").value[0] == 0.5);
  CHECK(figure(c, "max_height_m").value[1] == 0.05);
}

TEST_CASE("curves are compared from the moment at which each began to lift", "[compare]") {
  const RecordedRun a = read(recording(lift(0.5, 0.05, 0.5))), b = read(recording(lift(7.0, 0.08, 0.5)));
  const Comparison c = compare(a, b);
  CHECK_FALSE(c.same());
  CHECK(c.zero_s[0] == 1.5);
  CHECK(c.zero_s[1] == 8.0);
  // apart by 30 mm at the top, and nowhere more
  CHECK(curve(c, Quantity::Height).max_difference == Approx(0.03).margin(1e-6));
  CHECK(curve(c, Quantity::Height).at_s == Approx(2.0).margin(0.04));
  CHECK(curve(c, Quantity::Load).max_difference == Approx(0.0).margin(1e-12));
  // the times of the states are those of each run
  const auto held = std::find_if(c.states.begin(), c.states.end(),
                                 [](const StateComparison& s) { return s.state == "hold"; });
  REQUIRE(held != c.states.end());
  CHECK(held->entered_s[0] == 3.5);
  CHECK(held->entered_s[1] == 10.0);
  CHECK(held->total_s[0] == Approx(1.0));
}

TEST_CASE("a run that never lifted is compared from its start", "[compare]") {
  const RecordedRun a = read(recording(lift(0.5, 0.05, 0.5)));
  const RecordedRun b = read(recording({{"/task/change", 2.0, change("observe")},
                                        {"/task/change", 3.0, change("refused")},
                                        {"/load", 2.5, R"({"load_n": 0})"}},
                                       "", "refused"));
  const Comparison c = compare(a, b);
  CHECK(c.aligned == "start");
  CHECK(c.zero_s[1] == 2.0);
  CHECK_FALSE(c.decision);
  CHECK_FALSE(figure(c, "held_share").value[1]);
  CHECK_FALSE(c.same());
}

TEST_CASE("settings that differ, and those of one run alone, are listed", "[compare]") {
  const auto lines = lift(0.0, 0.05, 0.5);
  const RecordedRun a = read(recording(lines, "task: {hold_s: 2, lift_height_m: 0.05}\nlist: [1, 2]\n"));
  const RecordedRun b =
      read(recording(lines, "task: {hold_s: 3, lift_height_m: 0.05}\nlist: [1, 2]\nnew: yes\n"));
  const Comparison c = compare(a, b);
  REQUIRE(c.config.size() == 2);
  CHECK(c.config[0].key == "new");
  CHECK_FALSE(c.config[0].value[0]);
  CHECK(c.config[1].key == "task.hold_s");
  CHECK(c.config[1].value[0] == "2");
  CHECK(c.config[1].value[1] == "3");
  CHECK(setting_text(c.config[0].value[0]) == "not there");
  CHECK(setting_text("") == "not set");
}

TEST_CASE("verdicts are compared only of the same candidates", "[compare]") {
  const auto base = lift(0.0, 0.05, 0.5);
  const RecordedRun a = read(recording(with_decision(base, 1, "ok")));
  SECTION("another verdict") {
    const RecordedRun b = read(recording(with_decision(base, 1, "collision")));
    const Comparison c = compare(a, b);
    REQUIRE(c.decision->verdicts.size() == 1);
    CHECK(c.decision->verdicts[0].id == 2);
    CHECK(c.decision->verdicts[0].verdict[1] == "collision");
    CHECK(c.decision->grasps_apart_m == 0.0);
  }
  SECTION("another choice is no other verdict") {
    const RecordedRun b = read(recording(with_decision(base, 2, "chosen")));
    const Comparison c = compare(a, b);
    CHECK(c.decision->verdicts.empty());
    CHECK(*c.decision->grasps_apart_m == Approx(0.1));
    CHECK_FALSE(c.same());
  }
  SECTION("a candidate 2 mm away is another one") {
    const RecordedRun b = read(recording(with_decision(base, 1, "collision", 0.802)));
    const Comparison c = compare(a, b);
    CHECK_FALSE(c.decision->same_candidates);
    CHECK(c.decision->verdicts.empty());
    CHECK_FALSE(c.same());
  }
}

TEST_CASE("messages that are no JSON, or lie about their kinds, are left out", "[compare]") {
  std::vector<Line> lines = lift(0.0, 0.05, 0.5);
  for (const char* lie : {"", "[", "null", "[]", R"({"load_n": "heavy"})", R"({"load_n": 1e999})",
                          R"({"state": 5, "candidates": 3, "separation": [], "position": [1, 2]})",
                          R"({"candidates": [1, {"id": 1e300}, {"id": "x"}, {}]})"})
    for (const char* topic : {"/load", "/task/status", "/decision"}) lines.push_back({topic, 2.0, lie});
  const RecordedRun run = read(recording(lines));
  CHECK(run.curves.at(Quantity::Load).t_s.size() == 121);
  REQUIRE(run.decision);
  CHECK(run.decision->candidates.empty());
  CHECK(compare(run, run).same());
}

TEST_CASE("a recording that was cut is compared as far as it goes", "[compare]") {
  const std::string bytes = recording(lift(0.0, 0.05, 0.5));
  std::mt19937 random(5);
  for (int i = 0; i < 60; ++i) {
    const auto reader =
        telemetry::McapReader::open(telemetry::source_of(bytes.substr(0, random() % bytes.size())), "cut");
    if (!reader) continue;
    if (const auto run = recorded_run_of(*reader, "cut.mcap")) CHECK(compare(*run, *run).same());
  }
  const auto empty =
      telemetry::McapReader::open(telemetry::source_of(recording({{"/other", 1.0, "{}"}})), "o");
  REQUIRE(empty);
  const auto refused = recorded_run_of(*empty, "o.mcap");
  REQUIRE_FALSE(refused);
  CHECK(refused.error().code == hal::ErrorCode::BadInput);
}

TEST_CASE("the page of a comparison shows both runs and nothing of a stranger's markup", "[compare]") {
  const RecordedRun a = read(recording(lift(0.0, 0.05, 0.5)));
  RecordedRun b = read(recording(lift(0.0, 0.08, 0.6), "note: \"<script>\"\n"));
  b.reason = "<img src=x>";
  const auto file = std::filesystem::temp_directory_path() / "colift_comparison_test.html";
  REQUIRE(write_comparison_page(file, compare(a, b), "colift log compare a b"));
  std::ifstream in(file);
  const std::string page{std::istreambuf_iterator<char>(in), {}};
  CHECK(page.find("data:image/png") != std::string::npos);
  CHECK(page.find("max height") != std::string::npos);
  CHECK(page.find("<script>") == std::string::npos);
  CHECK(page.find("<img src=x>") == std::string::npos);
  std::filesystem::remove(file);
  CHECK_FALSE(write_comparison_page("/nowhere/at/all.html", compare(a, b), ""));
}
