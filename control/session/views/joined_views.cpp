#include "control/session/views/joined_views.hpp"

#include <algorithm>
#include <cmath>

#include "control/session/views/in_box.hpp"
#include "hal/types/camera_name.hpp"

namespace colift::control {
namespace {

constexpr double kMaxOutside = 0.03;  // of another view's points: flying pixels at edges
constexpr double kUsualSigmas = 1.7;  // of a difference in three dimensions: square root of 3

using perception::PartnerGrasp;
using perception::PartnerKind;
using perception::PartnerObservation;

bool shows_grasp(const ViewOfPartner& view) {
  const PartnerObservation& seen = view.sighting.observation;
  return seen.kind == PartnerKind::Grasp && seen.grasp;
}

// Best linear estimate from two independent ones; their disagreement in standard deviations comes back. A
// singular covariance changes nothing.
double average(hal::Vec3& mean, Eigen::Matrix3d& covariance, const hal::Vec3& other,
               const Eigen::Matrix3d& other_covariance) {
  const Eigen::LDLT<Eigen::Matrix3d> solver(covariance + other_covariance);
  if (solver.info() != Eigen::Success || !(solver.vectorD().array() > 0.0).all()) return 0.0;
  const hal::Vec3 apart = other - mean;
  const Eigen::Matrix3d gain = solver.solve(covariance).transpose();
  mean += gain * apart;
  covariance -= (gain * covariance).eval();
  covariance = 0.5 * (covariance + covariance.transpose()).eval();
  return std::sqrt(std::max(0.0, apart.dot(solver.solve(apart))));
}

/// Parts of another view's points that lie outside of a view's completed shape, by what that view shows
/// there.
struct Outside {
  /// Nothing: the arm is before them, or the image ends. It misses a part of the object.
  double hidden = 0.0;
  /// Something, before, at or behind them, that it does not take for the object.
  double seen = 0.0;
};

Outside outside_of(const ViewOfObject& view, std::span<const Eigen::Vector3f> points, double margin_m) {
  const perception::OrganisedCloud& cloud = *view.cloud;
  Outside out;
  for (const Eigen::Vector3f& point : points) {
    const hal::Vec3 p = point.cast<double>();
    if (is_inside(view.target->shape, p, margin_m)) continue;
    const auto at = cloud.project(p);
    const bool seen =
        at.depth_m > 0.0 && cloud.contains(at.u, at.v) &&
        cloud.seen(static_cast<std::size_t>(std::lround(at.v)) * static_cast<std::size_t>(cloud.width()) +
                   static_cast<std::size_t>(std::lround(at.u)));
    (seen ? out.seen : out.hidden) += 1.0;
  }
  const double n = std::max<double>(1.0, static_cast<double>(points.size()));
  return {out.hidden / n, out.seen / n};
}

void add(PartnerGrasp& grasp, const PartnerGrasp& other) {
  average(grasp.position, grasp.covariance, other.position, other.covariance);
  grasp.points += other.points;
}

}  // namespace

PartnerSighting join_sightings(std::span<const ViewOfPartner> views, double same_hand_m) {
  const ViewOfPartner& lead = views.front();
  if (views.size() == 1) return lead.sighting;
  const auto found = std::ranges::find_if(views, shows_grasp);
  if (found == views.end()) {
    // a scene that moved says nothing about hands; where another view shows one, only this view has a defect
    if (lead.sighting.observation.kind == PartnerKind::ObjectMoved) return lead.sighting;
    PartnerSighting out = lead.sighting;
    bool gone = false;
    for (const ViewOfPartner& view : views) {
      out.hidden |= view.sighting.hidden;
      // a hand that one view saw, and of which nothing hides the place there, is gone
      gone |= view.sighting.seen_before && !view.sighting.hidden;
      if (!view.sighting.observation.hidden_edge) out.observation.hidden_edge.reset();
    }
    out.hidden &= !gone;
    return out;
  }
  PartnerSighting out = found->sighting;
  out.hidden = false;
  for (auto other = found + 1; other != views.end(); ++other) {
    if (!shows_grasp(*other)) continue;
    const PartnerGrasp& grasp = *other->sighting.observation.grasp;
    if ((grasp.position - out.observation.grasp->position).norm() <= same_hand_m)
      add(*out.observation.grasp, grasp);
  }
  if (&*found != &lead) {
    // each view shows another side of the hand: its middle there is not comparable
    out.observation.grasp->skin.reset();
    out.observation.pixels.clear();
    out.observation.reason += " (" + hal::camera_name(found->camera) + ")";
  }
  return out;
}

std::span<const perception::Body> JoinedBodies::join(std::span<const ViewOfBodies> views,
                                                     double same_body_m) {
  parts_.clear();
  bodies_.clear();
  points_.clear();
  for (std::size_t v = 0; v < views.size(); ++v)
    for (const perception::Body& body : views[v].bodies) parts_.push_back({v, &body, parts_.size()});
  for (std::size_t a = 0; a < parts_.size(); ++a)
    for (std::size_t b = a + 1; b < parts_.size(); ++b) {
      if (parts_[a].view == parts_[b].view || parts_[a].group == parts_[b].group) continue;
      if (parts_[a].body->box.exteriorDistance(parts_[b].body->box) > same_body_m) continue;
      const std::size_t from = parts_[b].group, to = parts_[a].group;
      for (Part& part : parts_)
        if (part.group == from) part.group = to;
    }
  for (std::size_t group = 0; group < parts_.size(); ++group) {
    perception::Body joined;
    joined.first = points_.size();
    joined.whole = joined.top_seen = false;
    hal::Vec3 sum = hal::Vec3::Zero();
    double weight = 0.0;
    for (const Part& part : parts_) {
      if (part.group != group) continue;
      const perception::Body& body = *part.body;
      const auto points = views[part.view].points.subspan(body.first, body.count);
      points_.insert(points_.end(), points.begin(), points.end());
      joined.box.extend(body.box);
      joined.area_m2 = std::max(joined.area_m2, body.area_m2);
      joined.whole |= body.whole;
      joined.top_seen |= body.top_seen;
      sum += body.area_m2 * body.center;
      weight += body.area_m2;
    }
    joined.count = points_.size() - joined.first;
    if (joined.count == 0) continue;
    joined.center = sum / weight;
    bodies_.push_back(joined);
  }
  std::ranges::stable_sort(bodies_, std::ranges::greater{}, &perception::Body::area_m2);
  return bodies_;
}

void join_cogs(std::span<const ViewOfObject> views, double margin_m) {
  const ViewOfObject& first = views.front();
  perception::Target& target = *first.target;
  bool whole = true;
  std::vector<const perception::Target*> usable;
  Eigen::Matrix3d contradiction = Eigen::Matrix3d::Zero();
  for (const ViewOfObject& other : views.subspan(1)) {
    const Outside of_first = outside_of(first, other.target->points, margin_m),
                  of_other = outside_of(other, target.points, margin_m);
    if (of_first.seen > kMaxOutside || of_other.seen > kMaxOutside) {
      const hal::Vec3 half = 0.5 * (other.target->cog - target.cog);
      contradiction += half * half.transpose();
    } else if (of_other.hidden <= kMaxOutside) {
      usable.push_back(other.target);
      whole = whole && of_first.hidden <= kMaxOutside;
    }
  }
  hal::Vec3 cog = target.cog;
  Eigen::Matrix3d covariance = target.cog_covariance;
  if (!whole) {
    cog = usable.front()->cog;
    covariance = usable.front()->cog_covariance;
    usable.erase(usable.begin());
  }
  for (const perception::Target* other : usable) {
    const double sigmas = average(cog, covariance, other->cog, other->cog_covariance);
    if (sigmas > kUsualSigmas) covariance *= sigmas * sigmas / (kUsualSigmas * kUsualSigmas);
  }
  target.cog = cog;
  target.cog_covariance = covariance + contradiction;
}

}  // namespace colift::control
