#include "tools/experiments/trials/furniture.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "hal/robot_model/robot_model.hpp"
#include "sim_hal/mujoco/sim_world.hpp"

using namespace colift;
using experiments::furniture_layout;

TEST_CASE("furniture stands on the floor, is light enough for hand and arm, and is drawn anew from each seed",
          "[layouts]") {
  std::set<std::string> kinds;
  for (int index = 0; index < 32; ++index) {
    const sim_hal::Scenario s = furniture_layout(index, 3);
    INFO(s.name);
    kinds.insert(s.name.substr(0, s.name.find(' ')));
    CHECK(s.object.mass > 1.9);
    CHECK(s.object.mass < 5.5);
    CHECK(s.object.parts.size() >= 2);
    CHECK(s.object.parts.front().size != furniture_layout(index, 4).object.parts.front().size);
    // nothing starts inside the floor, the robot or each other
    const auto world = sim_hal::SimWorld::make(s, hal::built_in_robot(), 1, sim_hal::SimConfig{});
    INFO((world ? "" : world.error().text()));
    CHECK(world);
  }
  CHECK(kinds.size() == experiments::furniture_kinds().size());
}
