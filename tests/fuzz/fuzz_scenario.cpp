// Any bytes as a scenario file: refused with one sentence and its place, or accepted; and what was accepted
// is something that a world can be built from.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "sim_hal/scenario/object_parts.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace {

using namespace colift;

void demand(bool fact, const char* what, const std::string& text) {
  if (fact) return;
  std::fprintf(stderr, "%s\n%s\n", what, text.c_str());
  std::abort();
}

void demand_sound(const sim_hal::Scenario& s) {
  const auto parts = sim_hal::object_parts(s.object);
  demand(parts.has_value(), "an accepted object cannot be built", parts ? "" : parts.error().text());
  demand(!parts->parts.empty() && parts->mass_kg > 0.0 && std::isfinite(parts->mass_kg), "no mass", s.name);
  demand(parts->cog_T.allFinite() && parts->inertia_T.allFinite(), "no inertia", s.name);
  demand(parts->inertia_T.diagonal().minCoeff() > 0.0, "an inertia that is not positive", s.name);
  for (const auto& part : parts->parts)
    demand(part.mass_kg > 0.0 && part.shape.X_WS.matrix().allFinite() && part.shape.size.allFinite(),
           "a part that is none", s.name);
  demand(sim_hal::clutter_shapes(s).size() == s.clutter.size(), "clutter was lost", s.name);
  demand(sim_hal::object_pose(s.object).matrix().allFinite(), "no pose", s.name);
  demand(s.task.height > 0.0 && s.task.height <= 0.5 && s.task.hold_s >= 0.0, "a task out of range", s.name);
  for (const auto& event : s.partner.events)
    demand(event.at_s >= 0.0 &&
               event.to.has_value() == (event.action == "move" || event.action == "second-hand"),
           "an event that is none", s.name);
  for (const auto& person : s.people) {
    demand(!person.path.empty() && person.speed > 0.0 && person.hand_speed > 0.0, "a person who is none",
           s.name);
    for (const auto& point : person.path) demand(point.allFinite(), "a person nowhere", s.name);
    demand(person.reach_to.empty() == (person.action != "reach"), "a reach that is none", s.name);
  }
  for (const auto& shape : sim_hal::clutter_shapes(s, 1e4))
    demand(shape.X_WS.matrix().allFinite(), "clutter that moved nowhere", s.name);
  for (const auto& fault : s.faults)
    demand(fault.at_s >= 0.0 && fault.for_s >= 0.0 && std::isfinite(fault.at_s), "a fault out of time",
           s.name);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const auto scenario = sim_hal::parse_scenario(text, "input.yaml");
  if (scenario) {
    demand_sound(*scenario);
    return 0;
  }
  const hal::Error& error = scenario.error();
  demand(error.code == hal::ErrorCode::BadConfig, "another error than BadConfig", error.text());
  demand(error.where.starts_with("input.yaml") && !error.detail.empty(), "an error without a place",
         error.text());
  demand(error.text().find('\n') == std::string::npos, "an error of several lines", error.text());
  return 0;
}
