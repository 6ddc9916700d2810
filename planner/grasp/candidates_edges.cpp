#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "planner/grasp/grasp_candidates.hpp"
#include "planner/grasp/grasp_lines.hpp"
#include "planner/grasp/round_plate.hpp"
#include "planner/hand/leg_face.hpp"

namespace colift::planner {
namespace {

using perception::Rectangle;
using perception::Scene;

/// True where the camera looked past the rim into the distance and saw the plate itself on the inner side.
bool free_rim(const SeenSpace& seen, const Vec3& rim, const Vec3& outward, const CandidateConfig& config) {
  const double beyond = seen.clearance(rim + config.edge_probe_m * outward);
  if (!(beyond > config.edge_jump_m + config.collision.sight_sigmas * seen.sigma(rim))) return false;
  // not where the plate's own edge pixels are, but a little inside
  return seen.at(rim - config.edge_probe_m * outward) == Sight::Surface;
}

double quantile(std::vector<double>& values, double part) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(part * static_cast<double>(values.size()));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

/// Thickness below a rim from the object's points just outside and just under it: what most places along it
/// say, so that legs do not count. None where too few places show any.
std::optional<double> seen_thickness(const Obstacles& obstacles, const Rectangle& plate,
                                     const RectangleEdge& edge, const SeenSpace& seen, const HandModel& hand,
                                     const RimConfig& config) {
  const double place_m = config.place_m;
  const Vec3 along = (edge.to - edge.from).normalized();
  const double length = (edge.to - edge.from).norm();
  const double noise = 3.0 * seen.sigma(edge.from);
  const double reach = hand.opening_m + 0.05, beside = 0.01 + noise;
  hal::Aabb around;
  for (const Vec3& end : {edge.from, edge.to}) {
    for (const double side : {-beside, beside}) {
      around.extend(end + side * edge.outward);
      around.extend(end + side * edge.outward - reach * plate.normal);
    }
  }
  std::vector<std::vector<double>> depths(static_cast<std::size_t>(length / place_m) + 1);
  obstacles.for_each_bucket(around, [&](const Obstacles::Bucket& bucket) {
    for (std::uint32_t i = bucket.begin; i < bucket.end; ++i) {
      if (obstacles.kind(i) != ObstacleKind::Object) continue;
      const Vec3 d = obstacles.points()[i].cast<double>() - edge.from;
      const double out = d.dot(edge.outward), below = -d.dot(plate.normal), l = d.dot(along);
      if (std::abs(out) > beside || l < 0.0 || l > length) continue;
      if (below > noise + 0.004 && below < reach)
        depths[static_cast<std::size_t>(l / place_m)].push_back(below);
    }
  });
  std::vector<double> places;
  for (std::vector<double>& depth : depths)
    if (depth.size() >= static_cast<std::size_t>(config.min_place_points))
      places.push_back(quantile(depth, config.depth_quantile));
  if (static_cast<double>(places.size()) < config.min_place_fraction * static_cast<double>(depths.size()))
    return std::nullopt;
  return quantile(places, 0.5);
}

struct Thickness {
  double value;
  std::string note;
};

Thickness measured_thickness(double thick_m) {
  return {thick_m, fmt::format("thickness {:.0f} mm from points below the rim", 1000 * thick_m)};
}

Thickness assumed_thickness(const CandidateConfig& config) {
  return {config.assumed_thickness_m,
          fmt::format("thickness assumed {:.0f} mm: the rim's own face was not seen",
                      1000 * config.assumed_thickness_m)};
}

Thickness thickness_at(const Scene& scene, const Obstacles& obstacles, int surface, const Rectangle& plate,
                       const RectangleEdge& edge, const SeenSpace& seen, const CompletedSolids& solids,
                       const HandModel& hand, const CandidateConfig& config) {
  // the face that closes most of the plate's edges says how thick the plate is
  double longest = 0.0, deep = 0.0;
  for (const CompletedSolid& solid : solids) {
    if (solid.a != surface && solid.b != surface) continue;
    const auto& other =
        std::get<Rectangle>(scene.surfaces[static_cast<std::size_t>(solid.a == surface ? solid.b : solid.a)]);
    if (is_leg_face(other, plate, seen, config.solids.leg)) continue;
    const double length = solid.extent_along(plate.normal.cross(other.normal));
    if (length > longest) longest = length, deep = solid.extent_along(plate.normal);
  }
  if (deep > 0.0) return {deep, ""};
  if (const auto measured = seen_thickness(obstacles, plate, edge, seen, hand, config.rim))
    return measured_thickness(*measured);
  return assumed_thickness(config);
}

/// Grasps around a round plate: its rectangle touches the rim at four places at most.
void add_round_rim(const Scene& scene, int surface, const Rectangle& plate, const SeenSpace& seen,
                   const Obstacles& obstacles, const HandModel& hand, const CandidateConfig& config,
                   std::vector<GraspLine>& lines) {
  if (scene.ground && scene.ground->plane.height(plate.center) < config.edge_probe_m) return;
  const auto round = find_round_plate(plate, obstacles, seen);
  if (!round) return;
  const int places = static_cast<int>(2.0 * std::numbers::pi * round->radius / config.step_m);
  std::vector<RectangleEdge> rims;
  std::vector<double> thick;
  for (int k = 0; k < places; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / places;
    const Vec3 out = std::cos(angle) * plate.u + std::sin(angle) * plate.v;
    const Vec3 rim = round->center + round->radius * out,
               along = 0.5 * config.step_m * plate.normal.cross(out);
    if (seen.at(rim - config.edge_probe_m * out) != Sight::Surface) continue;
    rims.push_back({out, rim - along, rim + along});
    if (const auto t = seen_thickness(obstacles, plate, rims.back(), seen, hand, config.rim))
      thick.push_back(*t);
  }
  // no face closes a round plate, so that no solid says how thick it is
  const Thickness thickness =
      thick.empty() ? assumed_thickness(config) : measured_thickness(quantile(thick, 0.5));
  if (thickness.value < config.min_width_m || thickness.value > hand.opening_m) return;
  for (const RectangleEdge& edge : rims) {
    GraspLine line;
    line.kind = GraspKind::Edge;
    line.surface = surface;
    line.approach = -edge.outward;
    line.closing = thumb_up(plate.normal, scene);
    line.width = thickness.value;
    line.note = thickness.note;
    line.from = line.to = 0.5 * (edge.from + edge.to) - 0.5 * thickness.value * plate.normal;
    lines.push_back(line);
  }
}

}  // namespace

std::vector<GraspLine> edge_lines(const Scene& scene, const SeenSpace& seen, const CompletedSolids& solids,
                                  const Obstacles& obstacles, const HandModel& hand,
                                  const CandidateConfig& config) {
  const double probe_step = config.rim.probe_step_m;
  std::vector<GraspLine> lines;
  for (std::size_t i = 0; i < scene.surfaces.size(); ++i) {
    const auto* plate = std::get_if<Rectangle>(&scene.surfaces[i]);
    // a strip that the hand spans is itself the edge face of something
    if (plate == nullptr || plate->size.minCoeff() < 2.0 * config.end_margin_m) continue;
    for (const RectangleEdge& edge : edges_of(*plate)) {
      const double length = (edge.to - edge.from).norm();
      const Vec3 along = (edge.to - edge.from) / length;
      // faces that could close the body at this edge
      std::vector<const Rectangle*> closing;
      for (const perception::Surface& s : scene.surfaces) {
        const auto* other = std::get_if<Rectangle>(&s);
        if (other != nullptr && other != plate && faces_out(edge, *other, config.solids))
          closing.push_back(other);
      }
      const int probes = static_cast<int>(std::floor(length / probe_step)) + 1;

      std::optional<Thickness> thickness;
      int run = 0;  // free places up to the present one
      for (int k = 0; k <= probes; ++k) {
        const Vec3 rim = edge.from + std::min(k * probe_step, length) * along;
        const bool on_ground =
            scene.ground &&
            scene.ground->plane.height(rim + config.edge_probe_m * edge.outward) < config.edge_probe_m;
        const auto closes = [&](const Rectangle* other) {
          return distance_to(*other, rim) < config.adjoin_m;
        };
        const bool free = k < probes && !on_ground && free_rim(seen, rim, edge.outward, config) &&
                          std::none_of(closing.begin(), closing.end(), closes);
        if (free) {
          ++run;
          continue;
        }
        const double run_length = (run - 1) * probe_step;
        const int first = k - run;
        run = 0;
        if (run_length < 2.0 * config.end_margin_m) continue;
        if (!thickness) {
          thickness =
              thickness_at(scene, obstacles, static_cast<int>(i), *plate, edge, seen, solids, hand, config);
        }
        if (thickness->value < config.min_width_m || thickness->value > hand.opening_m) continue;
        GraspLine line;
        line.kind = GraspKind::Edge;
        line.surface = static_cast<int>(i);
        line.approach = -edge.outward;
        line.closing = thumb_up(plate->normal, scene);
        line.width = thickness->value;
        line.note = thickness->note;
        const Vec3 middle = -0.5 * thickness->value * plate->normal;
        line.from = edge.from + (first * probe_step + config.end_margin_m) * along + middle;
        line.to = edge.from + (first * probe_step + run_length - config.end_margin_m) * along + middle;
        lines.push_back(line);
      }
    }
    add_round_rim(scene, static_cast<int>(i), *plate, seen, obstacles, hand, config, lines);
  }
  return lines;
}

}  // namespace colift::planner
