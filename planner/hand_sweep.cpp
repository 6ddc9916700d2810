#include "planner/hand_sweep.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace colift::planner {
namespace {

/// Half extents of a box along the axes of H.
Vec3 half_extent(const HandBox& box) {
  const double cy = std::abs(box.ey), cz = std::abs(box.ez);
  return {box.hx, box.h1 * cy + box.h2 * cz, box.h1 * cz + box.h2 * cy};
}

HandBox shifted(HandBox box, double dz) {
  box.cz += dz;
  return box;
}

}  // namespace

HandSweep::HandSweep(const HandModel& hand, double approach_m, double step_deg, double cell_radius_m)
    : approach_m_(approach_m), links_(2 * hand.fingers.size()) {
  for (const HandCuboid& c : hand.cuboids) {
    names_.push_back(c.part);
    const Vec3 h = 0.5 * c.size_m;
    fixed_.push_back({c.center_m.x(), c.center_m.y(), c.center_m.z(), h.x(), h.y(), h.z(), 1.0, 0.0});
    HandBox swept = shifted(fixed_.back(), -0.5 * approach_m);
    swept.h2 += 0.5 * approach_m;
    fixed_swept_.push_back(swept);
  }
  for (const HandFinger& finger : hand.fingers) names_.push_back(finger.part);

  // the cells of the tables count steps in a byte; a finer step than that is of no use to anybody
  const double degree = std::numbers::pi / 180.0;
  const double step = std::max(step_deg, 0.75);
  for (int k = 0; k < 200; ++k) {
    const double q = (hand.finger.open_deg + k * step) * degree;
    const double half_gap = half_gap_at(hand, q);
    if (k > 0 && half_gap < 0.0) break;
    half_gap_m_.push_back(half_gap);
    for (const HandFinger& finger : hand.fingers) {
      const FingerPose pose = finger_at(hand, finger, q);
      boxes_.push_back(pose.inner);
      boxes_.push_back(pose.outer);
    }
  }

  const auto extend = [&](const HandBox& box) {
    const Vec3 center(box.cx, box.cy, box.cz), half = half_extent(box);
    bounds_.extend(center - half);
    bounds_.extend(center + half);
  };
  for (const HandBox& box : fixed_swept_) extend(box);
  for (const HandBox& box : boxes_) extend(box);
  for (std::size_t i = 0; i < links_; ++i) extend(shifted(boxes_[i], -approach_m_));
  bounds_ = hal::Aabb(bounds_.min() - Vec3::Constant(1e-9), bounds_.max() + Vec3::Constant(1e-9));
  point_table_ = table(0.005, 0.0);
  cell_table_ = table(0.010, cell_radius_m);
}

int HandSweep::last_step(double width_m) const {
  int last = 0;
  while (last + 1 < static_cast<int>(half_gap_m_.size()) &&
         half_gap_m_[static_cast<std::size_t>(last) + 1] >= 0.5 * width_m) {
    ++last;
  }
  return last;
}

std::optional<double> HandSweep::swept_depth(const HandBox& box, const Vec3& p) const {
  // seen from the moving hand the point travels by +t along Hz, t in [0, approach]: clip that segment by the
  // box
  const double dx = std::abs(p.x() - box.cx);
  if (dx > box.hx) return std::nullopt;
  const double dy = p.y() - box.cy, dz = p.z() - box.cz;
  double t0 = 0.0, t1 = approach_m_;
  const auto clip = [&](double start, double rate, double half) {
    if (rate == 0.0) return std::abs(start) <= half;
    double enter = (-half - start) / rate, leave = (half - start) / rate;
    if (enter > leave) std::swap(enter, leave);
    t0 = std::max(t0, enter);
    t1 = std::min(t1, leave);
    return t0 <= t1;
  };
  if (!clip(dy * box.ey + dz * box.ez, box.ez, box.h1)) return std::nullopt;
  if (!clip(dz * box.ey - dy * box.ez, box.ey, box.h2)) return std::nullopt;
  return std::max(0.0, box.depth(p.x(), p.y(), p.z() + 0.5 * (t0 + t1)));
}

std::optional<SweepHit> HandSweep::first_hit(const Vec3& p, int last, int from) const {
  if (from == 0) {
    for (std::size_t i = 0; i < fixed_swept_.size(); ++i) {
      const double depth = fixed_swept_[i].depth(p.x(), p.y(), p.z());
      if (depth >= 0.0) return SweepHit{static_cast<int>(i), 0, depth};
    }
    for (std::size_t i = 0; i < links_; ++i) {
      if (const auto depth = swept_depth(boxes_[i], p)) {
        return SweepHit{static_cast<int>(fixed_.size() + i / 2), 0, *depth};
      }
    }
    from = 1;
  }
  for (int k = from; k <= last; ++k) {
    const HandBox* boxes = finger_boxes(k);
    for (std::size_t i = 0; i < links_; ++i) {
      const double depth = boxes[i].depth(p.x(), p.y(), p.z());
      if (depth >= 0.0) return SweepHit{static_cast<int>(fixed_.size() + i / 2), k, depth};
    }
  }
  return std::nullopt;
}

HandSweep::Lowest HandSweep::lowest(const hal::Plane& plane, int last) const {
  const Vec3& n = plane.normal;
  const double back = std::min(0.0, -approach_m_ * n.z());
  Lowest found{-1, 0, std::numeric_limits<double>::infinity()};
  const auto look = [&](const HandBox& box, int part, int step, double drop) {
    const double along1 = n.y() * box.ey + n.z() * box.ez, along2 = n.z() * box.ey - n.y() * box.ez;
    const double height = n.x() * box.cx + n.y() * box.cy + n.z() * box.cz + plane.offset + drop -
                          (std::abs(n.x()) * box.hx + std::abs(along1) * box.h1 + std::abs(along2) * box.h2);
    if (height < found.height_m) found = {part, step, height};
  };
  for (std::size_t i = 0; i < fixed_.size(); ++i) look(fixed_[i], static_cast<int>(i), 0, back);
  for (int k = 0; k <= last; ++k) {
    const HandBox* boxes = finger_boxes(k);
    for (std::size_t i = 0; i < links_; ++i) {
      look(boxes[i], static_cast<int>(fixed_.size() + i / 2), k, k == 0 ? back : 0.0);
    }
  }
  return found;
}

void HandSweep::Table::mark(const HandBox& box, double radius, int first_step) {
  HandBox fat = box;
  fat.hx += radius;
  fat.h1 += radius;
  fat.h2 += radius;
  const Vec3 center(box.cx, box.cy, box.cz), half = half_extent(fat);
  const auto low = [&](int axis) {
    return std::max(0, static_cast<int>(std::floor((center[axis] - half[axis] - origin[axis]) / cell_m)));
  };
  const auto end = [&](int axis, int n) {
    return std::min(n, static_cast<int>(std::floor((center[axis] + half[axis] - origin[axis]) / cell_m)) + 1);
  };
  const int x0 = low(0), x1 = end(0, nx);
  for (int iz = low(2); iz < end(2, nz); ++iz) {
    for (int iy = low(1); iy < end(1, ny); ++iy) {
      const double y = origin.y() + (iy + 0.5) * cell_m, z = origin.z() + (iz + 0.5) * cell_m;
      // boxes are turned about Hx only: one test settles a row
      if (fat.depth(fat.cx, y, z) < 0.0) continue;
      std::uint8_t* row = step.data() + static_cast<std::ptrdiff_t>((iz * ny + iy) * nx);
      for (int ix = x0; ix < x1; ++ix) row[ix] = std::min(row[ix], static_cast<std::uint8_t>(first_step));
    }
  }
}

HandSweep::Table HandSweep::table(double cell_m, double radius_m) const {
  // half the diagonal of a cell, and a little for rounding
  const double radius = radius_m + 0.5 * std::sqrt(3.0) * cell_m + 1e-6;
  Table t;
  t.cell_m = cell_m;
  t.origin = bounds_.min() - Vec3::Constant(radius);
  const Vec3 size = bounds_.sizes() + Vec3::Constant(2.0 * radius);
  t.nx = static_cast<int>(std::ceil(size.x() / cell_m)) + 1;
  t.ny = static_cast<int>(std::ceil(size.y() / cell_m)) + 1;
  t.nz = static_cast<int>(std::ceil(size.z() / cell_m)) + 1;
  t.step.assign(
      static_cast<std::size_t>(t.nx) * static_cast<std::size_t>(t.ny) * static_cast<std::size_t>(t.nz),
      kNever);
  for (const HandBox& box : fixed_swept_) t.mark(box, radius, 0);
  // the approach of a tilted link is covered by copies of it, each fat enough to reach the next
  const int copies = std::max(1, static_cast<int>(std::ceil(approach_m_ / cell_m)));
  for (std::size_t i = 0; i < links_; ++i) {
    for (int c = 0; c <= copies; ++c) {
      t.mark(shifted(boxes_[i], -approach_m_ * c / copies), radius + 0.5 * approach_m_ / copies, 0);
    }
  }
  for (int k = 1; k <= steps(); ++k) {
    for (std::size_t i = 0; i < links_; ++i) t.mark(finger_boxes(k)[i], radius, k);
  }
  return t;
}

}  // namespace colift::planner
