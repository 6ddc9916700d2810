#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"
#include "planner/grasp/grasp_candidates.hpp"
#include "planner/grasp/grasp_lines.hpp"

namespace colift::planner {
namespace {

using perception::Cylinder;
using perception::Rectangle;
using perception::Scene;

/// From both ends of a segment inwards by the margin; its middle where it is shorter than that.
void set_ends(GraspLine& line, const Vec3& middle, const Vec3& direction, double length, double margin) {
  const double half = std::max(0.0, 0.5 * length - margin);
  line.from = middle - half * direction;
  line.to = middle + half * direction;
}

}  // namespace

Vec3 GraspLine::nearest(const Vec3& p) const {
  const Vec3 d = to - from;
  const double squared = d.squaredNorm();
  if (squared <= 0.0) return from;
  return from + std::clamp(d.dot(p - from) / squared, 0.0, 1.0) * d;
}

Vec3 thumb_up(const Vec3& closing, const Scene& scene) {
  const Vec3 up = scene.ground ? scene.ground->plane.normal : Vec3::UnitZ();
  return closing.dot(up) < 0.0 ? Vec3(-closing) : closing;
}

std::vector<GraspLine> ega5_lines(const Scene& scene, const HandModel& hand, const CandidateConfig& config) {
  std::vector<GraspLine> lines;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const auto* r = std::get_if<Rectangle>(&scene.surfaces[i]);
    if (r == nullptr) continue;
    const bool u_is_narrow = r->size.x() <= r->size.y();
    const Vec3 narrow = u_is_narrow ? r->u : r->v, wide = u_is_narrow ? r->v : r->u;
    const double width = r->size.minCoeff(), length = r->size.maxCoeff();
    if (width < config.min_width_m || length < config.min_length_m || width > hand.opening_m) continue;

    GraspLine line;
    line.surface = static_cast<int>(i);
    line.approach = -r->normal;
    line.width = width;
    line.closing = thumb_up(narrow, scene);
    set_ends(line, r->center, wide, length, config.end_margin_m);
    lines.push_back(line);
    if (length > hand.opening_m) continue;
    line.width = length;
    line.closing = thumb_up(wide, scene);
    set_ends(line, r->center, narrow, width, config.end_margin_m);
    lines.push_back(line);
  }
  return lines;
}

std::vector<GraspLine> wrap_lines(const Scene& scene, const Vec3* camera, const HandModel& hand,
                                  const CandidateConfig& config) {
  std::vector<GraspLine> lines;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const auto* c = std::get_if<Cylinder>(&scene.surfaces[i]);
    if (c == nullptr || 2.0 * c->radius < config.min_width_m || 2.0 * c->radius > hand.opening_m) continue;
    if (c->length < config.min_length_m) continue;

    const Vec3 axis = c->axis.normalized();
    Vec3 front = hal::tangents(axis).first;
    double reach_deg = 180.0 - 1e-6;
    if (camera != nullptr) {
      Vec3 towards = *camera - c->center;
      towards -= axis * axis.dot(towards);
      if (towards.norm() > 1e-6) front = towards.normalized();
      reach_deg = 90.0 - 1e-6;  // from the visible half only
    }
    const Vec3 side = axis.cross(front);
    const int steps = static_cast<int>(std::floor(reach_deg / config.wrap_step_deg));
    for (int k = -steps; k <= steps; ++k) {
      const double angle = hal::deg_to_rad(k * config.wrap_step_deg);
      const Vec3 out = std::cos(angle) * front + std::sin(angle) * side;
      GraspLine line;
      line.kind = GraspKind::Wrap;
      line.surface = static_cast<int>(i);
      line.approach = -out;
      line.closing = thumb_up(axis.cross(out), scene);
      line.width = 2.0 * c->radius;
      set_ends(line, c->center + c->radius * out, axis, c->length, config.end_margin_m);
      lines.push_back(line);
    }
  }
  return lines;
}

}  // namespace colift::planner
