// What the page is given of a recording.

#include "tools/telemetry/replay/page_recording.hpp"

#include <catch2/catch.hpp>
#include <sstream>

#include "tests/unit/tools/telemetry/made_recording.hpp"

namespace {

using namespace colift;
using telemetry::page_recording;

telemetry::McapReader file_of(const tests::MadeRecording& recording) {
  auto reader = telemetry::McapReader::open(telemetry::source_of(tests::bytes_of(recording)), "made");
  REQUIRE(reader);
  return std::move(*reader);
}

std::map<std::string, int> counts(const std::string& document) {
  std::map<std::string, int> all;
  std::istringstream in(document);
  for (std::string topic, rest; in >> topic && std::getline(in, rest);) ++all[topic];
  return all;
}

/// Ten seconds of joints at 100 Hz, and a change of state in each second.
tests::MadeRecording ten_seconds() {
  tests::MadeRecording recording;
  for (int i = 0; i < 1000; ++i) {
    if (i % 100 == 0) recording.messages.push_back({"/task/change", 0.01 * i, R"({"state":"lift"})"});
    recording.messages.push_back({"/joint_states", 0.01 * i, R"({"joints":[]})"});
  }
  return recording;
}

}  // namespace

TEST_CASE("a page gets topic, time and message, a line each", "[page_recording]") {
  const auto file =
      file_of({.messages = {{"/task/change", 1.5, R"({"state":"lift"})"}, {"/log", 2.0, R"({"level":2})"}}});
  CHECK(page_recording(file) ==
        "/task/change 1500000000 {\"state\":\"lift\"}\n/log 2000000000 {\"level\":2}\n");
}

TEST_CASE("what comes often is thinned, what is said once is not", "[page_recording]") {
  auto seen = counts(page_recording(file_of(ten_seconds())));
  CHECK(seen["/task/change"] == 10);
  CHECK(seen["/joint_states"] == 250);
}

TEST_CASE("a long recording is thinned until it fits, and keeps its changes of state", "[page_recording]") {
  const auto file = file_of(ten_seconds());
  const std::string all = page_recording(file);
  for (const std::size_t largest : {all.size(), all.size() / 2, all.size() / 8, std::size_t{700}}) {
    INFO(largest);
    const std::string fits = page_recording(file, largest);
    CHECK(fits.size() <= largest);
    CHECK(counts(fits)["/task/change"] == 10);
  }
  // less than its changes need: from the front, in whole lines
  const std::string little = page_recording(file, 100);
  CHECK(little.size() <= 100);
  CHECK(little.back() == '\n');
}

TEST_CASE("what is not for a page, or would break its lines, is left out", "[page_recording]") {
  const auto file = file_of({.messages = {{"/inputs", 0.0, "{}"},
                                          {"/truth", 0.0, "{}"},
                                          {"/somebody/else", 0.0, "{}"},
                                          {"/camera/depth", 0.0, "\x01", "cdr"},
                                          {"/log", 0.5, "{}\n/task/change 1 {}"},
                                          {"/log", 1.0, "{}"}}});
  CHECK(page_recording(file) == "/log 1000000000 {}\n");
}
