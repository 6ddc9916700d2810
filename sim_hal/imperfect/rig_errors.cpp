#include "sim_hal/imperfect/rig_errors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "hal/config/config_file.hpp"
#include "hal/types/units.hpp"
#include "sim_hal/synthetic/hash_random.hpp"

namespace colift::sim_hal {
namespace {

using hal::Result;

constexpr std::uint64_t kStream = 8400;

/// One entry: a number nobody can say where it comes from is refused.
struct Figure {
  const char* wanted_unit;
  hal::Range range;
  double value = 0.0;
  std::string unit{}, source{};

  template <class Visitor>
  void visit(Visitor& v) {
    constexpr auto kRequired = hal::Presence::Required;
    v("value", value, range, "The figure, in its unit.", kRequired);
    v("unit", unit, hal::Choices{wanted_unit}, "Unit of the value.", kRequired);
    v("source", source, "Datasheet, paper, measurement, or \"assumed: why\".", kRequired);
  }
};

struct ArmBlock {
  Figure torque_bias{"N m", {0, 5}}, torque_hysteresis{"N m", {0, 5}}, torque_noise{"N m", {0, 2}},
      tool_mass{"kg", {0, 2}};
  template <class Visitor>
  void visit(Visitor& v) {
    v("torque_bias", torque_bias, "Zero error of each joint's torque.");
    v("torque_hysteresis", torque_hysteresis, "Half width of the play of each joint's torque.");
    v("torque_noise", torque_noise, "Standard deviation of each joint's torque in a cycle.");
    v("tool_mass", tool_mass, "Error of the tool's mass in the controller.");
  }
};

struct CameraBlock {
  Figure position{"m", {0, 0.1}}, rotation{"deg", {0, 10}}, focal_length{"1", {0, 0.1}},
      distortion{"1", {0, 0.2}}, depth_scale{"1", {0, 0.1}}, clock_skew{"s", {0, 0.2}};
  template <class Visitor>
  void visit(Visitor& v) {
    v("position", position, "Error of the calibrated position.");
    v("rotation", rotation, "Error of the calibrated orientation.");
    v("focal_length", focal_length, "Relative error of the focal lengths.");
    v("distortion", distortion, "Radial coefficient that nobody corrects.");
    v("depth_scale", depth_scale, "Relative error of the depth.");
    v("clock_skew", clock_skew, "Error of the time of exposure.");
  }
};

struct HandBlock {
  Figure strain_drift{"N m/min", {0, 5}}, tactile_drift{"N/min", {0, 50}};
  template <class Visitor>
  void visit(Visitor& v) {
    v("strain_drift", strain_drift, "Drift of the fingertip torque.");
    v("tactile_drift", tactile_drift, "Drift of a pad's force.");
  }
};

struct WorldBlock {
  Figure friction_min{"1", {0.05, 3}}, friction_max{"1", {0.05, 3}}, partner_min{"s", {0, 3600}},
      partner_max{"s", {0, 3600}};
  template <class Visitor>
  void visit(Visitor& v) {
    v("friction_min", friction_min, "Lowest coefficient of friction of the object.");
    v("friction_max", friction_max, "Highest coefficient of friction of the object.");
    v("partner_min", partner_min, "Earliest time at which the partner's hand is on the object.");
    v("partner_max", partner_max, "Latest time at which the partner's hand is on the object.");
  }
};

struct RigBlock {
  std::string schema;
  ArmBlock arm;
  CameraBlock camera;
  HandBlock hand;
  WorldBlock world;
  template <class Visitor>
  void visit(Visitor& v) {
    v("schema", schema, hal::Choices{"colift.rig/1"}, "What this file is.", hal::Presence::Required);
    v("arm", arm, "The arm and its controller.");
    v("camera", camera, "The camera and its calibration.");
    v("hand", hand, "The hand's sensors.");
    v("world", world, "Object and partner.");
  }
};

/// Uniform on the sphere, by rejection.
Vec3 direction(Draws& draws) {
  for (;;) {
    const double x = draws.between(-1, 1), y = draws.between(-1, 1), z = draws.between(-1, 1);
    const Vec3 v(x, y, z);
    if (v.norm() > 0.1 && v.norm() <= 1.0) return v.normalized();
  }
}

double either_sign(Draws& draws, double value) {
  return draws.chance(0.5) ? value : -value;
}

}  // namespace

Result<RigFigures> parse_rig_figures(const std::string& yaml, const std::string& name) {
  RigBlock b;
  hal::FieldTable table = hal::table_of(b);
  if (auto done = hal::apply_yaml_text(table, yaml, name); !done) return tl::unexpected(done.error());
  if (auto done = hal::check_fields(table, name); !done) return tl::unexpected(done.error());
  const std::pair<const char*, const Figure*> all[] = {
      {"arm.torque_bias", &b.arm.torque_bias},         {"arm.torque_hysteresis", &b.arm.torque_hysteresis},
      {"arm.torque_noise", &b.arm.torque_noise},       {"arm.tool_mass", &b.arm.tool_mass},
      {"camera.position", &b.camera.position},         {"camera.rotation", &b.camera.rotation},
      {"camera.focal_length", &b.camera.focal_length}, {"camera.distortion", &b.camera.distortion},
      {"camera.depth_scale", &b.camera.depth_scale},   {"camera.clock_skew", &b.camera.clock_skew},
      {"hand.strain_drift", &b.hand.strain_drift},     {"hand.tactile_drift", &b.hand.tactile_drift},
      {"world.friction_min", &b.world.friction_min},   {"world.friction_max", &b.world.friction_max},
      {"world.partner_min", &b.world.partner_min},     {"world.partner_max", &b.world.partner_max}};
  for (const auto& [path, figure] : all)
    if (figure->source.find_first_not_of(" \t") == std::string::npos)
      return hal::failure(hal::ErrorCode::BadConfig, name,
                          fmt::format("{}.source is empty; expected a datasheet, a paper or \"assumed: "
                                      "why\"",
                                      path));
  const auto ordered = [&](const char* what, double low, double high) -> Result<> {
    if (low <= high) return {};
    return hal::failure(
        hal::ErrorCode::BadConfig, name,
        fmt::format("world.{0}_min is {1} and world.{0}_max {2}; expected min <= max", what, low, high));
  };
  if (auto ok = ordered("friction", b.world.friction_min.value, b.world.friction_max.value); !ok)
    return tl::unexpected(ok.error());
  if (auto ok = ordered("partner", b.world.partner_min.value, b.world.partner_max.value); !ok)
    return tl::unexpected(ok.error());
  RigFigures f;
  f.torque_bias_nm = b.arm.torque_bias.value;
  f.torque_hysteresis_nm = b.arm.torque_hysteresis.value;
  f.torque_noise_nm = b.arm.torque_noise.value;
  f.tool_mass_kg = b.arm.tool_mass.value;
  f.position_m = b.camera.position.value;
  f.rotation_deg = b.camera.rotation.value;
  f.focal_length = b.camera.focal_length.value;
  f.distortion = b.camera.distortion.value;
  f.depth_scale = b.camera.depth_scale.value;
  f.clock_skew_s = b.camera.clock_skew.value;
  f.strain_drift_nm_min = b.hand.strain_drift.value;
  f.tactile_drift_n_min = b.hand.tactile_drift.value;
  f.friction_min = b.world.friction_min.value;
  f.friction_max = b.world.friction_max.value;
  f.partner_min_s = b.world.partner_min.value;
  f.partner_max_s = b.world.partner_max.value;
  return f;
}

Result<RigFigures> load_rig_figures(const std::filesystem::path& file) {
  if (file == "imperfect") {
    const std::string yaml =
#include "built_in_rig.inc"
        ;
    return parse_rig_figures(yaml, "imperfect.yaml");
  }
  const auto text = hal::read_yaml_file(file);
  if (!text) return tl::unexpected(text.error());
  return parse_rig_figures(*text, file.string());
}

RigErrors draw_rig_errors(const RigFigures& f, std::uint64_t seed) {
  RigErrors e;
  Draws arm(seed, kStream), camera(seed, kStream + 1), hand(seed, kStream + 2), world(seed, kStream + 3);
  for (int i = 0; i < hal::kArmJoints; ++i)
    e.arm.torque_bias_nm[i] = arm.between(-f.torque_bias_nm, f.torque_bias_nm);
  e.arm.tool_mass_kg = either_sign(arm, f.tool_mass_kg);
  e.arm.torque_hysteresis_nm = f.torque_hysteresis_nm;
  e.arm.torque_noise_nm = f.torque_noise_nm;
  e.arm.seed = seed;

  const Vec3 shift = f.position_m * direction(camera);
  const Vec3 axis = direction(camera);
  e.camera.X_CK.translate(shift).rotate(Eigen::AngleAxisd(hal::deg_to_rad(f.rotation_deg), axis));
  e.camera.focal_length = either_sign(camera, f.focal_length);
  e.camera.distortion = either_sign(camera, f.distortion);
  e.camera.depth_scale = either_sign(camera, f.depth_scale);
  e.camera.clock_skew_s = either_sign(camera, f.clock_skew_s);

  for (std::size_t i = 0; i < 3; ++i) {
    e.hand.strain_drift_nm_s[i] = hand.between(-f.strain_drift_nm_min, f.strain_drift_nm_min) / 60.0;
    e.hand.tactile_drift_n_s[i] = hand.between(-f.tactile_drift_n_min, f.tactile_drift_n_min) / 60.0;
  }
  e.friction = world.between(f.friction_min, f.friction_max);
  e.partner_arrives_s = world.between(f.partner_min_s, f.partner_max_s);
  return e;
}

Scenario with_errors(Scenario scenario, const RigErrors& errors) {
  scenario.object.friction = errors.friction;
  scenario.partner.arrives_s = errors.partner_arrives_s;
  return scenario;
}

}  // namespace colift::sim_hal
