#include "hal/drivers/barrett_can/hand_units.hpp"

#include <catch2/catch.hpp>

using namespace colift::hal::barrett;

TEST_CASE("counts become angles by the gears", "[puck]") {
  CHECK(finger_angles(81'487, 32'595).inner_rad == Approx(1.0).margin(1e-4));
  CHECK(finger_angles(195'000, 78'000).inner_rad == Approx(2.393).margin(1e-3));
  CHECK(finger_angles(195'000, 78'000).outer_rad == Approx(2.393 / 3).margin(1e-3));
  CHECK(finger_angles(195'000, std::nullopt).outer_rad == Approx(2.393 / 3).margin(1e-3));
  CHECK(35'952 / kSpreadCounts_rad == Approx(180.56 * kTurn_rad / 360).margin(1e-3));
  CHECK(spread_counts(1.0) == 11408);
}

TEST_CASE("after breakaway the outer link goes on alone", "[puck]") {
  CHECK_FALSE(broken_away(100'000, 40'000));
  CHECK_FALSE(broken_away(100'000, std::nullopt));
  CHECK(broken_away(130'000, 40'000));
  const auto angles = finger_angles(130'000, 40'000);
  CHECK(angles.inner_rad == Approx(40'000 / 32'594.93));
  CHECK(angles.outer_rad == Approx(130'000 / 61'115.5 - 40'000 / 32'594.93));
}

TEST_CASE("strain in newton metres agrees with the published calibration", "[puck]") {
  const double points[][2] = {{667, -1.02}, {1000, -0.52}, {2000, 0.05},
                              {2048, 0.06}, {3000, 0.51},  {3460, 1.13}};
  for (const auto& [counts, nm] : points) CHECK(strain_nm(counts) == Approx(nm).margin(0.011));
  CHECK(strain_nm(strain_counts(2048, 0.45).value()) == Approx(strain_nm(2048) + 0.45).margin(0.002));
  CHECK_FALSE(strain_counts(2048, 5.0));
}

TEST_CASE("a pad's force is pressure times area", "[puck]") {
  std::array<std::uint16_t, kTactileCells> cells{};
  cells[0] = 256;   // 1 N/cm2 on 0.26 cm2
  cells[23] = 512;  // 2 N/cm2 on 0.14 cm2
  CHECK(pad_force_n(Puck::F2, cells) == Approx(0.54));
  CHECK(pad_force_n(Puck::Spread, cells) == Approx(2.91));
  CHECK(motor_a(2048 + 205) == Approx(1.0));
}
