// Every shipped scenario, as its own comment says it ends.

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>

#include "sim_hal/scenario/scenario.hpp"
#include "tests/support/lift_figures.hpp"

namespace {

using namespace colift;
using Result = control::RunRecord::Result;

tests::SimulatedLift run(const std::string& name, control::Method method, std::uint64_t seed = 1) {
  const auto scenario = sim_hal::load_scenario(std::string(COLIFT_SOURCE_DIR) + "/config/scenario/" + name + ".yaml");
  REQUIRE(scenario);
  return tests::simulate(*scenario, method, seed);
}

void check_lifted(const std::string& name, control::Method method, double tilt_deg) {
  const auto lift = run(name, method);
  INFO(tests::line(name, lift));
  REQUIRE(lift.record.outcome == Result::Lifted);
  CHECK(lift.tilt_deg < tilt_deg);
  CHECK(lift.slip_m < 0.01);
  CHECK_FALSE(lift.hit_something);
}

}  // namespace

TEST_CASE("both methods lift what the thesis lifted", "[scenario]") {
  for (const char* name : {"table", "table_pose_2", "box"}) {
    check_lifted(name, control::Method::Fast, 2.0);
#ifdef COLIFT_THESIS
    check_lifted(name, control::Method::Thesis, 5.0);
#endif
  }
}
