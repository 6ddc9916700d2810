// A controller whose brakes closed while nobody asked for anything.
#include "emulated_arm.hpp"

namespace colift {
namespace {

using test::Emulated;

sim_hal::KrcConfig idle(bool start_opens) {
  sim_hal::KrcConfig c;
  c.idle_brakes_s = 2.0;
  c.start_opens_brakes = start_opens;
  return c;
}

/// Watches until the drives are off.
void wait_for_brakes(Emulated& e) {
  REQUIRE(e.fri->configure());
  for (int i = 0; i < 1500 && e.fri->status().power != 0; ++i) (void)e.fri->wait_cycle();
  REQUIRE(e.fri->status().power == 0);
  REQUIRE(e.fri->status().session == hal::FriSession::Monitor);
}

void hold_still(Emulated& e, int cycles) {
  hal::ImpedanceCommand c;
  for (int i = 0; i < cycles; ++i) {
    const auto state = e.fri->wait_cycle();
    REQUIRE(state);
    REQUIRE(state->may_command);
    if (i == 0) c.q_rad = state->q_rad;
    REQUIRE(e.fri->command(c));
  }
}

}  // namespace

TEST_CASE("brakes that closed while idle are opened by a start, and nothing is commanded before",
          "[fri][emulated]") {
  const std::string script = GENERATE("colift", "stanford", "cep", "openkc");
  Emulated e(script, {}, idle(true), false);
  INFO(script);
  wait_for_brakes(e);
  const auto active = e.fri->activate();
  INFO((active ? "" : active.error().text()) << "\n" << e.told);
  REQUIRE(active);
  CHECK(e.fri->status().power == hal::kFriAllDrives);
  hold_still(e, 1500);  // longer than the pause in which they close
  e.fri->deactivate();
  CHECK(e.broken() == "");
}

TEST_CASE("where only a motion opens them colift.src makes one, and others are named", "[fri][emulated]") {
  hal::FriConfig config;
  config.ready_s = 6.0;
  Emulated own("colift", config, idle(false), false);
  wait_for_brakes(own);
  const auto active = own.fri->activate();
  INFO((active ? "" : active.error().text()) << "\n" << own.told);
  REQUIRE(active);
  hold_still(own, 100);
  CHECK(own.broken() == "");

  const std::string script = GENERATE("stanford", "cep", "openkc");
  Emulated other(script, config, idle(false), false);
  wait_for_brakes(other);
  const auto refused = other.fri->activate();
  REQUIRE_FALSE(refused);
  INFO(script << ": " << refused.error().text());
  CHECK(refused.error().detail.find("brakes closed while nothing moved") != std::string::npos);
  CHECK(other.broken() == "");
}

}  // namespace colift
