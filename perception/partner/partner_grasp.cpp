#include "perception/partner/partner_grasp.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace colift::perception {
namespace {

using hal::ErrorCode;
using hal::failure;

// Distances of bodies are read from a histogram of such bins: the resolution of nearest_m.
constexpr double kBin_m = 0.005;

// Pixels in which the object, grown by the reach, can appear.
PixelWindow window_around(const std::vector<Eigen::Vector3f>& points, double reach_m,
                          const OrganisedCloud& cloud) {
  hal::Aabb box;
  for (const auto& p : points) box.extend(p.cast<double>());
  box.min().array() -= reach_m;
  box.max().array() += reach_m;
  PixelWindow all{0, 0, cloud.width(), cloud.height()};
  double u0 = cloud.width(), v0 = cloud.height(), u1 = 0.0, v1 = 0.0;
  for (int i = 0; i < 8; ++i) {
    const auto at = cloud.project(box.corner(static_cast<hal::Aabb::CornerType>(i)));
    if (at.depth_m < 0.1) return all;
    u0 = std::min(u0, at.u);
    u1 = std::max(u1, at.u);
    v0 = std::min(v0, at.v);
    v1 = std::max(v1, at.v);
  }
  return {static_cast<int>(std::clamp(u0, 0.0, double(all.u_end))),
          static_cast<int>(std::clamp(v0, 0.0, double(all.v_end))),
          static_cast<int>(std::clamp(u1 + 1.0, 0.0, double(all.u_end))),
          static_cast<int>(std::clamp(v1 + 1.0, 0.0, double(all.v_end)))};
}

}  // namespace

hal::Result<PartnerFinder> PartnerFinder::make(const ReferenceImage& reference, const Target& target,
                                               const Ground& ground, const NoiseModel& noise,
                                               const PartnerConfig& config) {
  const OrganisedCloud& cloud = reference.cloud;
  std::vector<std::uint32_t> pixels;
  std::vector<Eigen::Vector3f> points;
  if (target.pixels.empty()) {
    for (const auto& p : target.points) {
      if (p.allFinite()) points.push_back(p);
    }
  }
  for (const std::uint32_t i : target.pixels) {
    if (i >= cloud.size()) {
      return failure(ErrorCode::BadInput, "partner: target",
                     fmt::format("pixel {} of the object lies outside of the reference image of {} x {}", i,
                                 cloud.width(), cloud.height()));
    }
    if (!cloud.seen(i)) continue;
    pixels.push_back(i);
    points.emplace_back(cloud.x[i], cloud.y[i], cloud.z[i]);
  }
  if (points.empty()) {
    return failure(ErrorCode::BadInput, "partner: target", "the object has no points in the reference image");
  }
  const PixelWindow window = window_around(points, config.reach_m, cloud);
  return PartnerFinder(reference, ground, noise, config, std::move(pixels), points, window);
}

PartnerFinder::PartnerFinder(const ReferenceImage& reference, const Ground& ground, const NoiseModel& noise,
                             const PartnerConfig& config, std::vector<std::uint32_t> pixels,
                             const std::vector<Eigen::Vector3f>& points, const PixelWindow& window)
    : config_(config),
      noise_(noise),
      ground_(ground),
      intrinsics_(reference.cloud.intrinsics),
      X_WC_(reference.cloud.X_WC),
      object_pixels_(std::move(pixels)),
      grid_(points, config.cell_m, std::max(config.clear_m, config.hand_thickness_m) + 0.02),
      change_(reference, noise, config.change, window) {
  object_far_m_.reserve(object_pixels_.size());
  for (const std::uint32_t i : object_pixels_) {
    const double z = reference.cloud.depth_m[i];
    object_far_m_.push_back(
        static_cast<float>(z + 4.0 * noise.sigma(z) + 2.0 * noise.step(z) + config.change.jump_m));
  }
  constexpr int kEvery = 6;  // a fraction of the view is as well known from every 36th pixel
  for (int v = window.v_begin; v < window.v_end; v += kEvery) {
    for (int u = window.u_begin + v % kEvery; u < window.u_end; u += kEvery) {
      const auto i = static_cast<std::size_t>(v) * static_cast<std::size_t>(reference.cloud.width()) +
                     static_cast<std::size_t>(u);
      const double z = reference.cloud.depth_m[i];
      if (!(z > 0.0)) continue;
      samples_.push_back(static_cast<std::uint32_t>(i));
      sample_far_m_.push_back(
          static_cast<float>(z + 4.0 * noise.sigma(z) + 2.0 * noise.step(z) + config.receded_m));
    }
  }
  find_rim(reference);
  number_patch_cells();
  skin_.reserve(50000);
}

// Where a hand can reach around: the outline, which are the object's pixels with something farther, or
// nothing, beside them; and inside of it the convex edges, which are the patches whose neighbours all lie
// behind them.
void PartnerFinder::find_rim(const ReferenceImage& reference) {
  const OrganisedCloud& cloud = reference.cloud;
  const int width = cloud.width(), height = cloud.height();
  const auto step = static_cast<float>(config_.outline_step_m);
  for (const std::uint32_t i : object_pixels_) {
    const int u = static_cast<int>(i) % width, v = static_cast<int>(i) / width;
    const float z = cloud.depth_m[i];
    const auto open = [&](int du, int dv) {
      if (u + du < 0 || u + du >= width || v + dv < 0 || v + dv >= height) return false;
      const float beside = cloud.depth_m[static_cast<std::size_t>(v + dv) * static_cast<std::size_t>(width) +
                                         static_cast<std::size_t>(u + du)];
      return !(beside <= z + step);
    };
    if ((u + v) % 2 != 0) continue;  // half of them are enough
    if (open(-2, 0) || open(2, 0) || open(0, -2) || open(0, 2))
      rim_.emplace_back(cloud.x[i], cloud.y[i], cloud.z[i]);
  }
}

bool PartnerFinder::same_camera(const OrganisedCloud& current) const {
  return current.width() == intrinsics_.width && current.height() == intrinsics_.height &&
         current.size() ==
             static_cast<std::size_t>(intrinsics_.width) * static_cast<std::size_t>(intrinsics_.height) &&
         current.x.size() == current.size() && current.X_WC.isApprox(X_WC_, 1e-6);
}

// Part of the object's pixels that now show something behind it.
double PartnerFinder::moved_part(const OrganisedCloud& current) const {
  if (object_pixels_.empty()) return 0.0;
  constexpr std::size_t kStride = 7;  // a fraction of the object is as well known from every 7th pixel
  std::size_t looked = 0, behind = 0;
  for (std::size_t i = 0; i < object_pixels_.size(); i += kStride) {
    ++looked;
    behind += current.depth_m[object_pixels_[i]] > object_far_m_[i] ? 1 : 0;
  }
  return static_cast<double>(behind) / static_cast<double>(looked);
}

// Part of the whole view that lies farther than in the reference. A person covers things and uncovers none; a
// camera that moved does both.
double PartnerFinder::receded_part(const OrganisedCloud& current) const {
  if (samples_.empty()) return 0.0;
  std::size_t behind = 0;
  for (std::size_t i = 0; i < samples_.size(); ++i)
    behind += current.depth_m[samples_[i]] > sample_far_m_[i] ? 1 : 0;
  return static_cast<double>(behind) / static_cast<double>(samples_.size());
}

// Bodies of a hand's size, and smaller parts beside one: the object's edge may cut the fingers on it from the
// arm behind.
void PartnerFinder::choose_components() {
  const auto& components = change_.components();
  chosen_.assign(components.size(), 0);
  for (std::size_t i = 0; i < components.size(); ++i) {
    const PixelWindow& box = components[i].box;
    if (components[i].area_m2 < min_part_m2(box)) continue;
    bool beside = components[i].blob_m2 >= config_.min_body_m2;
    for (std::size_t j = 0; j < components.size() && !beside; ++j) {
      const PixelWindow& big = components[j].box;
      beside =
          components[j].area_m2 >= config_.min_body_m2 && box.u_begin <= big.u_end + config_.body_gap_px &&
          box.u_end >= big.u_begin - config_.body_gap_px && box.v_begin <= big.v_end + config_.body_gap_px &&
          box.v_end >= big.v_begin - config_.body_gap_px;
    }
    chosen_[i] = beside ? 1 : 0;
  }
}

void PartnerFinder::collect_skin(const OrganisedCloud& current, PartnerObservation& observation) {
  skin_.clear();
  body_m2_ = 0.0;
  const double per_pixel = 1.0 / (intrinsics_.fx * intrinsics_.fy);
  std::array<double, 64> histogram{};
  const auto& components = change_.components();
  const auto& patches = grid_.patches();
  choose_components();
  for (std::size_t i = 0; i < components.size(); ++i)
    body_m2_ += chosen_[i] != 0 ? components[i].area_m2 : 0.0;
  for (const ChangedRun& run : change_.runs()) {
    if (chosen_[static_cast<std::size_t>(run.component)] == 0) continue;
    const std::size_t row = static_cast<std::size_t>(run.v) * static_cast<std::size_t>(intrinsics_.width);
    for (std::size_t i = row + static_cast<std::size_t>(run.u_begin);
         i < row + static_cast<std::size_t>(run.u_end); ++i) {
      const std::int32_t patch = grid_.nearest(current.x[i], current.y[i], current.z[i]);
      if (patch == ObjectGrid::kNone) continue;
      const Eigen::Vector3f p(current.x[i], current.y[i], current.z[i]);
      const float distance = (p - patches[static_cast<std::size_t>(patch)]).norm();
      const float z = current.depth_m[i];
      const auto area = static_cast<float>(per_pixel) * z * z;
      skin_.push_back({p, distance, area, z, patch, -1});
      const auto bin = static_cast<std::size_t>(distance * static_cast<float>(1.0 / kBin_m));
      if (bin < histogram.size()) histogram[bin] += area;
    }
    for (std::int32_t u = run.u_begin; u < run.u_end; ++u) {
      observation.pixels.push_back(static_cast<std::uint32_t>(row) + static_cast<std::uint32_t>(u));
    }
  }
  double area = 0.0;
  for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
    area += histogram[bin];
    if (area < config_.fingertip_m2) continue;
    observation.nearest_m = (static_cast<double>(bin) + 0.5) * kBin_m;
    break;
  }
}

float PartnerFinder::touch_gap(float depth_m) const {
  return static_cast<float>(config_.touch_m + noise_.sigma(depth_m) + 0.5 * noise_.step(depth_m));
}

float PartnerFinder::hand_gap(float depth_m) const {
  return static_cast<float>(config_.hand_thickness_m + 2.0 * noise_.sigma(depth_m) + noise_.step(depth_m));
}

// The contact of one hand, or nothing when too little of it is near.
std::optional<PartnerContact> PartnerFinder::contact(int hand) {
  const auto& patches = grid_.patches();
  double area = 0.0, touching = 0.0, depth = 0.0;
  Vec3 skin = Vec3::Zero();
  hand_.clear();
  const auto of_hand =
      std::count_if(skin_.begin(), skin_.end(), [hand](const Skin& s) { return s.hand == hand; });
  const auto all = static_cast<std::size_t>(of_hand),
             stride = 1 + all / static_cast<std::size_t>(config_.max_hand_points);
  std::size_t count = 0;
  for (const Skin& s : skin_) {
    if (s.hand != hand) continue;
    area += s.area_m2;
    depth += s.area_m2 * s.depth_m;
    skin += static_cast<double>(s.area_m2) * s.point.cast<double>();
    if (s.distance_m <= touch_gap(s.depth_m)) touching += s.area_m2;
    if (count++ % stride != 0) continue;
    hand_.push_back({s.point, patches[static_cast<std::size_t>(s.patch)], s.area_m2});
  }
  if (area < config_.min_touch_m2 || touching < config_.fingertip_m2) return std::nullopt;
  const ContactEstimate found = estimate_contact(
      hand_, {patches, rim_, X_WC_.translation().cast<float>()},
      {config_.along_sigma_m, config_.cross_sigma_m, 0.5 * noise_.sigma(depth / area)}, config_.contact);
  return PartnerContact{found.position, found.covariance, all, skin / area};
}

// All touches that may be hands go to the sighting as contacts, the others as legs.
void PartnerFinder::drop_legs(const OrganisedCloud& current, PartnerObservation& observation) {
  std::vector<Vec3>& legs = observation.legs;
  for (int hand = 0; hand < hands_; ++hand) {
    const auto found = contact(hand);
    if (!found) continue;
    if (leg_sign(current, observation.pixels, found->position, ground_, false, config_.legs) == LegSign::None)
      observation.contacts.push_back(*found);
    else
      legs.push_back(found->position);
  }
  // who leans against the object with one leg does so with the other, which the object may hide
  const std::size_t first_legs = legs.size();
  std::erase_if(observation.contacts, [&](const PartnerContact& c) {
    const bool beside =
        std::any_of(legs.begin(), legs.begin() + static_cast<std::ptrdiff_t>(first_legs),
                    [&](const Vec3& leg) { return (leg - c.position).norm() < config_.legs.leg_distance_m; });
    if (!beside ||
        leg_sign(current, observation.pixels, c.position, ground_, true, config_.legs) == LegSign::None)
      return false;
    legs.push_back(c.position);
    return true;
  });
}

void PartnerFinder::note_hidden_edge(const OrganisedCloud& current, PartnerObservation& observation) const {
  observation.hidden_edge = find_hidden_edge(rim_, current, observation.pixels, config_.clear_m);
  if (!observation.hidden_edge) return;
  if (observation.hidden_edge->fraction < config_.min_hidden_edge)
    observation.hidden_edge.reset();
  else
    observation.reason += fmt::format("; it hides {:.0f} % of the object's edge from the camera",
                                      100.0 * observation.hidden_edge->fraction);
}

hal::Result<PartnerObservation> PartnerFinder::find(const OrganisedCloud& current) {
  if (!same_camera(current)) {
    return failure(
        ErrorCode::BadInput, "partner: frame",
        fmt::format("{} x {} pixels; the reference has {} x {}, and the camera must not have moved",
                    current.width(), current.height(), intrinsics_.width, intrinsics_.height));
  }
  PartnerObservation observation;
  if (const double moved = moved_part(current); moved > config_.max_uncovered_fraction) {
    observation.kind = PartnerKind::ObjectMoved;
    observation.reason = fmt::format(
        "{:.0f} % of the object's pixels show what was behind it (at most {:.0f} %): it is no "
        "longer where the reference shows it",
        100.0 * moved, 100.0 * config_.max_uncovered_fraction);
    return observation;
  }
  if (const double receded = receded_part(current); receded > config_.max_receded_fraction) {
    observation.kind = PartnerKind::ObjectMoved;
    observation.reason = fmt::format(
        "{:.1f} % of the view lie farther than in the reference (max {:.1f} %), and no person uncovers so "
        "much by "
        "coming: the camera or the scene moved",
        100.0 * receded, 100.0 * config_.max_receded_fraction);
    return observation;
  }
  change_.compare(current);
  if (++unseen_frames_ > config_.known_frames) known_hands_.clear();
  collect_skin(current, observation);
  if (body_m2_ == 0.0) {
    observation.reason =
        fmt::format("nothing of a hand's size ({:.0f} cm2) came within {:.2f} m of the object",
                    1e4 * config_.min_body_m2, config_.reach_m);
    return observation;
  }
  if (!observation.nearest_m || *observation.nearest_m >= config_.clear_m) {
    observation.kind = PartnerKind::PasserBy;
    observation.reason = fmt::format("a body of {:.0f} cm2 keeps {} {:.0f} cm from the object",
                                     1e4 * body_m2_, observation.nearest_m ? "about" : "more than",
                                     100.0 * observation.nearest_m.value_or(config_.clear_m));
    note_hidden_edge(current, observation);
    return observation;
  }
  separate_hands();
  drop_legs(current, observation);
  std::stable_sort(observation.contacts.begin(), observation.contacts.end(),
                   [](const PartnerContact& a, const PartnerContact& b) { return a.points > b.points; });
  const auto max_hands = static_cast<std::size_t>(config_.max_hands);
  if (observation.contacts.size() > max_hands) observation.contacts.resize(max_hands);
  if (observation.contacts.empty()) {
    observation.kind = PartnerKind::Near;
    observation.reason =
        !observation.legs.empty()
            ? "a leg or the trunk of a person touches the object, and no hand does"
            : fmt::format("the nearest part of a body is {:.0f} mm from the object and does not touch it",
                          1000.0 * *observation.nearest_m);
    note_hidden_edge(current, observation);
    return observation;
  }
  observation.kind = PartnerKind::Grasp;
  note_hands(current, observation);
  PartnerGrasp grasp;
  const double n = static_cast<double>(observation.contacts.size());
  for (const PartnerContact& hand : observation.contacts) {
    grasp.position += hand.position / n;
    grasp.covariance += hand.covariance / (n * n);
    grasp.points += hand.points;
    grasp.skin = grasp.skin.value_or(Vec3::Zero()) + hand.skin / n;
  }
  observation.grasp = grasp;
  const double sigma = std::sqrt(grasp.covariance.trace() / 3.0);
  observation.reason =
      observation.contacts.size() == 1
          ? fmt::format(
                "a hand touches the object at ({:.2f}, {:.2f}, {:.2f}) m, +- {:.0f} mm, seen in {} points",
                grasp.position.x(), grasp.position.y(), grasp.position.z(), 1000.0 * sigma, grasp.points)
          : fmt::format("{} hands touch the object; their middle is ({:.2f}, {:.2f}, {:.2f}) m, +- {:.0f} mm",
                        observation.contacts.size(), grasp.position.x(), grasp.position.y(),
                        grasp.position.z(), 1000.0 * sigma);
  return observation;
}

}  // namespace colift::perception
