#include "perception/shape/shape_completion.hpp"

#include <fmt/format.h>

#include <limits>

#include "perception/shape/seen_parts.hpp"
#include "perception/shape/shape_evidence.hpp"
#include "perception/shape/shape_kinds.hpp"

namespace colift::perception {
namespace {

bool is_seat(const Rectangle& top, const ShapeEvidence& seen, const CompletionConfig& config) {
  const double height = seen.ground().height(top.center);
  return height >= config.seat_low_m && height <= config.seat_high_m &&
         top.size.maxCoeff() <= config.seat_width_m;
}

/// Nobody knows what the things on a plate weigh: up to about as much as makes this part of the whole.
void doubt_load(CompletedShape& shape, const ShapeEvidence& seen, const Rectangle& top, double above,
                const CompletionConfig& config) {
  const double height = seen.ground().height(top.center), limit = height + config.above_clearance_m;
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (const Eigen::Vector3f& point : seen.target().points) {
    const Vec3 p = point.cast<double>();
    if (seen.ground().height(p) > limit) sum += p, count += 1;
  }
  if (count > 0) {
    const Vec3 away = config.load_sigma * (sum / count - shape.cog);
    shape.covariance += away * away.transpose();
  }
  shape.reason += fmt::format(
      "; {:.0f} % of its points stand on it, and what that weighs is not known (no chair: its top is {:.2f} "
      "x {:.2f} m at {:.2f} m)",
      100 * above, top.size.x(), top.size.y(), height);
}

}  // namespace

CompletedShape complete_shape(const OrganisedCloud& cloud, const Target& target,
                              const std::vector<Surface>& surfaces, const Ground& ground,
                              const NoiseModel& noise, const CompletionConfig& config) {
  const ShapeEvidence seen(cloud, target, surfaces, ground, noise, config);
  const Cylinder* cylinder = seen.cylinder();
  if (cylinder) {
    const bool most =
        2 * cylinder->radius * cylinder->length > config.min_cylinder_fraction * seen.total_area_m2();
    // a pipe that lies on blocks: their faces may be the larger ones; one that stands is a leg
    const double level_m = cylinder->length * cylinder->axis.cross(ground.plane.normal).norm();
    const bool spans = level_m > config.min_cylinder_span * seen.footprint().size.head<2>().maxCoeff();
    if (most || spans) return complete_cylinder(seen, config);
  }
  if (const Rectangle* found = seen.find_top()) {
    ShapeEvidence::Widened top = seen.widened(*found, std::numeric_limits<double>::infinity());
    const double above = seen.part_above(top.top);
    if (above > config.min_above_fraction) {
      if (is_seat(top.top, seen, config)) return complete_chair(seen, top.top, config);
      // what stands on a plate may stick out over it
      top = seen.widened(*found, ground.plane.height(found->center) + config.above_clearance_m);
    }
    if (seen.gaps(top.top) > config.max_gaps) return complete_parts(seen, nullptr, config);
    const double support = seen.seen_support(top.top);
    const bool open = support < config.closed_support;
    const double whole = seen.footprint().size.head<2>().prod();
    if (open && (top.top.size.prod() < config.min_top_of_whole * whole ||
                 top.top.size.minCoeff() < config.min_panel_m))
      return complete_parts(seen, nullptr, config);
    if (open && has_panels(seen, top.top, config)) return complete_parts(seen, &top, config);
    CompletedShape shape =
        open ? complete_plate(seen, top, support, config) : complete_block(seen, top, support);
    if (above > config.min_above_fraction) doubt_load(shape, seen, top.top, above, config);
    return shape;
  }
  if (auto open = complete_open_box(seen, config)) return *open;
  if (seen.gaps(seen.footprint()) > config.min_gaps) return complete_parts(seen, nullptr, config);
  return complete_mirrored(seen, config);
}

const char* name_of(CompletedShape::Kind kind) {
  switch (kind) {
    case CompletedShape::Kind::Block:
      return "block";
    case CompletedShape::Kind::Plate:
      return "plate on legs";
    case CompletedShape::Kind::OpenBox:
      return "open box";
    case CompletedShape::Kind::Cylinder:
      return "cylinder";
    case CompletedShape::Kind::Chair:
      return "chair";
    case CompletedShape::Kind::Parts:
      return "parts";
    case CompletedShape::Kind::Mirrored:
      return "mirrored";
  }
  return "";
}

}  // namespace colift::perception
