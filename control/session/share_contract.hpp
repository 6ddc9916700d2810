#pragma once

#include <optional>
#include <string>

#include "control/certificate/certificate.hpp"
#include "control/config/config.hpp"
#include "hal/types/geometry.hpp"
#include "planner/grasp/robust_choice.hpp"
#include "planner/grasp/share_choice.hpp"

namespace colift::control {

struct Outcome;
struct SceneAnalysis;

/// The robot's share of the load before anything moves: what was asked for, what can be had as the partner
/// holds the object, what is expected of the chosen grasp and how certain that is. Shares 0 to 1.
struct ShareContract {
  /// With the partner's hand there, one of the robot's grasps would give the wanted share.
  struct Place {
    hal::Vec3 partner = hal::Vec3::Zero(), robot = hal::Vec3::Zero();  ///< W, m.
    double share = 0.0;
  };

  std::optional<double> wanted;
  std::optional<planner::ShareRange> reachable;  ///< Over all feasible candidates; unset: there is none.
  std::optional<double> predicted;               ///< Of the chosen candidate.
  /// 95 % of the prediction: that of the certificate.
  std::optional<planner::ShareRange> interval;
  /// Whether the prediction may be called the wanted share: within share_window of it, and the half width of
  /// the interval within share_sure. Unset where none is wanted or nothing was chosen.
  std::optional<bool> as_wished;
  double tolerance = 0.0;          ///< Of that claim: share_window and the interval's half width.
  std::optional<Place> elsewhere;  ///< Where the wanted share is not reachable; unset: found none.
  bool searched = false;          ///< Whether such a place was looked for: the wanted share is not reachable.
  std::optional<double> mass_kg;  ///< That the partner's load is computed for; unset: unknown.
  std::optional<double> partner_load_n;    ///< Predicted, vertical; unset where the mass is unknown.
  std::optional<double> partner_limit_n;   ///< Unset: no limit.
  std::string text;                        ///< The shares, as a person would say them.
  std::string partner_text;                ///< The partner's load and its limit.
  std::optional<Certificate> certificate;  ///< Of the chosen grasp; unset: nothing was chosen.
};

/// Of a decision. `scene`: what it believes, with covariances. `mass_kg`: where it is known beside
/// config.decision.known_mass_kg.
[[nodiscard]] ShareContract share_contract(const Outcome& outcome, const SceneAnalysis& analysis,
                                           const planner::UncertainScene& scene, const Config& config,
                                           std::optional<double> mass_kg);

/// Takes back the choice of a grasp whose certificate is beyond a limit, where `on_breach` is "refuse"; the
/// decision's reason then says the number.
void refuse_beyond_limits(Outcome& outcome, const CertificateConfig& config);

/// Adds the shares to the decision's reason where one is wanted.
void say_share(Outcome& outcome);

}  // namespace colift::control
