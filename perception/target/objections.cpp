#include "perception/target/objections.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <vector>

#include "perception/footprint.hpp"

namespace colift::perception {
namespace {

// wider than any carton, as wide as a seat for two: a sofa or a bench whose depth the view hides
constexpr double kWideAndClosed_m = 1.5;

/// Of the left or the right side, whichever is more.
SideCut side_cut(const Fragment& f) {
  const double rows = f.v_max - f.v_min + 1;
  SideCut cut{f.cut_left / (2 * rows), "left"};
  if (f.cut_right / (2 * rows) > cut.fraction) cut = {f.cut_right / (2 * rows), "right"};
  return cut;
}

std::vector<Eigen::Vector3f> points_of(const OrganisedCloud& cloud, const Components& components,
                                       const Fragment& object) {
  const std::vector<std::uint8_t> own = own_pixels(cloud, components, object);
  std::vector<Eigen::Vector3f> points;
  points.reserve(object.pixels);
  for (std::size_t i = 0; i < own.size(); ++i)
    if (own[i]) points.emplace_back(cloud.x[i], cloud.y[i], cloud.z[i]);
  return points;
}

// The box of an object whose level top, of a desk or a chest, covers its footprint.
std::optional<OrientedBox> box_under_top(std::vector<Eigen::Vector3f> points, const Plane& ground,
                                         const BoxTrim& trim) {
  constexpr double kTop_m = 0.05, kCovers = 0.8;
  const OrientedBox box = box_on_plane(points, ground, trim);
  const double top_m = ground.height(box.center) + 0.5 * box.size.z() - kTop_m;
  std::erase_if(points, [&](const auto& p) { return ground.height(p.template cast<double>()) < top_m; });
  const OrientedBox top = box_on_plane(points, ground, trim);
  if (!(top.size.head<2>().prod() >= kCovers * box.size.head<2>().prod())) return std::nullopt;
  return box;
}

// Part of an object's width in which something of it is lower than `height_m`: a pipe on two stands fills
// much of the view, but the floor is seen under it.
double reaching_down(const Silhouette& silhouette, double height_m) {
  std::vector<bool> low(std::max<std::size_t>(1, silhouette.top().size()), false);
  for (const Silhouette::Point& p : silhouette.points()) {
    if (static_cast<double>(p.height) >= height_m) continue;
    const double bin = (static_cast<double>(p.across) - silhouette.left()) / Silhouette::kBin_m;
    low[std::min(low.size() - 1, static_cast<std::size_t>(std::max(0.0, bin)))] = true;
  }
  return static_cast<double>(std::count(low.begin(), low.end(), true)) / static_cast<double>(low.size());
}

}  // namespace

SideCut lateral_cut(const Fragment& f) {
  const double columns = f.u_max - f.u_min + 1;
  SideCut cut = side_cut(f);
  if (f.cut_bottom / (2 * columns) > cut.fraction) cut = {f.cut_bottom / (2 * columns), "bottom"};
  return cut;
}

double top_cut(const Fragment& f) {
  return f.cut_top / (2.0 * (f.u_max - f.u_min + 1));
}

std::optional<RejectedObject> object_to(const Fragment& f, const TargetConfig& c) {
  using Kind = RejectedObject::Kind;
  const auto reject = [&](Kind kind, std::string why) {
    return RejectedObject{kind, f.box.center(), f.pixels, std::move(why)};
  };
  if (f.area_m2 < c.min_area_m2 || f.pixels < static_cast<std::size_t>(c.min_pixels))
    return reject(Kind::Small,
                  fmt::format("it shows {:.0f} cm2 in {} pixels, {:.0f} cm2 and {} pixels are needed",
                              1e4 * f.area_m2, f.pixels, 1e4 * c.min_area_m2, c.min_pixels));
  if (f.max_height_m - std::max(0.0, f.min_height_m) < c.min_thickness_m &&
      f.min_height_m < 2 * c.min_thickness_m)
    return reject(Kind::Flat, fmt::format("it rises {:.0f} mm over the ground, {:.0f} are needed",
                                          1e3 * f.max_height_m, 1e3 * c.min_thickness_m));
  if (f.mean_depth_m > c.max_range_m)
    return reject(Kind::Far,
                  fmt::format("it is {:.1f} m away, the limit is {:.1f} m", f.mean_depth_m, c.max_range_m));
  // wider than high is a desk with things on it, not a person
  if (f.max_height_m > c.max_height_m && footprint_span(f) < c.tall_width_ratio * f.max_height_m)
    return reject(
        Kind::Person,
        fmt::format("it is {:.2f} m tall, a person or furniture that is not carried (limit {:.2f} m)",
                    f.max_height_m, c.max_height_m));
  if (footprint_span(f) > c.max_span_m)
    return reject(Kind::Large, fmt::format("it reaches over {:.1f} m, the limit is {:.1f} m",
                                           footprint_span(f), c.max_span_m));
  const SideCut cut = lateral_cut(f);
  const double top = top_cut(f);
  if (cut.fraction <= c.max_cut && top > c.max_person_top_cut &&
      f.max_height_m > c.min_person_slenderness * footprint_span(f)) {
    auto no = reject(Kind::Person, fmt::format("it leaves the view at the top, {:.2f} m above the ground and "
                                               "taller than wide: a person or furniture that is not carried",
                                               f.max_height_m));
    no.whole = true;  // a leg of it is no object
    return no;
  }
  // cut at the bottom it still shows its head
  const SideCut side = side_cut(f);
  if (cut.fraction <= c.max_cut && side.fraction > c.max_person_side_cut &&
      f.max_height_m > c.min_person_part_m && f.max_height_m > c.min_person_slenderness * footprint_span(f)) {
    auto no =
        reject(Kind::Person,
               fmt::format("its {} side leaves the view by {:.0f} %, and what is seen of it is {:.2f} m "
                           "high and taller than wide: a part of a person, perhaps",
                           side.side, 100 * side.fraction, f.max_height_m));
    no.whole = true;
    return no;
  }
  if (cut.fraction + c.top_cut_weight * top > c.max_cut)
    return reject(
        Kind::Cut,
        fmt::format("its {} side leaves the view by {:.0f} %{}, so it is not known to stand free (limit "
                    "{:.0f} %)",
                    cut.fraction > top ? cut.side : "upper", 100 * std::max(cut.fraction, top),
                    std::min(cut.fraction, top) > 0.05
                        ? fmt::format(" and its {} side by {:.0f} %", cut.fraction > top ? "upper" : cut.side,
                                      100 * std::min(cut.fraction, top))
                        : "",
                    100 * (cut.fraction > top ? c.max_cut : c.max_cut / c.top_cut_weight)));
  if (f.min_height_m > c.max_floating_m)
    return reject(
        Kind::Floating,
        fmt::format("nothing of it is seen below {:.2f} m above the ground (limit {:.2f} m), so it is not "
                    "known to stand on it",
                    f.min_height_m, c.max_floating_m));
  return std::nullopt;
}

std::optional<RejectedObject> object_to_bulk(const OrganisedCloud& cloud, const Components& components,
                                             const Fragment& object, const Silhouette& silhouette,
                                             const Ground& ground, const TargetConfig& c) {
  const double width = silhouette.width();
  double height = object.max_height_m;
  if (width < c.min_massive_width_m || height < c.massive_height_m) return std::nullopt;
  const double seen_m2 = width * std::max(c.unseen_depth_m, silhouette.depth());
  const FlatRectangle cells = footprint_rectangle(object);
  const auto volume_over = [&](const Eigen::Vector2d& floor) {
    const double floor_m2 = std::max(floor.x(), c.unseen_depth_m) * std::max(floor.y(), c.unseen_depth_m);
    return height * std::min(seen_m2, floor_m2);  // across the view a corner takes more
  };
  double volume = volume_over(cells.size);
  if (volume <= c.max_massive_m3 && width <= kWideAndClosed_m) return std::nullopt;
  const Silhouette::Window front{silhouette.left(), silhouette.left() + width, 0.0, c.massive_height_m};
  if (fill(silhouette.points(), front) < c.min_massive_fill) return std::nullopt;
  // Cells of its footprint, strays among them, make it larger than it is: 0.55 m^3 of a desk of 0.44. Of what
  // is not seen as a whole that is the better guess.
  if (lateral_cut(object).fraction + top_cut(object) == 0.0) {
    if (const auto box = box_under_top(points_of(cloud, components, object), ground.plane, c.box)) {
      height = std::min(height, ground.plane.height(box->center) + 0.5 * box->size.z());
      volume = volume_over(box->size.head<2>());
    }
  }
  const bool wide =
      width > kWideAndClosed_m && reaching_down(silhouette, 0.5 * c.massive_height_m) >= c.min_massive_fill;
  if (volume <= c.max_massive_m3 && !wide) return std::nullopt;
  return RejectedObject{
      RejectedObject::Kind::Large, object.box.center(), object.pixels,
      fmt::format(
          "it is closed down to the ground, {:.2f} m wide and takes {:.2f} m^3, furniture that is not "
          "carried (limits {:.1f} m, {:.2f} m^3)",
          width, volume, kWideAndClosed_m, c.max_massive_m3)};
}

std::optional<RejectedObject> object_to_outline(const Fragment& object, const Outline& outline,
                                                const TargetConfig& c) {
  if (outline.ground < c.min_on_ground)
    return RejectedObject{
        RejectedObject::Kind::Floating, object.box.center(), object.pixels,
        fmt::format(
            "along {:.0f} % of its outline it meets the ground, {:.0f} % are needed to know that it stands "
            "on it",
            100 * outline.ground, 100 * c.min_on_ground)};
  if (outline.nearer > c.max_hidden && object.area_m2 < c.min_hidden_area_m2)
    return RejectedObject{
        RejectedObject::Kind::Attached, object.box.center(), object.pixels,
        fmt::format(
            "something in front hides {:.0f} % of its outline, and the {:.0f} cm2 that are seen of it "
            "do not tell what it is (limits {:.0f} %, {:.0f} cm2)",
            100 * outline.nearer, 1e4 * object.area_m2, 100 * c.max_hidden, 1e4 * c.min_hidden_area_m2)};
  const double attached = outline.same + outline.nearer + outline.rim;
  if (attached <= c.max_attached) return std::nullopt;
  return RejectedObject{
      RejectedObject::Kind::Attached, object.box.center(), object.pixels,
      fmt::format(
          "it goes on, is hidden or leaves the view along {:.0f} % of its outline, so it is not known to "
          "stand free (limit {:.0f} %)",
          100 * attached, 100 * c.max_attached)};
}

}  // namespace colift::perception
