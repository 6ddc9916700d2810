#include "perception/target/target.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <tuple>
#include <utility>

#include "perception/ground/image_border.hpp"
#include "perception/target/regions/raised_pixels.hpp"
#include "perception/target/regions/thickness.hpp"

namespace colift::perception {
namespace {

// fractions of a side that the view cuts, from which on the result mentions them
constexpr double kReportedTopCut = 0.1, kReportedSideCut = 0.02;
// parts of an outline that are not free, and of the target's rank, from which on the result mentions them
constexpr double kReportedAttached = 0.15, kCloseRank = 0.7;

DepthJump jump_of(const NoiseModel& noise, const TargetConfig& c) {
  return {static_cast<float>(c.jump_base_m + c.jump_sigma * noise.sigma0_m),
          static_cast<float>(c.jump_sigma * noise.sigma2_per_m + c.jump_steps * noise.step2_per_m)};
}

Target make_target(const Fragment& f, const OrganisedCloud& cloud, const Components& components,
                   const Ground& ground, const std::vector<std::uint8_t>& on_wall, const DepthJump& jump,
                   const TargetConfig& c) {
  Target t;
  t.pixels.reserve(f.pixels);
  const std::vector<std::uint8_t> region = own_regions(f, components);
  for (const Components::Run& run : components.runs) {
    if (!region[static_cast<std::size_t>(run.label)]) continue;
    const std::uint32_t row = static_cast<std::uint32_t>(run.row) * static_cast<std::uint32_t>(cloud.width());
    const std::size_t begin = t.pixels.size();
    t.pixels.resize(begin + static_cast<std::size_t>(run.last - run.first + 1));
    std::iota(t.pixels.begin() + static_cast<std::ptrdiff_t>(begin), t.pixels.end(),
              row + static_cast<std::uint32_t>(run.first));
  }
  const std::vector<std::uint32_t> inside =
      enclosed_pixels(cloud, ground, t.pixels, on_wall, jump, c.min_neighbours, c.enclosed);
  const auto own = static_cast<std::ptrdiff_t>(t.pixels.size());
  t.pixels.insert(t.pixels.end(), inside.begin(), inside.end());
  std::inplace_merge(t.pixels.begin(), t.pixels.begin() + own, t.pixels.end());

  measure_target(t, cloud, ground, c.box);
  return t;
}

double distance(const Fragment& f, const OrganisedCloud& cloud, const Components& components, const Vec3& p) {
  double best = std::numeric_limits<double>::infinity();
  for (const Components::Run& run : components.runs) {
    if (!std::binary_search(f.labels.begin(), f.labels.end(), run.label)) continue;
    const std::size_t row = static_cast<std::size_t>(run.row) * static_cast<std::size_t>(cloud.width());
    for (int u = run.first; u <= run.last; ++u)
      best = std::min(best, (cloud.point(row + static_cast<std::size_t>(u)) - p).squaredNorm());
  }
  return std::sqrt(best);
}

// a region that may be the target
struct Candidate {
  Fragment object;
  const Components* components = nullptr;  ///< To which the object's labels belong.
  bool cut_out = false;                    ///< A part of something larger that cannot be the target.
  Outline outline;
  double rank = 0.0;  ///< m^2
};

// A cut object is a bad choice even when much of it is in view: where it ends, what it touches there and
// where its centre of gravity lies are all unknown. What had to be cut out of its background may be no object
// at all.
constexpr double kCutPower = 4.0, kHiddenPower = 2.0, kCutOutWeight = 0.5;

// What the camera was pointed at is near and in the middle of its view. Part of the rank that is left to an
// object at the rim of the view, and the distance over which an object is as good as a nearer one (m).
constexpr double kAsideWeight = 0.5, kNear_m = 1.0;

double rank_of(const Candidate& c, const hal::CameraIntrinsics& k) {
  const double whole = 1.0 - lateral_cut(c.object).fraction;
  const double clear = std::pow(1.0 - c.outline.same - c.outline.nearer, kHiddenPower);
  const double u = 0.5 * (c.object.u_min + c.object.u_max) / k.width - 0.5;
  const double v = 0.5 * (c.object.v_min + c.object.v_max) / k.height - 0.5;
  const double aside = std::min(1.0, 2.0 * std::hypot(u, v));
  return c.object.area_m2 * std::pow(whole, kCutPower) * clear * (c.cut_out ? kCutOutWeight : 1.0) *
         (1.0 - kAsideWeight * aside) * kNear_m / std::max(kNear_m, c.object.mean_depth_m);
}

/// Goes through the objects of a frame and keeps what speaks for and against each.
class Search {
 public:
  Search(const OrganisedCloud& cloud, const Components& components, const Ground& ground,
         const ImageBorder& border, const NoiseModel& noise, const DepthJump& jump, const TargetConfig& c,
         const std::optional<Vec3>& at_W)
      : cloud_(cloud),
        components_(components),
        label_(components.labels(cloud.width(), cloud.height())),
        ground_(ground),
        border_(border),
        noise_(noise),
        jump_(jump),
        c_(c),
        at_W_(at_W) {}

  void add(const Fragment& object) {
    using Kind = RejectedObject::Kind;
    auto no = object_to(object, c_);
    if (!no || no->kind == Kind::Person)
      if (auto shape = object_to_shape(object, components_)) no = std::move(shape);
    if (no && no->kind == Kind::Floating && at_W_)
      no.reset();  // who points at it knows that its legs are not seen
    if (!no) {
      accept({object, &components_, false, {}, 0.0}, label_);
      return;
    }
    const bool divisible = no->kind == Kind::Cut || no->kind == Kind::Large || no->kind == Kind::Person;
    if (no->whole || !divisible) {
      reject(object, components_, std::move(*no));
      return;
    }
    divisible_.push_back(object);
    why_not_.push_back(std::move(*no));
  }

  // Looks again at what cannot be the target as a whole, unless an object was found that no part would
  // outrank.
  void add_parts() {
    double best = 0.0, hidden = 0.0;
    for (const Candidate& k : candidates) best = std::max(best, k.object.area_m2);
    for (const Fragment& f : divisible_) hidden += f.area_m2;
    std::vector<std::size_t> parts_of(divisible_.size(), 0);
    if (kCutOutWeight * hidden > best) {
      SecondLook look = look_again(cloud_, label_, divisible_, ground_, border_, jump_, noise_, c_.fragments,
                                   c_.second_look);
      parts_components_ = std::move(look.components);
      const std::vector<std::int32_t> label = parts_components_.labels(cloud_.width(), cloud_.height());
      for (const std::size_t k : look.whole) ++parts_of[k];
      for (std::size_t i = 0; i < look.parts.size(); ++i) {
        if (parts_of[look.whole[i]] < 2) continue;  // it did not fall apart
        const Fragment& part = look.parts[i];
        auto no = object_to(part, c_);
        if (!no || no->kind == RejectedObject::Kind::Person)
          if (auto shape = object_to_shape(part, parts_components_)) no = std::move(shape);
        if (no)
          reject(part, parts_components_, std::move(*no));
        else
          accept({part, &parts_components_, true, {}, 0.0}, label);
      }
    }
    for (std::size_t k = 0; k < divisible_.size(); ++k)
      if (parts_of[k] < 2) reject(divisible_[k], components_, std::move(why_not_[k]));
  }

  // An arm or a leg beside a person, or beside something that may be one, is no object.
  void drop_limbs() {
    std::erase_if(candidates, [&](const Candidate& k) {
      const auto body = std::find_if(bodies_.begin(), bodies_.end(),
                                     [&](const Body& b) { return is_part_of(k, b.object) && is_body(b); });
      if (body == bodies_.end()) return false;
      reject(k.object, *k.components,
             {RejectedObject::Kind::Person, k.object.box.center(), k.object.pixels,
              "it stands beside a person, or something that may be one, and may be a part of that"});
      return true;
    });
  }

  [[nodiscard]] int persons() const { return persons_; }

  std::vector<Candidate> candidates;
  std::vector<RejectedObject> rejected;

 private:
  // what only the object's shape tells
  [[nodiscard]] std::optional<RejectedObject> object_to_shape(const Fragment& object,
                                                              const Components& components) {
    const Silhouette silhouette(cloud_, components, object, ground_);
    const auto thickness = [&](const Silhouette::Window& window) {
      return median_thickness(cloud_, components, object, jump_, silhouette, window);
    };
    if (const auto found = find_person(silhouette, noise_, thickness, c_.person)) {
      ++persons_;
      RejectedObject no{RejectedObject::Kind::Person, object.box.center(), object.pixels,
                        fmt::format("a person: a head {:.2f} m wide, {:.2f} m above shoulders of {:.2f} m",
                                    found->head_width_m, found->rise_m, found->shoulder_width_m)};
      no.whole = true;
      return no;
    }
    if (auto no = object_to_bulk(cloud_, components, object, silhouette, ground_, c_)) return no;
    if (const auto limb = find_limb(cloud_, components, object, silhouette, noise_, c_.limb)) {
      RejectedObject no{
          RejectedObject::Kind::Person, object.box.center(), object.pixels,
          fmt::format("it is round all over, with a radius of about {:.0f} mm, and no pipe that "
                      "lies: a part of a person, perhaps",
                      1e3 * limb->radius_m)};
      no.whole = true;
      return no;
    }
    return std::nullopt;
  }

  // What was refused and may be a person.
  struct Body {
    Fragment object;
    const Components* components;
    bool known;  // by its shape or size; else only if it is round
  };

  // refused for what the view or something else hides of it, or for its size, whatever it is
  static bool may_be_body(RejectedObject::Kind kind) {
    using Kind = RejectedObject::Kind;
    return kind == Kind::Cut || kind == Kind::Attached || kind == Kind::Floating || kind == Kind::Large;
  }

  [[nodiscard]] bool is_body(const Body& b) const {
    if (b.known) return true;
    const Silhouette silhouette(cloud_, *b.components, b.object, ground_);
    return find_limb(cloud_, *b.components, b.object, silhouette, noise_, c_.limb).has_value();
  }

  [[nodiscard]] bool is_part_of(const Candidate& k, const Fragment& body) const {
    const double most =
        (k.cut_out ? c_.max_cut_out_limb_fraction : c_.max_limb_fraction) * static_cast<double>(body.pixels);
    if (static_cast<double>(k.object.pixels) <= most && footprint_gap(k.object, body) <= c_.max_limb_gap_m)
      return true;
    const auto thickness = [&] { return median_thickness(cloud_, *k.components, k.object); };
    return is_limb_of(k.object, body, c_.max_limb_fraction, thickness, c_.limb_part);
  }

  void reject(const Fragment& object, const Components& components, RejectedObject no) {
    if (at_W_) no.away_m = distance(object, cloud_, components, *at_W_);
    const bool tall =
        no.kind == RejectedObject::Kind::Person ||
        (no.kind == RejectedObject::Kind::Cut && object.max_height_m > c_.limb_part.min_cut_height_m);
    const double span = footprint_span(object);
    if (no.whole || (tall && span < c_.max_person_span_m))
      bodies_.push_back({object, &components, true});
    else if (may_be_body(no.kind) && span <= c_.limb_part.max_body_span_m)
      bodies_.push_back({object, &components, false});
    rejected.push_back(std::move(no));
  }

  void accept(Candidate k, const std::vector<std::int32_t>& label) {
    if (!at_W_ && k.object.pixels < static_cast<std::size_t>(c_.min_unasked_pixels)) {
      reject(k.object, *k.components,
             {RejectedObject::Kind::Small, k.object.box.center(), k.object.pixels,
              fmt::format("it shows {} pixels, {} are needed when nobody points at it", k.object.pixels,
                          c_.min_unasked_pixels)});
      return;
    }
    k.outline = read_outline(cloud_, *k.components, label, k.object, ground_, border_, jump_, c_.outline);
    if (auto no = object_to_outline(k.object, k.outline, c_)) {
      reject(k.object, *k.components, std::move(*no));
      return;
    }
    k.rank = rank_of(k, cloud_.intrinsics);
    candidates.push_back(std::move(k));
  }

  const OrganisedCloud& cloud_;
  const Components& components_;
  std::vector<std::int32_t> label_;  // of every pixel
  const Ground& ground_;
  const ImageBorder& border_;
  const NoiseModel& noise_;
  const DepthJump& jump_;
  const TargetConfig& c_;
  const std::optional<Vec3>& at_W_;
  Components parts_components_;  // of what was looked at again
  std::vector<Fragment> divisible_;
  std::vector<RejectedObject> why_not_;
  std::vector<Body> bodies_;
  int persons_ = 0;
};

struct Confidence {
  double value = 1.0;
  std::vector<std::string> doubts;
};

// how sure it is that this is one whole object that stands free, and what speaks against it
Confidence confidence_in(const Candidate& chosen, const Candidate* second) {
  Confidence out;
  const auto doubt = [&](double weight, std::string why) {
    out.value *= 1.0 - std::clamp(weight, 0.0, 1.0);
    out.doubts.push_back(std::move(why));
  };
  const double top = top_cut(chosen.object);
  if (top > kReportedTopCut)
    doubt(0.3 * top,
          fmt::format("the view cuts {:.0f} % of its upper side, so its height is not known", 100 * top));
  const SideCut cut = lateral_cut(chosen.object);
  if (cut.fraction > kReportedSideCut)
    doubt(cut.fraction,
          fmt::format("{:.0f} % of its {} side touch the rim of the view", 100 * cut.fraction, cut.side));
  if (chosen.cut_out) doubt(0.4, "it had to be cut out of what stands behind it");
  const double attached = chosen.outline.same + 0.5 * chosen.outline.nearer;
  if (attached > kReportedAttached)
    doubt(attached,
          fmt::format("along {:.0f} % of its outline something is at its own depth, {:.0f} % are hidden by "
                      "something in front",
                      100 * chosen.outline.same, 100 * chosen.outline.nearer));
  if (second && second->rank > kCloseRank * chosen.rank)
    doubt(0.2, fmt::format("another object shows nearly as much: {:.0f} of {:.0f} cm2",
                           1e4 * second->object.area_m2, 1e4 * chosen.object.area_m2));
  return out;
}

}  // namespace

void measure_target(Target& t, const OrganisedCloud& cloud, const Ground& ground, const BoxTrim& trim) {
  t.points.resize(t.pixels.size());
  const float *x = cloud.x.data(), *y = cloud.y.data(), *z = cloud.z.data();
  Eigen::AlignedBox3f box;
  for (std::size_t k = 0; k < t.pixels.size(); ++k) {
    const std::uint32_t i = t.pixels[k];
    t.points[k] = {x[i], y[i], z[i]};
    box.extend(t.points[k]);
  }
  t.aabb = Aabb(box.min().cast<double>(), box.max().cast<double>());
  t.obb = box_on_plane(t.points, ground.plane, trim);
  t.shape = t.obb;
  t.cog = t.obb.center;
}

TargetResult find_target(const OrganisedCloud& cloud, const std::vector<BlockPlane>& blocks,
                         const Ground& ground, const NoiseModel& noise, const TargetConfig& c,
                         const std::optional<Vec3>& at_W) {
  const ImageBorder border = find_image_border(cloud);
  const DepthJump jump = jump_of(noise, c);
  // a floor that is uneven, or looks so through its lens, asks for more room
  std::vector<std::uint8_t> mask = raised_pixels(
      cloud, ground, noise, {std::max(c.clearance_m, c.clearance_rms * ground.rms_m), c.clearance_sigma});
  const std::vector<Wall> walls = find_walls(cloud, blocks, ground, border, noise, c.walls);
  std::vector<std::uint8_t> on_wall = mask;
  const std::size_t wall_pixels = clear_walls(cloud, walls, noise, c.walls, mask);
  std::transform(on_wall.begin(), on_wall.end(), mask.begin(), on_wall.begin(), std::minus<>());
  clear_flying_pixels(cloud, jump, c.min_neighbours, mask);
  const Components components =
      connected_components(cloud.depth_m, mask, cloud.width(), cloud.height(), jump);

  TargetResult result;
  if (!walls.empty()) {
    result.rejected.push_back({RejectedObject::Kind::Wall, walls.front().plane.foot(cloud.X_WC.translation()),
                               wall_pixels,
                               fmt::format("{} upright plane(s) wider than {:.1f} m are walls", walls.size(),
                                           c.walls.min_width_m)});
  }
  Search search(cloud, components, ground, border, noise, jump, c, at_W);
  for (const Fragment& f : join_fragments(describe_fragments(cloud, components, ground, border, c.fragments),
                                          cloud, components, ground, noise, c.fragments))
    search.add(f);
  search.add_parts();
  search.drop_limbs();
  result.rejected.insert(result.rejected.end(), std::make_move_iterator(search.rejected.begin()),
                         std::make_move_iterator(search.rejected.end()));

  const Candidate* chosen = nullptr;
  const Candidate* second = nullptr;
  double away = std::numeric_limits<double>::infinity();
  for (const Candidate& k : search.candidates) {
    if (at_W) {
      const double d = distance(k.object, cloud, *k.components, *at_W);
      if (d < away) std::tie(away, chosen) = std::pair(d, &k);
    } else if (!chosen || k.rank > chosen->rank) {
      second = chosen;
      chosen = &k;
    } else if (!second || k.rank > second->rank) {
      second = &k;
    }
  }
  Confidence confidence;
  if (chosen) confidence = confidence_in(*chosen, second);
  std::string why_not;
  if (chosen && !at_W && confidence.value < c.min_confidence) {
    why_not = fmt::format(
        "the best object is not sure enough, {:.2f} of {:.2f}, so it has to be pointed at (--at): {}",
        confidence.value, c.min_confidence, fmt::join(confidence.doubts, "; "));
    result.rejected.push_back(
        {RejectedObject::Kind::Unsure, chosen->object.box.center(), chosen->object.pixels, why_not});
  }
  for (const Candidate& k : search.candidates) {
    if (&k == chosen || at_W) continue;
    result.rejected.push_back({RejectedObject::Kind::Lesser, k.object.box.center(), k.object.pixels,
                               fmt::format("it shows {:.0f} cm2, less than the target", 1e4 * k.rank)});
  }
  std::stable_sort(result.rejected.begin(), result.rejected.end(),
                   [](const auto& a, const auto& b) { return a.pixels > b.pixels; });
  for (const RejectedObject& r : result.rejected) {
    if (!(r.away_m < away) || r.kind == RejectedObject::Kind::Small) continue;
    away = r.away_m;
    why_not = fmt::format("the object {:.0f} mm from the given point is refused: {}", 1000 * away, r.reason);
  }
  if (!why_not.empty()) {
    result.reason = "no target: " + why_not;
    return result;
  }

  if (!chosen) {
    if (result.rejected.empty())
      result.reason = "no target: there is no object on the ground";
    else
      result.reason = fmt::format("no target: none of {} objects is free-standing; the largest: {}",
                                  result.rejected.size(), result.rejected.front().reason);
    if (search.persons() > 0)
      result.reason += fmt::format("; {} in view: the picture is taken with nobody there",
                                   search.persons() == 1 ? "a person is" : "persons are");
    return result;
  }
  result.target = make_target(chosen->object, cloud, *chosen->components, ground, on_wall, jump, c);
  result.target->confidence = confidence.value;
  result.target->doubts = std::move(confidence.doubts);
  if (at_W) {
    result.reason = fmt::format("the object {:.0f} mm from the given point", 1000 * away);
  } else {
    result.reason =
        fmt::format("the largest free-standing object: {:.0f} cm2 visible at {:.2f} m, {:.2f} m high",
                    1e4 * chosen->object.area_m2, chosen->object.mean_depth_m, chosen->object.max_height_m);
    if (second) result.reason += fmt::format("; the next one shows {:.0f} cm2", 1e4 * second->rank);
  }
  for (const std::string& why : result.target->doubts) result.reason += "; " + why;
  result.target->reason = result.reason;
  return result;
}

}  // namespace colift::perception
