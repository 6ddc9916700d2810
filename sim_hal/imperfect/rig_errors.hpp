#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>

#include "hal/types/geometry.hpp"
#include "hal/types/joints.hpp"
#include "hal/types/result.hpp"
#include "sim_hal/scenario/scenario.hpp"

namespace colift::sim_hal {

/// How wrong the devices of a rig are: the figures of a file of schema colift.rig/1, without units and
/// sources. All are bounds of a draw, none negative; 0: ideal.
struct RigFigures {
  double torque_bias_nm = 0, torque_hysteresis_nm = 0, torque_noise_nm = 0, tool_mass_kg = 0;
  double position_m = 0, rotation_deg = 0, focal_length = 0, distortion = 0, depth_scale = 0,
         clock_skew_s = 0;
  double strain_drift_nm_min = 0, tactile_drift_n_min = 0;
  double friction_min = 0, friction_max = 0, partner_min_s = 0, partner_max_s = 0;
};

/// What one rig, of one seed, has of them.
struct ArmErrors {
  hal::JointVector torque_bias_nm = hal::JointVector::Zero();
  double torque_hysteresis_nm = 0;  ///< Half width of the play.
  double torque_noise_nm = 0;       ///< Standard deviation.
  double tool_mass_kg = 0;          ///< That the controller believes the tool heavier.
  std::uint64_t seed = 0;           ///< Of the noise.
};
struct CameraErrors {
  hal::Pose X_CK = hal::Pose::Identity();  ///< Believed frame K in the true one C.
  double focal_length = 0, distortion = 0, depth_scale = 0;
  double clock_skew_s = 0;  ///< Added to the time of exposure.
};
struct HandErrors {
  std::array<double, 3> strain_drift_nm_s{}, tactile_drift_n_s{};
};
struct RigErrors {
  ArmErrors arm;
  CameraErrors camera;
  HandErrors hand;
  double friction = 0, partner_arrives_s = 0;
};

/// Reads a file of figures; "imperfect" is config/rig/imperfect.yaml, compiled in. Errors: BadConfig with
/// file:line:column and the nearest known name; a figure without its unit or source.
[[nodiscard]] hal::Result<RigFigures> load_rig_figures(const std::filesystem::path& file);
[[nodiscard]] hal::Result<RigFigures> parse_rig_figures(const std::string& yaml, const std::string& name);

/// Same figures and seed, same errors.
[[nodiscard]] RigErrors draw_rig_errors(const RigFigures& figures, std::uint64_t seed);

/// The scenario with the friction and the partner that were drawn.
[[nodiscard]] Scenario with_errors(Scenario scenario, const RigErrors& errors);

}  // namespace colift::sim_hal
