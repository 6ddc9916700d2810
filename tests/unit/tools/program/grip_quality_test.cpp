// How well a closed hand holds, from what it measures.
#include "control/task/grip_quality.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace colift;

TEST_CASE("the strongest finger says at which fraction of what was asked a grip holds", "[grip]") {
  hal::HandState hand;
  hand.torque_nm = {0.1, 0.1, 0.4};
  hand.tip_force_n.fill(NAN);
  const auto q = control::grip_quality(hand, 1.0, {});
  CHECK(q.held_fraction == Approx(0.4));
  CHECK(q.contact_points == 3);
  CHECK(q.friction_limit_n == Approx(0.5 * 0.6 / 0.05));  // no pads: torque over the lever
  CHECK(control::friction_margin(q, 3.0) == Approx(2.0));
  hand.torque_nm.fill(NAN);
  const auto blind = control::grip_quality(hand, 1.0, {});
  CHECK(std::isnan(blind.held_fraction));  // nothing is known against it
  CHECK_FALSE(blind.held_fraction < 0.4);
  CHECK(std::isnan(blind.friction_limit_n));
  hand.torque_nm = {0.0, 0.0, 0.0};
  hand.outer_rad[1] = 0.5;  // broken away: its gauge says nothing of the inner link
  CHECK(std::isnan(control::grip_quality(hand, 1.0, {}).held_fraction));
}

TEST_CASE("a pad that feels nothing of what its gauge measures is beside the contact", "[grip]") {
  hal::HandState hand;
  hand.torque_nm = {0.5, 0.5, 1.0};
  hand.tip_force_n = {10.0, 0.5, 20.0};
  const auto q = control::grip_quality(hand, 1.0, {});
  CHECK(q.beside_pad == std::array<bool, 3>{false, true, false});
  CHECK(q.squeeze_n == Approx(0.5 * (10.0 + 0.5 / 0.05 + 20.0)));
  CHECK(control::describe(q).find("F2 presses with 0.50 N m beside its pad") != std::string::npos);
}

TEST_CASE("cells in contact are counted, and the palm tells that the object touches it", "[grip]") {
  hal::HandState hand;
  hand.torque_nm.fill(NAN);
  hand.tip_force_n = {4.0, 0.0, 8.0};
  hand.palm_force_n = 2.0;
  for (auto& array : hand.tactile) array.pressure_n_cm2.fill(0.0F);
  for (std::size_t cell = 6; cell < 9; ++cell) hand.tactile[0].pressure_n_cm2[cell] = 1.0F;
  hand.tactile[hal::kPalmArray].pressure_n_cm2[20] = 0.5F;
  const auto q = control::grip_quality(hand, 1.0, {});
  CHECK(q.contacts[0].cells == 3);
  CHECK(q.contacts[0].row == Approx(2.0));
  CHECK(q.contacts[1].cells == 0);
  CHECK(q.palm_touches());
  CHECK(q.contacts[hal::kPalmArray].row == Approx(3.0));
  CHECK(q.contact_points == 3);  // F1 by its cells, F3 by its force, the palm
  CHECK(q.friction_limit_n == Approx(0.5 * 14.0));
  CHECK(control::describe(q).find("F1, palm (4 cells)") != std::string::npos);
}
