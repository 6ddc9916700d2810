// What the help of the emulated devices says of a fault is what a fault does.
#include <fmt/format.h>

#include <catch2/catch.hpp>

#include "sim_hal/emulator/camera/camera_faults.hpp"
#include "sim_hal/emulator/hand/hand_faults.hpp"
#include "sim_hal/emulator/krc/krc_faults.hpp"
#include "tests/stories/run_program.hpp"

using namespace colift;

TEST_CASE("the help of each emulated device names the duration of a fault that has none", "[program]") {
  const double default_s = sim_hal::TimedFault{}.for_s;
  const auto hand = sim_hal::parse_hand_fault("1:silent");
  const auto krc = sim_hal::parse_krc_fault("1:estop");
  const auto camera = sim_hal::parse_camera_fault("1:slow=10");
  REQUIRE((hand && krc && camera));
  CHECK(hand->for_s == default_s);
  CHECK(krc->for_s == default_s);
  CHECK(camera->for_s == default_s);
  CHECK(sim_hal::parse_hand_fault("1:silent:2")->for_s == 2.0);  // and not another
  for (const char* device : {"krc", "hand", "camera", "rig"}) {
    const auto help = story::run_colift(fmt::format("emulate {} --help", device));
    INFO(help.out << help.err);
    CHECK(help.code == 0);
    CHECK_THAT(help.out, Catch::Contains("T:KIND[:DURATION]") &&
                             Catch::Contains(fmt::format("DURATION (default {:g} s)", default_s)));
  }
}
