#include "planner/grasp/body_depth.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace colift::planner {
namespace {

constexpr double kPlace_m = 0.03;      // between places along a line
constexpr double kHalfPlace_m = 0.01;  // what counts as one place: half a fingertip's width
constexpr double kFingertip_m = 0.015;
constexpr double kStep_m = 0.003;    // about a pixel at 1.5 m
constexpr double kAside_m = 0.012;   // clear of the noise at its edges
constexpr double kBeside_m = 0.006;  // points of its sides lie this far outside of its width
// Of its width a body is at least this deep: where the camera saw the space behind it, and where it saw past
// both sides only. A face that is found on a tube lies behind the tube's front and is as wide as its
// widest noise: pads at less than this let a tube go outwards.
constexpr double kLeastSeen = 0.5, kLeastHidden = 0.75;
// A side of which this part of the width shows in depth was seen, and behind its back edge, this far within
// the width, there is nothing where the camera looked through.
constexpr double kSideSeen = 0.3, kWithin_m = 0.006;

// How deep the body is by where the first stretch begins, wide enough for a fingertip, through which the
// camera looked: behind the body, past it on both sides where it hides what is behind it, or past the back
// edge of the side that faces the camera, `last` m deep.
std::optional<double> seen_depth(const Vec3& place, const GraspLine& line, const SeenSpace& seen, double last,
                                 double reach_m) {
  const Vec3 aside = (0.5 * line.width + kAside_m) * line.closing;
  const Vec3 within = (0.5 * line.width - kWithin_m) * line.closing;
  const Vec3 near_side = (seen.camera() - place).dot(line.closing) < 0.0 ? Vec3(-within) : within;
  const bool side_seen = last >= kSideSeen * line.width;
  int free = 0, behind = 0;  // steps in a row; of them behind the body itself
  for (double d = kStep_m; d <= reach_m; d += kStep_m) {
    const Vec3 p = place + d * line.approach;
    const bool is_behind =
        seen.at(p) == Sight::Free || (side_seen && d > last && seen.at(p + near_side) == Sight::Free);
    const bool is_free =
        is_behind || (seen.at(p + aside) == Sight::Free && seen.at(p - aside) == Sight::Free);
    free = is_free ? free + 1 : 0;
    behind = is_behind ? behind + 1 : 0;
    if (free * kStep_m < kFingertip_m) continue;
    const double least = behind == free ? kLeastSeen : kLeastHidden;
    return std::clamp(d - (free - 1) * kStep_m, least * line.width, line.width);
  }
  return std::nullopt;
}

double last_point(const Vec3& place, const GraspLine& line, const Obstacles& obstacles, double reach_m) {
  const Vec3 along = line.closing.cross(line.approach);
  const double beside = 0.5 * line.width + kBeside_m;
  hal::Aabb around;
  for (const double d : {0.0, reach_m})
    for (const double y : {-beside, beside})
      for (const double x : {-kHalfPlace_m, kHalfPlace_m})
        around.extend(place + d * line.approach + y * line.closing + x * along);
  double last = 0.0;
  obstacles.for_each_bucket(around, [&](const Obstacles::Bucket& bucket) {
    for (std::uint32_t i = bucket.begin; i < bucket.end; ++i) {
      if (obstacles.kind(i) != ObstacleKind::Object) continue;
      const Vec3 d = obstacles.points()[i].cast<double>() - place;
      const double depth = d.dot(line.approach);
      if (depth > reach_m || std::abs(d.dot(line.closing)) > beside || std::abs(d.dot(along)) > kHalfPlace_m)
        continue;
      last = std::max(last, depth);
    }
  });
  return last;
}

}  // namespace

std::optional<double> body_depth(const GraspLine& line, const Obstacles& obstacles, const SeenSpace& seen,
                                 double reach_m) {
  const int spans = std::max(1, static_cast<int>(std::ceil(line.length() / kPlace_m)));
  std::vector<double> depths;
  for (int i = 0; i <= spans; ++i) {
    const Vec3 place = line.from + static_cast<double>(i) / spans * (line.to - line.from);
    const double last = last_point(place, line, obstacles, reach_m);
    if (const auto depth = seen_depth(place, line, seen, last, reach_m))
      depths.push_back(std::max(last, *depth));
    else if (last < line.width + kAside_m)  // seen straight on: of a plate its sides would show
      depths.push_back(line.width);
  }
  // one place at which something else shows behind the body is not the rule
  if (2 * depths.size() <= static_cast<std::size_t>(spans)) return std::nullopt;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  return *middle;
}

std::vector<GraspLine> bar_lines(const std::vector<GraspLine>& lines, const Vec3& up, double max_bar_m) {
  constexpr double kSameCosine = 0.95, kSamePlace_m = 0.03;
  std::vector<GraspLine> found;
  for (const GraspLine& line : lines) {
    if (!line.depth || line.width > max_bar_m || *line.depth > max_bar_m) continue;
    const Vec3 to_axis = 0.5 * *line.depth * line.approach;
    for (const Vec3& approach : {line.closing, Vec3(-line.closing)}) {
      GraspLine other = line;
      other.width = *line.depth;
      other.depth = line.width;
      other.approach = approach;
      other.closing = line.approach.dot(up) < 0.0 ? Vec3(-line.approach) : line.approach;  // thumb up
      const Vec3 to_face = to_axis - 0.5 * line.width * approach;
      other.from += to_face;
      other.to += to_face;
      const auto same = [&](const GraspLine& l) {
        const Vec3 middle = 0.5 * (other.from + other.to);
        return l.approach.dot(approach) > kSameCosine && (l.nearest(middle) - middle).norm() < kSamePlace_m;
      };
      if (std::none_of(lines.begin(), lines.end(), same) && std::none_of(found.begin(), found.end(), same))
        found.push_back(std::move(other));
    }
  }
  return found;
}

}  // namespace colift::planner
