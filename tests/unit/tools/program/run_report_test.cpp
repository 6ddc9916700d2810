#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "run_example.hpp"
#include "tools/run/report/run_report.hpp"
#include "tools/visualization/report/report.hpp"

using namespace colift;

namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("a run's report holds each candidate's reason and each state's", "[run]") {
  const auto e = tests::lifted_run();
  const std::string page = tools::run_report_html(e.view());
  CHECK(page.find(">lifted<") != std::string::npos);
  CHECK(page.find("Held 5.0 cm for 2.0 s, lowered, released.") != std::string::npos);
  for (const auto& c : e.record.decision->candidates) {
    INFO(c.reason);
    CHECK(page.find(picture::html_escaped(c.reason)) != std::string::npos);
  }
  for (const auto& s : e.record.states) {
    INFO(s.reason);
    CHECK(page.find(picture::html_escaped(s.reason)) != std::string::npos);
  }
  CHECK(page.find("truth 4.00 kg") != std::string::npos);
  // two of the scene in space, one from the side, one of the decision, one of the curves
  CHECK(count(page, "data:image/png;base64,iVBOR") == 5);
}

TEST_CASE("a run's report has a film of it, and a still picture for who wants nothing to move", "[run]") {
  auto e = tests::lifted_run();
  e.scenes.film = {{2.5, control::Task::Approach, *e.scenes.before},
                   {9.0, control::Task::Hold, *e.scenes.lifted}};
  const std::string page = tools::run_report_html(e.view());
  CHECK(page.find("<picture><source media=\"(prefers-reduced-motion: reduce)\"") != std::string::npos);
  CHECK(page.find("The run from 2.5 to 9.0 s, as the simulation knows it.") != std::string::npos);
  CHECK(count(page, "data:image/png;base64,iVBOR") == 7);
  CHECK(page.find("<script") == std::string::npos);
  e.scenes.film.pop_back();  // one picture is no film
  CHECK(tools::run_report_html(e.view()).find("<picture>") == std::string::npos);
}

TEST_CASE("a run's report needs nothing from outside and nothing breaks out of its place", "[run]") {
  auto e = tests::stopped_run();
  e.record.reason = "<script>alert(1)</script> & \"more\"";
  e.setting.scenario = "</h1><img src=x>.yaml";
  const std::string page = tools::run_report_html(e.view());
  for (const char* bad : {"<script", "<img src=x", "http://", "https://", "<8>", "lift <1>", "src=\"/"}) {
    INFO(bad);
    CHECK(page.find(bad) == std::string::npos);
  }
  CHECK(page.find("lift &lt;1&gt; &amp; more.html") != std::string::npos);
  CHECK(page.find("&quot;length&quot; &lt;8&gt;") != std::string::npos);
  CHECK(page.find("still holds the object") != std::string::npos);
  CHECK(count(page, "<table") == count(page, "</table>"));
  CHECK(count(page, "<div") == count(page, "</div>"));
}

TEST_CASE("a run that ended early has a report without what did not happen", "[run]") {
  const auto e = tests::refused_run();
  const std::string page = tools::run_report_html(e.view());
  CHECK(page.find(">refused<") != std::string::npos);
  CHECK(page.find("No partner grasped the object within 30 s.") != std::string::npos);
  CHECK(page.find(">nan") == std::string::npos);
  CHECK(page.find(" nan ") == std::string::npos);
  CHECK(page.find("Curves") == std::string::npos);
  // the scene before and what the camera saw
  CHECK(count(page, "data:image/png;base64,iVBOR") >= 1);

  tools::RunSetting setting;
  const control::RunRecord nothing;
  const std::string empty = tools::run_report_html({nothing, setting, nullptr, nullptr});
  CHECK(empty.find("refused") != std::string::npos);
  CHECK(empty.find("data:image") == std::string::npos);
}

TEST_CASE("on a real rig the lift is drawn from what was seen and planned", "[run]") {
  const auto e = tests::lifted_run();
  const std::string page = tools::run_report_html({e.record, e.setting, nullptr, nullptr});
  CHECK(page.find("drawn from what was seen and planned") != std::string::npos);
  CHECK(page.find("Truth against estimate") == std::string::npos);
  CHECK(count(page, "data:image/png;base64,iVBOR") == 5);
}

TEST_CASE("a run's report cannot be written where there is no folder", "[run]") {
  const control::RunRecord nothing;
  const tools::RunSetting setting;
  const auto written =
      tools::write_run_report("/no/such/folder/run.html", {nothing, setting, nullptr, nullptr});
  REQUIRE_FALSE(written);
  CHECK(written.error().code == hal::ErrorCode::BadInput);
  const auto picture =
      tools::write_lift_picture("/tmp/colift_no_lift.png", {nothing, setting, nullptr, nullptr});
  REQUIRE_FALSE(picture);
  CHECK(picture.error().detail == "nothing was seen that could be drawn");
}
