#include "control/session/share_contract.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "control/session/decide.hpp"
#include "control/session/place_words.hpp"
#include "hal/types/units.hpp"

namespace colift::control {
namespace {

using hal::Vec3;

constexpr double kPlaceStep_m = 0.02;  // along the object's edges: a quarter of a hand

void add_line(const Vec3& from, const Vec3& to, std::vector<Vec3>& places) {
  const int n = std::max(1, static_cast<int>(std::ceil((to - from).norm() / kPlaceStep_m)));
  for (int i = 0; i <= n; ++i) places.push_back(from + (to - from) * (static_cast<double>(i) / n));
}

// Where a hand can hold the object: along the edges of its faces, along pipes, and where the robot's hand
// could, if it were there.
std::vector<Vec3> hand_places(const SceneAnalysis& analysis, const planner::UncertainScene& scene,
                              double max_height_m) {
  std::vector<Vec3> all;
  for (const planner::GraspCandidate& c : analysis.candidates) all.push_back(c.position);
  for (const perception::Surface& surface : analysis.scene.surfaces) {
    if (const auto* pipe = std::get_if<perception::Cylinder>(&surface)) {
      const Vec3 half = 0.5 * pipe->length * pipe->axis, top = pipe->center + pipe->radius * scene.up;
      add_line(top - half, top + half, all);
      continue;
    }
    const auto& face = std::get<perception::Rectangle>(surface);
    const Vec3 u = 0.5 * face.size.x() * face.u, v = 0.5 * face.size.y() * face.v;
    const Vec3 corners[] = {face.center + u + v, face.center - u + v, face.center - u - v,
                            face.center + u - v};
    for (int i = 0; i < 4; ++i) add_line(corners[i], corners[(i + 1) % 4], all);
  }
  std::erase_if(all, [&](const Vec3& p) { return std::abs(scene.up.dot(p - scene.partner)) > max_height_m; });
  return all;
}

double lever(const Vec3& partner, const Vec3& robot, const planner::UncertainScene& scene) {
  const Vec3 normal = scene.up.cross(robot - partner);
  return normal.norm() > 0.0 ? std::abs(normal.normalized().dot(scene.cog - partner)) : 0.0;
}

// The place nearest to his hand from which one of the robot's grasps bears the wanted share.
std::optional<ShareContract::Place> find_place(const SceneAnalysis& analysis,
                                               const planner::LimitedSharing& sharing,
                                               const planner::UncertainScene& scene,
                                               const planner::DecisionConfig& config,
                                               std::optional<double> mass_kg) {
  std::vector<Vec3> places = hand_places(analysis, scene, config.ask_height_m);
  std::stable_sort(places.begin(), places.end(), [&](const Vec3& a, const Vec3& b) {
    return (a - scene.partner).squaredNorm() < (b - scene.partner).squaredNorm();
  });
  const hal::Wrench lift{config.mass_kg * hal::kGravity_m_s2 * scene.up, Vec3::Zero()};
  for (const Vec3& place : places) {
    std::optional<ShareContract::Place> best;
    for (const planner::GraspCandidate& c : analysis.candidates) {
      if (c.verdict != planner::Verdict::Ok && c.verdict != planner::Verdict::Chosen) continue;
      const Vec3 robot = planner::load_point(c);
      if ((c.position - place).norm() < config.near_partner_m) continue;
      if (lever(place, robot, scene) > config.max_lever_m) continue;
      const auto s = planner::lever_share(scene.cog, place, robot, scene.up);
      if (!s || std::abs(*s - *config.share) > config.share_window) continue;
      if (mass_kg && (1.0 - *s) * *mass_kg * hal::kGravity_m_s2 > config.partner_load_n) continue;
      if (!sharing.wrenches(place - scene.cog, robot - scene.cog, lift)) continue;
      if (!best || std::abs(*s - *config.share) < std::abs(best->share - *config.share))
        best = ShareContract::Place{place, robot, *s};
    }
    if (best) return best;
  }
  return std::nullopt;
}

std::string percent(double share) {
  return fmt::format("{:.0f}", 100.0 * share);
}

std::string range_text(const planner::ShareRange& r) {
  const std::string low = percent(r.low), high = percent(r.high);
  return low == high ? low + " %" : low + " to " + high + " %";
}

std::string text_of(const ShareContract& c, const planner::UncertainScene& scene, double window) {
  std::string text;
  if (c.wanted) text = percent(*c.wanted) + " % asked: ";
  if (!c.reachable) {
    text += "no share is possible as the partner holds the object";
  } else {
    text += range_text(*c.reachable) + (c.reachable->low == c.reachable->high ? " is" : " are") +
            " possible as the partner holds the object";
  }
  if (c.predicted) {
    text += fmt::format(", {} % predicted", percent(*c.predicted));
    if (c.interval) text += fmt::format(" (95 %: {})", range_text(*c.interval));
  }
  if (c.as_wished) {
    const double off = std::abs(*c.predicted - *c.wanted);
    if (*c.as_wished)
      text += fmt::format(", as wished to within {:.0f} %", std::ceil(100.0 * c.tolerance));
    else if (off <= window)
      text += ", not certain enough to be called as wished";
    else
      text += fmt::format(", {:.0f} % off what was asked", 100.0 * off);
  }
  if (c.elsewhere) {
    const Vec3& p = c.elsewhere->partner;
    const std::string path = place_words(scene.partner, p, scene.cog.head<2>());
    text += fmt::format("; {} % if the partner grasped at ({:.2f}, {:.2f}, {:.2f}) m{}{}",
                        percent(c.elsewhere->share), p.x(), p.y(), p.z(), path.empty() ? "" : ", ", path);
  } else if (c.searched) {
    text += fmt::format("; no place of the partner was found with which {} % would be", percent(*c.wanted));
  }
  return text;
}

std::string partner_text_of(const ShareContract& c) {
  const std::string limit =
      c.partner_limit_n ? fmt::format("limit {:.0f} N", *c.partner_limit_n) : "no limit";
  if (!c.mass_kg)
    return fmt::format("partner's load not known before the lift, because the mass is not ({})", limit);
  if (!c.partner_load_n) return fmt::format("partner's load not predicted: no grasp ({})", limit);
  return fmt::format("the partner would bear {:.0f} N of {:.1f} kg ({})", *c.partner_load_n, *c.mass_kg,
                     limit);
}

}  // namespace

ShareContract share_contract(const Outcome& outcome, const SceneAnalysis& analysis,
                             const planner::UncertainScene& scene, const Config& settings,
                             std::optional<double> mass_kg) {
  const planner::DecisionConfig& config = settings.decision;
  ShareContract c;
  const planner::Decision& d = outcome.decision;
  c.wanted = config.share;
  c.mass_kg = mass_kg ? mass_kg : config.known_mass_kg;
  if (std::isfinite(config.partner_load_n)) c.partner_limit_n = config.partner_load_n;
  c.reachable = planner::reachable_shares(outcome.candidates, d.scores);
  const auto unlimited = planner::LoadSharing::create(config.weights);
  const auto sharing = unlimited ? planner::LimitedSharing::create(*unlimited, config.limits)
                                 : tl::unexpected(unlimited.error());
  if (!sharing) return c;  // the decision has failed with the same error
  if (d.chosen) {
    c.certificate = certify(
        forecast_lift(scene, outcome.candidates[*d.chosen], d.share,
                      analysis.finder ? analysis.finder->hand() : planner::HandModel{}, config, c.mass_kg),
        settings.certificate, certificate_limits(settings));
    c.predicted = d.share;
    c.interval = c.certificate->share;
    const double half = std::max(d.share - c.interval->low, c.interval->high - d.share);
    c.tolerance = config.share_window + half;
    if (c.mass_kg) c.partner_load_n = (1.0 - d.share) * *c.mass_kg * hal::kGravity_m_s2;
    if (c.wanted)
      c.as_wished = std::abs(d.share - *c.wanted) <= config.share_window + 1e-9 && half <= config.share_sure;
  }
  const auto nearest =
      c.wanted ? planner::nearest_share(outcome.candidates, d.scores, *c.wanted) : std::nullopt;
  const bool reached = nearest && std::abs(*nearest - *c.wanted) <= config.share_window;
  c.searched = c.wanted && !reached;
  if (c.searched) c.elsewhere = find_place(analysis, *sharing, scene, config, c.mass_kg);
  c.text = text_of(c, scene, config.share_window);
  c.partner_text = partner_text_of(c);
  return c;
}

void refuse_beyond_limits(Outcome& outcome, const CertificateConfig& config) {
  planner::Decision& d = outcome.decision;
  const auto& certificate = outcome.share.certificate;
  if (config.on_breach != "refuse" || !d.chosen || !certificate || certificate->breaches.empty()) return;
  planner::GraspCandidate& c = outcome.candidates[*d.chosen];
  d.reason =
      fmt::format("no grasp: of the best one, candidate {}, {} (95 %)", c.id, certificate->breach_text);
  c.verdict = planner::Verdict::OverLimit;
  c.reason = certificate->breach_text;
  d.chosen.reset();
}

void say_share(Outcome& outcome) {
  planner::Decision& d = outcome.decision;
  if (!outcome.share.wanted) return;
  d.reason += "; " + outcome.share.text;
  if (d.chosen) outcome.candidates[*d.chosen].reason = d.reason;
}

}  // namespace colift::control
