// What an operator confirms during a run is an input of the run: it is recorded, and replayed to the bit.

#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "recorded_run.hpp"

namespace {

using namespace colift;
using namespace colift::telemetry;
using namespace colift::telemetry::test;

/// Somebody walks into the path during the approach and leaves; the partner confirms before, while he is
/// there, and, at `confirms_s`, when he has gone.
sim_hal::Scenario confirmed_lift(double confirms_s) {
  sim_hal::Scenario scenario = short_lift();
  sim_hal::ScenarioPerson person;
  person.enters_s = 3.5;
  person.path = {{0.3, -2.4}, {0.3, -0.95}};
  person.leaves_s = 6.0;
  scenario.people.push_back(person);
  for (const double at_s : {2.0, 5.5, confirms_s})
    scenario.partner.events.push_back({at_s, "confirm-continue", {}});
  return scenario;
}

}  // namespace

TEST_CASE("a confirmation is recorded with the inputs, and its lift is replayed to the bit", "[lift]") {
  const auto file =
      std::filesystem::temp_directory_path() / ("colift-confirmed-" + std::to_string(::getpid()) + ".mcap");
  const Recorded recorded = run(confirmed_lift(11.0), &file, hal::Pose::Identity(), {"monitor.resume=false"});
  INFO(recorded.record.reason);
  CHECK(recorded.record.outcome == control::RunRecord::Result::Lifted);

  const McapReader reader = opened(file);
  int confirmed = 0, asked = 0;
  auto cursor = reader.messages({"/inputs", "/task/status"});
  while (const auto message = cursor.next()) {
    const auto j = nlohmann::json::parse(message->data);
    confirmed += j.value("continue_confirmed", false) ? 1 : 0;
    if (!j.contains("separation") || !j["separation"].value("may_confirm", false)) continue;
    ++asked;
    CHECK_THAT(j["doing"].get<std::string>(), Catch::StartsWith("waits for confirmation: nobody is near"));
  }
  CHECK(confirmed == 3);  // two of them without effect
  CHECK(asked > 10);

  const auto again = replayed(reader);
  REQUIRE(again);
  for (const auto& d : again->differences)
    UNSCOPED_INFO(channel_of(d.topic).topic << " " << d.index << "\n" << d.recorded << "\n" << d.replayed);
  CHECK(again->same());
  CHECK(again->record.outcome == control::RunRecord::Result::Lifted);
  CHECK(again->record.monitor.waited_s == recorded.record.monitor.waited_s);
  std::filesystem::remove(file);
}
