#include "control/certificate/certificate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "control/config/config.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

using Of = Certificate::Breach::Of;

double tilt_scale_deg(const LiftForecast& f, const CertificateConfig& c, const CertificateLimits& limits) {
  const double lead_rad = f.span_m > 0.0 ? std::atan(c.lead_m / f.span_m) : 0.5 * std::numbers::pi;
  return hal::rad_to_deg(lead_rad + c.turning * f.turning_nm / limits.grip_nm_rad);
}

double slip_scale_m(const LiftForecast& f, const CertificateConfig& c) {
  return c.slip_base_m * (1.0 + f.load_over_hold);
}

// of the robot's load; the share's and the mass's errors are independent
double load_sigma_n(const LiftForecast& f, const CertificateConfig& c) {
  return f.weight_n * std::hypot(f.share_sigma, f.share * c.mass_sigma);
}

std::string words(const Certificate::Breach& b) {
  switch (b.of) {
    case Of::Tilt:
      return fmt::format("the tilt may reach {:.1f} deg, {:.1f} are allowed", b.bound, b.limit);
    case Of::Slip:
      return fmt::format("the slip may reach {:.0f} mm, {:.0f} are allowed", 1e3 * b.bound, 1e3 * b.limit);
    case Of::Load:
      return fmt::format("the robot's load may reach {:.0f} N, {:.0f} are allowed", b.bound, b.limit);
    case Of::PartnerLoad:
      break;
  }
  return fmt::format("the partner's load may reach {:.0f} N, {:.0f} are allowed", b.bound, b.limit);
}

}  // namespace

CertificateLimits certificate_limits(const Config& config) {
  CertificateLimits limits;
  limits.grip_nm_rad = config.test_lift.belief.grip_nm_rad;
  limits.max_tilt_deg = config.task.max_tilt_deg;
  limits.max_slip_m = config.task.max_slip_m;
  limits.max_load_n = config.task.max_load_n;
  if (std::isfinite(config.decision.partner_load_n)) limits.partner_load_n = config.decision.partner_load_n;
  return limits;
}

Certificate certify(const LiftForecast& f, const CertificateConfig& config, const CertificateLimits& limits) {
  Certificate c;
  c.forecast = f;
  c.share = {std::clamp(f.share - config.share_below * f.share_sigma, 0.0, 1.0),
             std::clamp(f.share + config.share_above * f.share_sigma, 0.0, 1.0)};
  c.tilt_deg = config.tilt_factor * tilt_scale_deg(f, config, limits);
  c.slip_m = config.slip_factor * slip_scale_m(f, config);
  const auto check = [&](Of of, double bound, double limit) {
    if (bound > limit) c.breaches.push_back({of, bound, limit});
  };
  check(Of::Tilt, c.tilt_deg, limits.max_tilt_deg);
  check(Of::Slip, c.slip_m, limits.max_slip_m);
  std::string load = "load not known, because the mass is not";
  if (f.mass_known) {
    const double sigma = load_sigma_n(f, config);
    const double partner_n = (1.0 - f.share) * f.weight_n;
    const double partner_sigma = f.weight_n * std::hypot(f.share_sigma, (1.0 - f.share) * config.mass_sigma);
    c.load_n = {std::max(0.0, f.share * f.weight_n - config.load_below * sigma),
                f.share * f.weight_n + config.load_above * sigma};
    // what the robot bears less than expected, he bears more
    c.partner_load_n = {std::max(0.0, partner_n - config.load_above * partner_sigma),
                        partner_n + config.load_below * partner_sigma};
    check(Of::Load, c.load_n->high, limits.max_load_n);
    if (limits.partner_load_n) check(Of::PartnerLoad, c.partner_load_n->high, *limits.partner_load_n);
    load = fmt::format("robot {:.0f} to {:.0f} N, partner {:.0f} to {:.0f} N", c.load_n->low, c.load_n->high,
                       c.partner_load_n->low, c.partner_load_n->high);
  }
  c.text = fmt::format(
      "in 95 % of such lifts: share {:.0f} to {:.0f} %, tilt up to {:.1f} deg, slip up to "
      "{:.0f} mm; {}",
      100.0 * c.share.low, 100.0 * c.share.high, c.tilt_deg, std::ceil(1e3 * c.slip_m), load);
  for (const Certificate::Breach& b : c.breaches)
    c.breach_text += (c.breach_text.empty() ? "" : "; ") + words(b);
  return c;
}

CertificateScore certificate_score(const LiftForecast& f, double share, double load_n, double tilt_deg,
                                   double slip_m, const CertificateConfig& config,
                                   const CertificateLimits& limits) {
  CertificateScore s;
  s.share = (share - f.share) / f.share_sigma;
  s.load = (load_n - f.share * f.weight_n) / load_sigma_n(f, config);
  s.tilt = tilt_deg / tilt_scale_deg(f, config, limits);
  s.slip = slip_m / slip_scale_m(f, config);
  return s;
}

}  // namespace colift::control
