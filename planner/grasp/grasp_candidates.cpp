#include "planner/grasp/grasp_candidates.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "planner/grasp/body_depth.hpp"

namespace colift::planner {
namespace {

using perception::Cylinder;
using perception::Rectangle;
using perception::Scene;

GraspCandidate on_line(const GraspLine& line, const Vec3& position, const HandModel& hand) {
  GraspCandidate c;
  c.kind = line.kind;
  c.position = position;
  c.approach = line.approach;
  c.closing = line.closing;
  c.width = line.width;
  c.surface = line.surface;
  c.reason = line.note;
  // a body that ends before the pads is taken in its middle: the fingers would close behind it
  if (line.depth) c.gap_m = contact_at_width(hand, c.width).height_m - 0.5 * *line.depth;
  return c;
}

/// Calls f(candidate), not judged yet, at places no more than `step_m` apart along a line, both ends
/// included.
template <class F>
void for_each_place(const GraspLine& line, double step_m, const HandModel& hand, F&& f) {
  const int spans = static_cast<int>(std::ceil(line.length() / step_m - 1e-9));
  for (int i = 0; i <= spans; ++i) {
    const double along = spans == 0 ? 0.5 : static_cast<double>(i) / spans;
    f(on_line(line, line.from + along * (line.to - line.from), hand));
  }
}

/// How far behind the grasped face the pads press (m).
double pad_depth(const GraspCandidate& c, const HandModel& hand) {
  return std::max(0.0, contact_at_width(hand, c.width).height_m - hand.gap(c));
}

/// An edge grasp repeats an Ega5 grasp that takes the same rim from the same side.
bool repeats_ega5(const GraspCandidate& edge, const std::vector<GraspCandidate>& found, double reach,
                  double same_cosine) {
  return std::any_of(found.begin(), found.end(), [&](const GraspCandidate& c) {
    return c.kind == GraspKind::Ega5 && c.verdict != Verdict::TooWide &&
           c.approach.dot(edge.approach) > same_cosine && (c.position - edge.position).norm() <= reach;
  });
}

constexpr double kSamePlace_m = 0.002;

/// Whether the list has the same grasp nearer than `nearer_m`.
bool is_known(const std::vector<GraspCandidate>& list, const GraspCandidate& c, double nearer_m) {
  return std::any_of(list.begin(), list.end(), [&](const GraspCandidate& other) {
    return other.verdict != Verdict::TooWide && (other.position - c.position).norm() < nearer_m &&
           other.approach.dot(c.approach) > 0.999 && std::abs(other.closing.dot(c.closing)) > 0.999;
  });
}

int next_id_after(const std::vector<GraspCandidate>& existing) {
  int next = 0;
  for (const GraspCandidate& c : existing) next = std::max(next, c.id + 1);
  return next;
}

/// One record for every surface that the hand cannot span, so that nobody wonders where its grasps are.
std::vector<GraspCandidate> too_wide(const Scene& scene, const HandModel& hand) {
  std::vector<GraspCandidate> found;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    GraspCandidate c;
    c.surface = static_cast<int>(i);
    c.verdict = Verdict::TooWide;
    if (const auto* r = std::get_if<Rectangle>(&scene.surfaces[i])) {
      c.width = r->size.minCoeff();
      c.position = r->center;
      c.approach = -r->normal;
      c.closing = r->size.x() < r->size.y() ? r->u : r->v;
      c.reason = fmt::format("the face is {:.0f} x {:.0f} mm, the hand opens {:.0f} mm",
                             1000 * r->size.maxCoeff(), 1000 * c.width, 1000 * hand.opening_m);
    } else if (const auto* cyl = std::get_if<Cylinder>(&scene.surfaces[i])) {
      c.kind = GraspKind::Wrap;
      c.width = 2.0 * cyl->radius;
      const Vec3 out = hal::tangents(cyl->axis).first;
      c.position = cyl->center + cyl->radius * out;
      c.approach = -out;
      c.closing = cyl->axis.cross(out);
      c.reason = fmt::format("the cylinder is {:.0f} mm thick, the hand opens {:.0f} mm", 1000 * c.width,
                             1000 * hand.opening_m);
    }
    c.miss_m = c.width - hand.opening_m;
    if (c.width > hand.opening_m) found.push_back(c);
  }
  return found;
}

}  // namespace

CandidateConfig thesis_candidates() {
  CandidateConfig config;
  config.edges = false;
  config.wraps = false;
  config.pads_bear = false;
  config.measure_depth = false;
  config.max_pull_back_m = 0.0;
  config.min_in_reach = 0;
  config.collision.refuse_unseen = false;
  config.collision.obstacles.surroundings = false;
  config.stability.enabled = false;
  return config;
}

CandidateFinder::CandidateFinder(const Scene& scene, const perception::OrganisedCloud* cloud,
                                 const HandModel& hand, const CandidateConfig& config,
                                 std::shared_ptr<const HandCollision> collision)
    : hand_(hand), config_(config), collision_(std::move(collision)) {
  if (!collision_) collision_ = std::make_shared<HandCollision>(hand, config.collision);
  if (scene.ground) up_ = scene.ground->plane.normal;
  if (!scene.target) return;
  cog_ = scene.target->cog;
  const CollisionConfig& c = config_.collision;
  if (cloud != nullptr) seen_.emplace(*cloud, c.obstacles.noise, c.sight_sigmas, c.shadow_px);
  solids_ = complete_solids(scene, seen(), config_.adjoin_m, config_.max_free_of_solid, config_.solids);
  obstacles_ = gather_obstacles(scene, cloud, c.obstacles);

  lines_ = ega5_lines(scene, hand_, config_);
  if (config_.measure_depth && seen_) {
    for (GraspLine& line : lines_) {
      const double pads_m = contact_at_width(hand_, line.width).height_m - hand_.palm_gap_m;
      const auto depth = body_depth(line, obstacles_, *seen_, pads_m);
      if (depth && *depth < pads_m - 0.5 * hand_.pad_height_m) line.depth = depth;
    }
  }
  if (config_.edges && seen_) {
    for (auto& line : edge_lines(scene, *seen_, solids_, obstacles_, hand_, config_))
      lines_.push_back(std::move(line));
  }
  if (config_.wraps) {
    const Vec3* camera = seen_ ? &seen_->camera() : nullptr;
    for (auto& line : wrap_lines(scene, camera, hand_, config_)) lines_.push_back(std::move(line));
  }
  too_wide_ = too_wide(scene, hand_);
  if (!config_.wraps) {
    std::erase_if(too_wide_,
                  [](const GraspCandidate& candidate) { return candidate.kind == GraspKind::Wrap; });
  }
}

std::vector<GraspCandidate> CandidateFinder::find() const {
  std::vector<GraspCandidate> found;
  bool listed_too_wide = false;
  const auto list_too_wide = [&] {
    if (!listed_too_wide) found.insert(found.end(), too_wide_.begin(), too_wide_.end());
    listed_too_wide = true;
  };
  for (const GraspLine& line : lines_) {
    if (line.kind != GraspKind::Ega5) list_too_wide();
    for_each_place(line, config_.step_m, hand_, [&](GraspCandidate c) {
      if (c.kind == GraspKind::Edge &&
          repeats_ega5(c, found, 0.5 * config_.step_m, config_.same_approach_cosine))
        return;
      judge(c);
      if (config_.pads_bear) c.depth_m = pad_depth(c, hand_);
      found.push_back(std::move(c));
    });
  }
  list_too_wide();
  for (std::size_t i = 0; i < found.size(); ++i) found[i].id = static_cast<int>(i);
  return found;
}

std::vector<GraspCandidate> CandidateFinder::between(double step_m,
                                                     const std::vector<GraspCandidate>& existing) const {
  std::vector<GraspCandidate> found;
  int next_id = next_id_after(existing);
  std::vector<GraspLine> lines = lines_;
  for (GraspLine& line : bar_lines(lines_, up_, config_.max_bar_m)) lines.push_back(std::move(line));
  for (const GraspLine& line : lines) {
    for_each_place(line, step_m, hand_, [&](GraspCandidate c) {
      if (is_known(existing, c, 0.5 * step_m) || is_known(found, c, 0.5 * step_m)) return;
      if (c.kind == GraspKind::Edge &&
          repeats_ega5(c, existing, 0.5 * config_.step_m, config_.same_approach_cosine))
        return;
      judge(c);
      if (config_.pads_bear) c.depth_m = pad_depth(c, hand_);
      c.id = next_id++;
      found.push_back(std::move(c));
    });
  }
  return found;
}

std::vector<GraspCandidate> CandidateFinder::near(const Vec3& point,
                                                  const std::vector<GraspCandidate>& existing) const {
  struct Foot {
    double distance;
    std::size_t line;
    Vec3 position;
  };
  std::vector<Foot> feet;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    const Vec3 foot = lines_[i].nearest(point);
    feet.push_back({(foot - point).norm(), i, foot});
  }
  std::sort(feet.begin(), feet.end(), [](const Foot& a, const Foot& b) {
    return a.distance != b.distance ? a.distance < b.distance : a.line < b.line;
  });
  if (feet.size() > static_cast<std::size_t>(config_.refine_lines)) {
    feet.resize(static_cast<std::size_t>(config_.refine_lines));
  }

  int next_id = next_id_after(existing);
  std::vector<GraspCandidate> found;
  const auto add = [&](GraspCandidate c) {
    judge(c);
    if (config_.pads_bear) c.depth_m = pad_depth(c, hand_);
    c.id = next_id++;
    found.push_back(std::move(c));
  };
  for (const Foot& foot : feet) {
    GraspCandidate c = on_line(lines_[foot.line], foot.position, hand_);
    if (c.kind == GraspKind::Edge &&
        (repeats_ega5(c, existing, 0.5 * config_.step_m, config_.same_approach_cosine) ||
         repeats_ega5(c, found, 0.5 * config_.step_m, config_.same_approach_cosine))) {
      continue;
    }
    const bool known = is_known(existing, c, kSamePlace_m) || is_known(found, c, kSamePlace_m);
    // the hand usually reaches far behind the face; where the load is wanted nearer, it stays farther out
    const double depth = pad_depth(c, hand_);
    const double wanted = std::max((point - c.position).dot(c.approach), config_.min_hold_depth_m);
    if (config_.pads_bear && c.kind != GraspKind::Wrap && wanted < depth - config_.min_depth_gain_m) {
      GraspCandidate shallow = c;
      shallow.gap_m = hand_.gap(c) + depth - wanted;
      const bool had = std::any_of(existing.begin(), existing.end(), [&](const GraspCandidate& other) {
        return other.gap_m && std::abs(*other.gap_m - *shallow.gap_m) < 0.002 &&
               is_known({other}, c, kSamePlace_m);
      });
      if (!had) add(std::move(shallow));
    }
    if (!known) add(std::move(c));
  }
  return found;
}

std::vector<GraspCandidate> CandidateFinder::around(const GraspCandidate& candidate,
                                                    const std::vector<GraspCandidate>& existing) const {
  constexpr double kOnLine_m = 0.001;
  const auto line = std::find_if(lines_.begin(), lines_.end(), [&](const GraspLine& l) {
    return l.kind == candidate.kind && l.surface == candidate.surface &&
           l.approach.dot(candidate.approach) > 0.999 && std::abs(l.closing.dot(candidate.closing)) > 0.999 &&
           (l.nearest(candidate.position) - candidate.position).norm() < kOnLine_m;
  });
  std::vector<GraspCandidate> found;
  if (line == lines_.end() || line->length() <= 0.0) return found;
  const Vec3 along = (line->to - line->from).normalized();
  const double step_m = config_.step_m / (config_.refine_steps + 1);
  int next_id = next_id_after(existing);
  for (int k = -config_.refine_steps; k <= config_.refine_steps; ++k) {
    GraspCandidate c = candidate;
    c.position += k * step_m * along;
    if (k == 0 || (line->nearest(c.position) - c.position).norm() > kOnLine_m ||
        is_known(existing, c, kSamePlace_m))
      continue;
    c.verdict = Verdict::Ok;
    c.reason.clear();
    judge(c);
    if (config_.pads_bear) c.depth_m = pad_depth(c, hand_);
    c.id = next_id++;
    found.push_back(std::move(c));
  }
  return found;
}

std::optional<Collision> CandidateFinder::collides(const GraspCandidate& candidate, double enough_m) const {
  const HandPlacement placement = collision_->place(candidate, seen());
  if (auto met = collision_->check(placement, obstacles_, enough_m)) return met;
  if (!seen_ || !config_.collision.refuse_unseen) return std::nullopt;
  return collision_->check_unseen(placement, *seen_, solids_);
}

std::optional<double> CandidateFinder::raised_gap(const GraspCandidate& candidate,
                                                  const Collision& met) const {
  const double down = -candidate.approach.dot(up_);
  if (met.with != Collision::With::Ground || down < 0.3) return std::nullopt;
  const double gap =
      hand_.gap(candidate) + (met.depth_m + config_.collision.ground_clearance_m + 0.001) / down;
  if (gap > hand_.largest_gap(candidate)) return std::nullopt;
  return gap;
}

std::optional<double> CandidateFinder::pulled_back_gap(const GraspCandidate& candidate,
                                                       const Collision& met) const {
  constexpr double kClear_m = 0.002;
  const bool finger = met.part.starts_with("finger");
  if (!finger || met.with != Collision::With::Object || candidate.kind == GraspKind::Wrap ||
      met.depth_m > config_.max_pull_back_m)
    return std::nullopt;
  const double gap = hand_.gap(candidate) + met.depth_m + kClear_m;
  if (gap > hand_.largest_gap(candidate)) return std::nullopt;
  return gap;
}

bool CandidateFinder::same_when_turned(const Collision& met) const {
  if (hand_.cuboids.empty()) return false;
  const HandCuboid& palm = hand_.cuboids.front();
  return met.part == palm.part && palm.center_m.head<2>().norm() == 0.0;
}

std::optional<Collision> CandidateFinder::beside(const GraspCandidate& candidate) const {
  if (candidate.kind != GraspKind::Edge || config_.side_clearance_m <= 0.0) return std::nullopt;
  const Vec3 along = candidate.closing.cross(candidate.approach);
  for (const double side : {-config_.side_clearance_m, config_.side_clearance_m}) {
    GraspCandidate aside = candidate;
    aside.position += side * along;
    auto met = collision_->check(collision_->place(aside, seen()), obstacles_);
    if (met && met->with == Collision::With::Object) return met;
  }
  return std::nullopt;
}

std::optional<GraspCandidate> CandidateFinder::turned(const GraspCandidate& candidate,
                                                      double angle_rad) const {
  GraspCandidate c = candidate;
  c.verdict = Verdict::Ok;
  c.reason.clear();
  c.miss_m.reset();
  c.approach = Eigen::AngleAxisd(angle_rad, candidate.closing.normalized()) * candidate.approach;
  const double lean = std::tan(std::abs(angle_rad));
  double corner = 0.0, finger = 0.0;
  if (!hand_.cuboids.empty()) corner = 0.5 * hand_.cuboids.front().size_m.x();
  for (const HandFinger& f : hand_.fingers) finger = std::max(finger, std::abs(f.x_m));
  c.gap_m = std::max(hand_.gap(candidate), config_.palm_clearance_m + corner * lean);
  if (*c.gap_m > hand_.largest_gap(c) - finger * lean) return std::nullopt;
  judge(c);
  if (config_.pads_bear) c.depth_m = pad_depth(c, hand_);
  return c;
}

void CandidateFinder::judge(GraspCandidate& candidate) const {
  auto met = collides(candidate, std::numeric_limits<double>::infinity());
  const GraspCandidate first = candidate;
  const auto attempt = [&](const Vec3& closing, std::optional<double> gap_m) {
    if (!met) return;
    GraspCandidate other = first;
    other.closing = closing;
    other.gap_m = gap_m;
    auto meets = collides(other, met->miss_m());
    if (meets && meets->miss_m() >= met->miss_m()) return;
    candidate = std::move(other);
    met = std::move(meets);
  };
  if (met) {
    const auto raised = raised_gap(first, *met);
    if (raised) attempt(first.closing, raised);
    if (config_.try_both_ways && !same_when_turned(*met)) {
      attempt(-first.closing, first.gap_m);
      if (raised) attempt(-first.closing, raised);
    }
  }
  if (met) {
    const GraspCandidate nearest = candidate;
    if (const auto back = pulled_back_gap(nearest, *met)) attempt(nearest.closing, back);
  }
  if (config_.stability.enabled) {
    const hal::Wrench load = nominal_load(candidate, up_, cog_, config_.stability);
    candidate.stability = stability_margin(candidate, hand_, load);
  }
  if (met) {
    candidate.verdict = Verdict::Collision;
    candidate.reason = met->text();
    candidate.miss_m = met->miss_m();
  } else if (const auto near_by = beside(candidate)) {
    candidate.verdict = Verdict::Collision;
    candidate.reason = fmt::format("{:.0f} mm aside {}: only part of what stands there is seen",
                                   1e3 * config_.side_clearance_m, near_by->text());
    candidate.miss_m = near_by->miss_m();
  } else if (candidate.stability && *candidate.stability < config_.stability.min_margin) {
    candidate.verdict = Verdict::Unstable;
    candidate.reason = fmt::format("the fingers hold {:.0f} % of a share of {:.0f} N",
                                   100 * *candidate.stability, config_.stability.load_n);
  }
}

std::vector<GraspCandidate> generate_candidates(const Scene& scene, const HandModel& hand,
                                                const CandidateConfig& config,
                                                const perception::OrganisedCloud* cloud) {
  return CandidateFinder(scene, cloud, hand, config).find();
}

const char* name_of(GraspKind kind) {
  switch (kind) {
    case GraspKind::Ega5:
      return "ega5";
    case GraspKind::Edge:
      return "edge";
    case GraspKind::Wrap:
      return "wrap";
  }
  return "?";
}

}  // namespace colift::planner
