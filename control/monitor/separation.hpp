#pragma once

#include "control/config/monitor_config.hpp"

namespace colift::control {

/// Distance (m) at which a robot of this speed and a person of that speed towards it have to be apart, so
/// that the robot is at rest before they meet; `latency_s`: from exposure to the begin of the stop. Source:
/// ISO/TS 15066 5.5.4, with constant deceleration.
[[nodiscard]] double separation_distance(double robot_m_s, double person_m_s, double latency_s,
                                         const MonitorConfig& config);

/// The fastest robot speed (m/s) whose separation distance is within `distance_m`; 0 where there is none.
[[nodiscard]] double allowed_speed(double distance_m, double person_m_s, double latency_s,
                                   const MonitorConfig& config);

/// Regions of the body for power and force limiting.
enum class BodyRegion { Hand, LowerArm, UpperArm, Abdomen, Chest, Back, Thigh, LowerLeg, Face, Skull };

/// The fastest speed (m/s) of a transient contact with a region whose force stays within the quasi-static
/// limit: v = F / sqrt(mu k), 1 / mu = 1 / m_region + 1 / m_robot. `robot_kg`: effective mass, half of the
/// arm's and what the hand carries. Source: the model of ISO/TS 15066 Annex A; transient contact may be twice
/// that, but for the head, and none of it is used here.
[[nodiscard]] double contact_speed(BodyRegion region, double robot_kg);

}  // namespace colift::control
