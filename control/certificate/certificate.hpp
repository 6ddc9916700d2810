#pragma once

#include <optional>
#include <string>
#include <vector>

#include "control/certificate/lift_forecast.hpp"
#include "control/config/certificate_config.hpp"
#include "planner/grasp/share_choice.hpp"

namespace colift::control {

struct Config;

/// What the bounds are compared with; unset: no limit.
struct CertificateLimits {
  double grip_nm_rad = 60.0;  ///< Rotational stiffness of the hands' hold.
  double max_tilt_deg = 5.0;
  double max_slip_m = 0.02;
  double max_load_n = 60.0;              ///< Of the robot.
  std::optional<double> partner_load_n;  ///< Of the partner.
};

[[nodiscard]] CertificateLimits certificate_limits(const Config& config);

/// Bounds of a lift, said before the hand closes. Each holds in 95 % of lifts like those of the calibration.
struct Certificate {
  /// A bound that is beyond its limit.
  struct Breach {
    enum class Of { Tilt, Slip, Load, PartnerLoad } of = Of::Tilt;
    double bound = 0.0, limit = 0.0;  ///< deg, m, N, N.
  };

  LiftForecast forecast;
  planner::ShareRange share;  ///< Of the robot.
  double tilt_deg = 0.0;      ///< Max tilt of the object while it is carried.
  double slip_m = 0.0;        ///< Max slip in the robot's hand.
  /// Load of the robot's hand and of the partner (N): low and high. Unset: the mass is not known.
  struct LoadRange {
    double low = 0.0, high = 0.0;
  };
  std::optional<LoadRange> load_n, partner_load_n;
  std::vector<Breach> breaches;
  std::string text;         ///< As a person would say it.
  std::string breach_text;  ///< "the tilt may reach 6.1 deg, 5.0 are allowed"; empty without a breach.
};

[[nodiscard]] Certificate certify(const LiftForecast& forecast, const CertificateConfig& config,
                                  const CertificateLimits& limits);

/// Truth over scale: what `config`'s factors are quantiles of.
struct CertificateScore {
  double share = 0.0, load = 0.0;  ///< Standard deviations, signed.
  double tilt = 0.0, slip = 0.0;   ///< Over their scales, not negative.
};

/// Of a lift that was made. `load_n`: of the hand; NaN stays NaN.
[[nodiscard]] CertificateScore certificate_score(const LiftForecast& forecast, double share, double load_n,
                                                 double tilt_deg, double slip_m,
                                                 const CertificateConfig& config,
                                                 const CertificateLimits& limits);

}  // namespace colift::control
