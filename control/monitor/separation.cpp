#include "control/monitor/separation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace colift::control {
namespace {

struct Region {
  double stiffness_n_m, mass_kg, limit_n;
};

// ISO/TS 15066 Annex A as secondary sources have it, in the order of BodyRegion; read the standard before use
constexpr std::array<Region, 10> kRegions{{{75e3, 0.6, 140},
                                           {40e3, 2.0, 160},
                                           {30e3, 3.0, 150},
                                           {10e3, 40.0, 110},
                                           {25e3, 40.0, 140},
                                           {35e3, 40.0, 210},
                                           {50e3, 75.0, 220},
                                           {60e3, 75.0, 130},
                                           {75e3, 4.4, 65},
                                           {150e3, 4.4, 130}}};

double constant_part(double person_m_s, double latency_s, const MonitorConfig& c) {
  return person_m_s * latency_s + c.intrusion_m + c.person_uncertainty_m + c.robot_uncertainty_m;
}

}  // namespace

double separation_distance(double robot_m_s, double person_m_s, double latency_s,
                           const MonitorConfig& config) {
  const double stop_s = robot_m_s / config.deceleration_m_s2;
  return constant_part(person_m_s, latency_s, config) + person_m_s * stop_s + robot_m_s * latency_s +
         0.5 * robot_m_s * stop_s;
}

double allowed_speed(double distance_m, double person_m_s, double latency_s, const MonitorConfig& config) {
  // v^2 / 2a + v (person / a + latency) + constant = distance
  const double left_m = distance_m - constant_part(person_m_s, latency_s, config);
  if (!(left_m > 0.0)) return 0.0;
  const double a = config.deceleration_m_s2, slope_s = person_m_s / a + latency_s;
  return a * (std::sqrt(slope_s * slope_s + 2.0 * left_m / a) - slope_s);
}

double contact_speed(BodyRegion region, double robot_kg) {
  const Region& of = kRegions[static_cast<std::size_t>(region)];
  const double mass_kg = 1.0 / (1.0 / of.mass_kg + 1.0 / robot_kg);
  return of.limit_n / std::sqrt(mass_kg * of.stiffness_n_m);
}

}  // namespace colift::control
