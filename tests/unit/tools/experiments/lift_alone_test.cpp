// The robot alone lifts a light box, and its torques say the weight (thesis 6.3.3).

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "tools/experiments/experiment.hpp"

using namespace colift::experiments;

TEST_CASE("a light box that the robot lifts alone hangs free, and the measured load is its weight",
          "[experiments][load]") {
  const Experiment* e = find_experiment("lift-alone");
  REQUIRE(e != nullptr);
  const TrialRows rows = e->run({});
  REQUIRE(rows.row.size() == e->columns.size());
  const auto value = [&](const char* column) {
    for (std::size_t i = 0; i < e->columns.size(); ++i)
      if (e->columns[i] == column) return std::strtod(rows.row[i].c_str(), nullptr);
    return std::nan("");
  };
  INFO(rows.words);
  CHECK(value("in_air") == 1.0);
  CHECK(value("weight_n") == Approx(4.02).epsilon(0.01));
  CHECK(value("robot_n") == Approx(value("weight_n")).epsilon(0.02));
  CHECK(value("measured_n") == Approx(value("weight_n")).epsilon(0.05));
}
