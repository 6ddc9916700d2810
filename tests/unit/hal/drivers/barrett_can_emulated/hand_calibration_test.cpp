// The gauges and motors of one hand: measured with known torques on emulated pucks, kept by serial number,
// and used.
#include "hal/drivers/barrett_can/calibration/hand_calibration.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "hal/drivers/barrett_can/calibration/gauge_reading.hpp"
#include "hal/drivers/barrett_can/service/finger_motion.hpp"
#include "tests/contract/barrett_rig.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tools/bring_up/finger/calibrate_finger.hpp"

using namespace colift;
using Catch::Matchers::Contains;
using hal::barrett::Puck;

namespace {

constexpr double kScale = 1.3;  // gauges of two hands differ by as much

sim_hal::HandEmulatorConfig emulator() {
  sim_hal::HandEmulatorConfig config;
  config.puck.strain_scale = {1.0, kScale, 1.0};
  return config;
}

hal::HandCalibration one_puck(int serial) {
  hal::HandCalibration calibration;
  hal::PuckScale scale;
  scale.serial = serial;
  scale.finger = "F2";
  scale.strain_scale = kScale;
  scale.strain_points = 3;
  calibration.take(scale);
  return calibration;
}

}  // namespace

TEST_CASE("a line through 0 is found, and what is none is refused", "[hand][calibration]") {
  const std::vector<hal::ScalePoint> good{{0.0, 0.0}, {0.2, 0.25}, {0.4, 0.5}, {0.6, 0.75}};
  const auto fit = hal::fit_scale(good);
  REQUIRE(fit);
  CHECK(fit->scale == Approx(0.8));
  CHECK(fit->residual < 1e-9);
  const auto why = [](std::vector<hal::ScalePoint> points) {
    const auto refused = hal::fit_scale(points);
    return refused ? "accepted" : refused.error().detail;
  };
  CHECK_THAT(why({{0.0, 0.0}, {0.4, 0.4}}), Contains("two different torques"));
  CHECK_THAT(why({{0.2, 0.0}, {0.4, 0.0}}), Contains("does not grow"));
  CHECK_THAT(why({{0.2, -0.2}, {0.4, -0.4}}), Contains("does not grow"));
  CHECK_THAT(why({{0.2, 0.6}, {0.4, 0.1}, {0.6, 0.3}}), Contains("no line"));
  CHECK_THAT(why({{0.2, NAN}, {0.4, 0.1}}), Contains("not measured"));
}

TEST_CASE("what was measured of a puck stays with its serial number, whatever is measured later",
          "[hand][calibration]") {
  hal::HandCalibration calibration = one_puck(112);
  hal::PuckScale other;
  other.serial = 113;
  other.torque_units_per_nm = 2700.0;
  other.torque_points = 4;
  calibration.take(other);
  hal::PuckScale again;  // its motor alone
  again.serial = 112;
  again.torque_units_per_nm = 3100.0;
  again.torque_points = 3;
  calibration.take(again);
  const auto read = hal::parse_hand_calibration(text_of(calibration), "hand.yaml");
  INFO((read ? "" : read.error().text()));
  REQUIRE(read);
  REQUIRE(read->pucks.size() == 2);
  CHECK(read->of(112)->strain_scale == Approx(kScale));
  CHECK(read->of(112)->torque_units_per_nm == Approx(3100.0));
  CHECK(read->of(113)->strain_points == 0);
  CHECK(read->of(114) == nullptr);
}

TEST_CASE("a file that is none gets its place", "[hand][calibration]") {
  const auto why = [](const std::string& yaml) {
    const auto refused = hal::parse_hand_calibration(yaml, "hand.yaml");
    return refused ? "accepted" : refused.error().text();
  };
  CHECK_THAT(why(""), Contains("schema"));
  CHECK_THAT(why("schema: colift.hand_calibration/1\npucks:\n  - {serial: 0}\n"), Contains("hand.yaml:3"));
  CHECK_THAT(why("schema: colift.hand_calibration/1\npucks:\n  - {serial: 7, strain_scale: 9}\n"),
             Contains("0.2 to 5"));
  CHECK_THAT(why("schema: colift.hand_calibration/1\npucks: [{serial: 7}, {serial: 7}]\n"),
             Contains("twice"));
}

TEST_CASE("a finger is measured with weights and presses by itself, and its scale is found",
          "[hand][calibration]") {
  BarrettRig rig(/*with_object=*/true, {}, emulator());
  REQUIRE(rig.hand->configure());
  REQUIRE(rig.hand->activate());
  rig.hand->deactivate();
  tools::FingerCalibration what{Puck::F2, {0.2, 0.4, 0.6}, /*press=*/true, "2026-01-01"};
  std::vector<std::string> said;
  const auto result =
      tools::calibrate_finger(*rig.client, rig.clock, {}, what, [&](const std::string& words) {
        // the person does what he is told
        const std::size_t step = said.size();
        rig.pucks.hang(1, step >= 1 && step <= what.torques_nm.size() ? what.torques_nm[step - 1] : 0.0);
        said.push_back(words);
        return hal::Result<>();
      });
  INFO((result ? "" : result.error().text()));
  REQUIRE(result);
  CHECK(said.size() == 5);
  CHECK_THAT(said[1], Contains("0.20 N m") && Contains("0.41 kg"));
  CHECK(result->scale.serial == 112);
  CHECK(result->scale.strain_scale == Approx(kScale).epsilon(0.03));
  CHECK(result->scale.strain_points == 3);
  CHECK(result->scale.torque_points >= 2);
  CHECK(result->scale.torque_units_per_nm > 1000.0);
  CHECK(rig.pucks.puck(1).value(8) == 0);  // MODE: its motor rests
}

TEST_CASE("a calibrated hand measures and grips with true torques, another hand's file changes nothing",
          "[hand][calibration]") {
  const bool own = GENERATE(true, false);
  const tests::TemporaryFolder folder;
  hal::BarrettHandConfig config;
  config.calibration_file = folder.write("hand.yaml", text_of(one_puck(own ? 112 : 999))).string();
  BarrettRig rig(/*with_object=*/false, config, emulator());
  const auto configured = rig.hand->configure();
  INFO((configured ? "" : configured.error().text()));
  REQUIRE(configured);
  REQUIRE(rig.hand->activate());
  rig.pucks.hang(1, 0.5);
  rig.pass(std::chrono::milliseconds(300));
  const auto state = rig.hand->state();
  REQUIRE(state);
  CHECK(state->torque_nm[1] == Approx(own ? 0.5 : 0.5 / kScale).epsilon(0.03));
  const std::string remark = rig.driver->report().remark.str();
  CHECK_THAT(remark, Contains("F1 (puck 111) is not in"));
  CHECK((remark.find("F2 (puck 112)") == std::string::npos) == own);
}

TEST_CASE("one finger moved by the service measures true torques too", "[hand][calibration]") {
  const bool own = GENERATE(true, false);
  const tests::TemporaryFolder folder;
  hal::BarrettHandConfig config;
  BarrettRig rig(/*with_object=*/false, config, emulator());
  REQUIRE(rig.hand->configure());
  REQUIRE(rig.hand->activate());
  rig.hand->deactivate();
  config.calibration_file = folder.write("hand.yaml", text_of(one_puck(own ? 112 : 999))).string();
  hal::FingerMotion motion;
  motion.kind = hal::FingerMotion::Kind::Velocity;
  motion.finger = hal::barrett::Puck::F2;
  motion.value = 0.2;
  motion.torque_nm = 0.5;
  // it is asked from when the finger moves: the load comes then
  const auto end = hal::move_finger(*rig.client, rig.clock, config, motion, [&] {
    rig.pucks.hang(1, 0.3);
    return false;
  });
  INFO((end ? "" : end.error().text()));
  REQUIRE(end);
  CHECK(end->max_torque_nm == Approx(own ? 0.3 : 0.3 / kScale).epsilon(0.05));
}

TEST_CASE("a calibration file that is not there refuses the hand", "[hand][calibration]") {
  hal::BarrettHandConfig config;
  config.calibration_file = "/nowhere/hand.yaml";
  BarrettRig rig(false, config);
  const auto configured = rig.hand->configure();
  REQUIRE_FALSE(configured);
  CHECK_THAT(configured.error().text(), Contains("/nowhere/hand.yaml"));
}
