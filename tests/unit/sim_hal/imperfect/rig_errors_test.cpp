#include "sim_hal/imperfect/rig_errors.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "hal/config/config_file.hpp"
#include "hal/types/units.hpp"
#include "sim_hal/imperfect/imperfect_devices.hpp"
#include "sim_hal/mock/mock_arm.hpp"

using namespace colift;
using namespace colift::sim_hal;

namespace {

const std::string kShipped = COLIFT_SOURCE_DIR "/config/rig/imperfect.yaml";

/// The shipped file with one text in place of another.
std::string refused(const std::string& text, const std::string& by) {
  std::string yaml = hal::read_yaml_file(kShipped).value();
  const auto at = yaml.find(text);
  REQUIRE(at != std::string::npos);
  yaml.replace(at, text.size(), by);
  const auto figures = parse_rig_figures(yaml, "rig.yaml");
  REQUIRE_FALSE(figures);
  CHECK(figures.error().code == hal::ErrorCode::BadConfig);
  CAPTURE(figures.error().text());
  return figures.error().text();
}

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("the rig that is compiled in is the shipped file") {
  const auto built_in = load_rig_figures("imperfect"), shipped = load_rig_figures(kShipped);
  REQUIRE(built_in);
  REQUIRE(shipped);
  CHECK(built_in->tool_mass_kg == 0.3);
  CHECK(built_in->tool_mass_kg == shipped->tool_mass_kg);
  CHECK(built_in->rotation_deg == shipped->rotation_deg);
  CHECK(built_in->friction_max == 0.9);
}

TEST_CASE("a rig's file that is wrong is refused with its place") {
  const std::string unknown = refused("torque_bias:", "torque_bais:");
  CHECK(has(unknown, "rig.yaml:5:"));
  CHECK(has(unknown, "torque_bias"));  // the nearest name
  CHECK(has(refused("value: 0.3, unit: kg", "value: 30, unit: kg"), "rig.yaml:8:"));
  CHECK(has(refused("value: 0.3, unit: kg", "value: -0.3, unit: kg"), "rig.yaml:8:"));
  CHECK(has(refused("unit: kg", "unit: g"), "kg"));
  CHECK(has(refused("value: 0.3, unit: kg, ", "value: 0.3, "), "unit"));
  CHECK(has(refused("source: \"assumed: capacitive pads\"", "source: \"\""), "hand.tactile_drift.source"));
  CHECK(has(refused("colift.rig/1", "colift.rig/2"), "colift.rig/1"));
  CHECK(has(refused("friction_min: {value: 0.3", "friction_min: {value: 1.3"), "friction"));
  CHECK_FALSE(load_rig_figures("no/such/rig.yaml"));
}

TEST_CASE("errors of a rig are those of its seed, and as large as the file says") {
  const RigFigures f = load_rig_figures("imperfect").value();
  const RigErrors a = draw_rig_errors(f, 3), b = draw_rig_errors(f, 3), c = draw_rig_errors(f, 4);
  CHECK(a.arm.torque_bias_nm == b.arm.torque_bias_nm);
  CHECK(a.camera.X_CK.matrix() == b.camera.X_CK.matrix());
  CHECK(a.arm.torque_bias_nm != c.arm.torque_bias_nm);
  CHECK(a.arm.torque_bias_nm.cwiseAbs().maxCoeff() <= f.torque_bias_nm);
  CHECK(std::abs(a.arm.tool_mass_kg) == f.tool_mass_kg);
  CHECK(a.camera.X_CK.translation().norm() == Approx(f.position_m));
  CHECK(Eigen::AngleAxisd(a.camera.X_CK.linear()).angle() == Approx(hal::deg_to_rad(f.rotation_deg)));
  CHECK(a.friction >= f.friction_min);
  CHECK(a.friction <= f.friction_max);
}

TEST_CASE("an arm with no errors passes its values on, bit for bit, and one with a bias is off by it") {
  const auto at_rest = [](const ArmErrors& errors) {
    hal::ManualClock clock;
    const auto arm =
        make_imperfect_arm(std::make_unique<MockArm>(ArmScript{}, clock), hal::built_in_robot(), errors);
    REQUIRE(arm->configure());
    REQUIRE(arm->activate());
    return arm->wait_cycle().value();
  };
  const hal::ArmState ideal = at_rest({});
  CHECK(ideal.tau_external_nm == hal::JointVector::Zero());
  ArmErrors biased;
  biased.torque_bias_nm[1] = 0.25;
  const hal::ArmState off = at_rest(biased);
  CHECK(off.tau_nm[1] - ideal.tau_nm[1] == Approx(0.25));
  CHECK(off.tau_external_nm[1] == Approx(-0.25));
}
