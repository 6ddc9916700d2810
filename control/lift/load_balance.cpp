#include "control/lift/load_balance.hpp"

#include <fmt/format.h>

#include <cmath>

#include "hal/types/units.hpp"

namespace colift::control {
namespace {

using Vec2 = Eigen::Vector2d;

constexpr double kSigmas95 = 1.96;
constexpr double kSameHand_m = 0.05;  // nearer hands, less than a palm apart, hold no object between them
// a deviation of the mass beyond which its interval spans more than a factor of five: that is no measurement
constexpr double kMaxLogSigma = 0.4;

bool is_finite(const CarriedSample& s) {
  return s.wrench.force.allFinite() && s.wrench.torque.allFinite() && s.palm.allFinite() &&
         s.X_WTnow_WTref.matrix().allFinite();
}

// means over the samples
struct Balance {
  Vec2 moment = Vec2::Zero();         // m (c - p), level (kg m)
  hal::Vec3 arm = hal::Vec3::Zero();  // c - p as it hangs
  double force_n = 0.0;               // of the robot on the object, upwards
};

Balance mean_balance(std::span<const CarriedSample> samples, const KnownBefore& known) {
  Balance mean;
  const double part = 1.0 / static_cast<double>(samples.size());
  for (const CarriedSample& s : samples) {
    const hal::Vec3 partner = s.X_WTnow_WTref * known.partner, force = -s.wrench.force;
    const hal::Vec3 about = (s.palm - partner).cross(force) - s.wrench.torque;
    mean.moment += part / hal::kGravity_m_s2 * Vec2(-about.y(), about.x());
    mean.arm += part * (s.X_WTnow_WTref * known.cog - partner);
    mean.force_n += part * force.z();
  }
  return mean;
}

}  // namespace

const char* word(MassSource source) {
  switch (source) {
    case MassSource::Told:
      return "told";
    case MassSource::TestLift:
      return "test lift";
    case MassSource::Shape:
      break;
  }
  return "shape";
}

hal::Result<LoadEstimate> balance_load(std::span<const CarriedSample> samples, const KnownBefore& known,
                                       const LoadConfig& config) {
  const auto failure = [](hal::ErrorCode code, std::string why) {
    return hal::failure(code, "load", std::move(why));
  };
  if (samples.empty()) return failure(hal::ErrorCode::BadInput, "the object was never held up");
  for (const CarriedSample& s : samples)
    if (!is_finite(s)) return failure(hal::ErrorCode::BadInput, "a number is not finite");
  const Vec2 span = (known.grasp - known.partner).head<2>();
  if (!(span.norm() > kSameHand_m) || !known.cog.allFinite())
    return failure(hal::ErrorCode::BadInput, fmt::format("the hands are {:.0f} mm apart", 1e3 * span.norm()));
  const Vec2 line = span.normalized();

  const Balance mean = mean_balance(samples, known);
  const double product = mean.moment.dot(line);
  const double weight_nm = hal::kGravity_m_s2 * product;
  const double moment_sigma = std::hypot(config.moment_sigma, config.partner_torque_nm / weight_nm);
  const auto variance_along = [&](const Eigen::Matrix3d& c) {
    return line.dot(c.topLeftCorner<2, 2>() * line);
  };
  const double partner_variance = variance_along(known.partner_covariance);

  LoadEstimate out;
  double lever_m = mean.arm.head<2>().dot(line), log_sigma = config.known_mass_sigma;
  if (known.mass_kg) {
    out.source = MassSource::Told;
    out.mass_kg = *known.mass_kg;
    // the lever follows from the mass
    const double told_m = product / out.mass_kg;
    out.cog_sigma_m = std::hypot(told_m * std::hypot(moment_sigma, log_sigma), std::sqrt(partner_variance));
    out.cog = known.cog;
    out.cog.head<2>() += (told_m - lever_m) * line;
    lever_m = told_m;
  } else {
    out.source = known.weighed ? MassSource::TestLift : MassSource::Shape;
    const double variance = variance_along(known.cog_covariance);
    out.cog = known.cog;
    out.cog_sigma_m = std::sqrt(variance);
    log_sigma = std::hypot(moment_sigma, std::sqrt(variance + partner_variance) / lever_m);
    out.mass_kg = product / lever_m;
  }
  if (!(lever_m > 0.0) || !(product > 0.0) || !(mean.force_n > 0.0) || !(log_sigma < kMaxLogSigma))
    return failure(hal::ErrorCode::NotFound,
                   fmt::format("the robot carries {:.1f} N at a lever of {:.0f} mm from the partner's hand, "
                               "known to {:.0f} mm: that tells nothing of the mass",
                               mean.force_n, 1e3 * lever_m, 1e3 * out.cog_sigma_m));
  const double factor = std::exp(kSigmas95 * log_sigma);
  out.mass_95 = {out.mass_kg / factor, out.mass_kg * factor};
  const auto share = [&](double mass_kg) { return mean.force_n / (mass_kg * hal::kGravity_m_s2); };
  out.share_robot = share(out.mass_kg);
  // with the mass told it may be so: he presses down
  if (!known.mass_kg && out.share_robot > 1.0)
    return failure(
        hal::ErrorCode::NotFound,
        fmt::format("the robot would carry {:.0f} % of {:.1f} kg: the centre of gravity is not where "
                    "the scene shows it, or the partner presses down",
                    100 * out.share_robot, out.mass_kg));
  // with a mass that was told the force is one more measurement; else its error is that of the moment
  const double spread =
      std::exp(kSigmas95 * (known.mass_kg ? std::hypot(log_sigma, config.moment_sigma) : log_sigma));
  out.share_95 = {out.share_robot / spread, std::min(1.0, out.share_robot * spread)};
  return out;
}

}  // namespace colift::control
