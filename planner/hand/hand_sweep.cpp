#include "planner/hand/hand_sweep.hpp"

#include <algorithm>
#include <cmath>

#include "hal/types/units.hpp"

namespace colift::planner {
namespace {

/// Half extents of a box along the axes of H.
Vec3 half_extent(const HandBox& box) {
  const double cy = std::abs(box.ey), cz = std::abs(box.ez);
  return {box.hx, box.h1 * cy + box.h2 * cz, box.h1 * cz + box.h2 * cy};
}

/// For arguments in single precision.
constexpr double kRounding = 2e-5;

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
  const double half_width = 0.5 * std::max(hand.finger.inner_width_m, hand.finger.outer_width_m);
  for (const HandFinger& finger : hand.fingers) {
    names_.push_back(finger.part);
    slabs_.push_back({finger.x_m, half_width, static_cast<double>(finger.side)});
  }
  for (const Slab& a : slabs_) {
    for (const Slab& b : slabs_) {
      if (&a != &b && std::abs(a.x - b.x) <= 2.0 * half_width) apart_ = false;
    }
  }
  max_depth_ = hand.finger.half_thickness_m;

  // the cells of the tables count steps in a byte; a finer step than that is of no use to anybody
  const double step = std::max(step_deg, 0.75);
  for (int k = 0; k < 200; ++k) {
    const double q = (hand.finger.open_deg + k * step) * hal::kRadPerDeg;
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
  make_finger_table();
  point_table_ = table(0.005, 0.0);
  cell_table_ = table(0.005, cell_radius_m);
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

std::optional<SweepHit> HandSweep::first_hit(const Vec3& p, int last) const {
  for (std::size_t i = 0; i < fixed_swept_.size(); ++i) {
    const double depth = fixed_swept_[i].depth(p.x(), p.y(), p.z());
    if (depth >= 0.0) return SweepHit{static_cast<int>(i), 0, depth};
  }
  for (std::size_t i = 0; i < links_; ++i) {
    if (const auto depth = swept_depth(boxes_[i], p)) {
      return SweepHit{static_cast<int>(fixed_.size() + i / 2), 0, *depth};
    }
  }
  for (int k = 1; k <= last; ++k) {
    const HandBox* boxes = finger_boxes(k);
    for (std::size_t i = 0; i < links_; ++i) {
      const double depth = boxes[i].depth(p.x(), p.y(), p.z());
      if (depth >= 0.0) return SweepHit{static_cast<int>(fixed_.size() + i / 2), k, depth};
    }
  }
  return std::nullopt;
}

std::optional<SweepHit> HandSweep::quick_hit(const Vec3& p, int last, double min_m) const {
  for (std::size_t i = 0; i < fixed_swept_.size(); ++i) {
    const double depth = fixed_swept_[i].depth(p.x(), p.y(), p.z());
    if (depth >= 0.0) return SweepHit{static_cast<int>(i), 0, depth};
  }
  std::optional<SweepHit> first;
  if (!apart_) min_m = 0.0;
  for (std::size_t f = 0; f < slabs_.size(); ++f) {
    const double inside = slabs_[f].half - std::abs(p.x() - slabs_[f].x);
    if (inside < 0.0) continue;
    const int from = finger_table_.at(slabs_[f].side * p.y(), p.z());
    if (from > last) continue;
    const int part = static_cast<int>(fixed_.size() + f);
    if (from == 0) {
      for (std::size_t i = 2 * f; i < 2 * f + 2; ++i) {
        if (const auto depth = swept_depth(boxes_[i], p)) return SweepHit{part, 0, *depth};
      }
    }
    // the first hit decides; what it may leave out is a point whose first hit is not deep enough
    if (inside < min_m || max_depth_ < min_m) continue;
    const int end = first ? first->step - 1 : last;
    for (int k = std::max(1, from); k <= end; ++k) {
      const HandBox* boxes = finger_boxes(k) + 2 * f;
      double depth = boxes[0].depth(p.x(), p.y(), p.z());
      if (depth < 0.0) depth = boxes[1].depth(p.x(), p.y(), p.z());
      if (depth < 0.0) continue;
      first = SweepHit{part, k, depth};
      break;
    }
  }
  return first;
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
  // one cell more on each side, for rounding
  const auto low = [&](int axis) {
    return std::max(0, static_cast<int>(std::floor((center[axis] - half[axis] - origin[axis]) / cell_m)) - 1);
  };
  const auto end = [&](int axis, int n) {
    return std::min(n, static_cast<int>(std::floor((center[axis] + half[axis] - origin[axis]) / cell_m)) + 2);
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
  const double radius = radius_m + 0.5 * std::sqrt(3.0) * cell_m + kRounding;
  Table t;
  t.cell_m = static_cast<float>(cell_m);
  t.per_m = static_cast<float>(1.0 / cell_m);
  t.origin = (bounds_.min() - Vec3::Constant(radius)).cast<float>();
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

void HandSweep::make_finger_table() {
  FingerTable& t = finger_table_;
  if (links_ == 0) return;
  const double side = slabs_.front().side, radius = 0.5 * std::sqrt(2.0) * FingerTable::kCell + kRounding;
  // in the plane of the first finger; a turned box (0, ey, ez) keeps its shape when its y is mirrored
  const auto in_plane = [&](HandBox box) {
    box.cy *= side;
    box.ey *= side;
    box.hx += radius;
    box.h1 += radius;
    box.h2 += radius;
    return box;
  };
  hal::Aabb around;
  const auto extend = [&](const HandBox& box) {
    const Vec3 center(0.0, box.cy, box.cz), half = half_extent(box);
    around.extend(center - half);
    around.extend(center + half);
  };
  for (int k = 0; k <= steps(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) extend(in_plane(finger_boxes(k)[i]));
  }
  for (std::size_t i = 0; i < 2; ++i) extend(in_plane(shifted(boxes_[i], -approach_m_)));
  t.y0 = around.min().y();
  t.z0 = around.min().z();
  t.ny = static_cast<int>(around.sizes().y() / FingerTable::kCell) + 1;
  t.nz = static_cast<int>(around.sizes().z() / FingerTable::kCell) + 1;
  t.step.assign(static_cast<std::size_t>(t.ny) * static_cast<std::size_t>(t.nz), kNever);
  const auto mark = [&](const HandBox& box, int step) {
    const Vec3 half = half_extent(box);
    const auto low = [](double value, double origin) {
      return std::max(0, static_cast<int>((value - origin) / FingerTable::kCell) - 1);
    };
    const auto end = [](double value, double origin, int n) {
      return std::min(n, static_cast<int>((value - origin) / FingerTable::kCell) + 2);
    };
    for (int iz = low(box.cz - half.z(), t.z0); iz < end(box.cz + half.z(), t.z0, t.nz); ++iz) {
      for (int iy = low(box.cy - half.y(), t.y0); iy < end(box.cy + half.y(), t.y0, t.ny); ++iy) {
        const double y = t.y0 + (iy + 0.5) * FingerTable::kCell, z = t.z0 + (iz + 0.5) * FingerTable::kCell;
        std::uint8_t& cell = t.step[static_cast<std::size_t>(iz * t.ny + iy)];
        if (box.depth(box.cx, y, z) >= 0.0) cell = std::min(cell, static_cast<std::uint8_t>(step));
      }
    }
  };
  // copies along the approach, each fat enough to reach the next
  const int copies = std::max(1, static_cast<int>(std::ceil(approach_m_ / (2.0 * FingerTable::kCell))));
  for (std::size_t i = 0; i < 2; ++i) {
    for (int c = 0; c <= copies; ++c) {
      HandBox copy = in_plane(shifted(boxes_[i], -approach_m_ * c / copies));
      copy.h1 += 0.5 * approach_m_ / copies;
      copy.h2 += 0.5 * approach_m_ / copies;
      mark(copy, 0);
    }
  }
  for (int k = 1; k <= steps(); ++k) {
    for (std::size_t i = 0; i < 2; ++i) mark(in_plane(finger_boxes(k)[i]), k);
  }
}

}  // namespace colift::planner
