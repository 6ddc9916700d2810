#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planner/hand/hand_model.hpp"

namespace colift::planner {

/// Where in the hand a point was found.
struct SweepHit {
  int part = -1;       ///< Index for HandSweep::part_name().
  int step = 0;        ///< 0: on the straight approach or with the hand open; k: while closing, at step k.
  double depth_m = 0;  ///< Distance to the nearest face of the box that holds the point.
};

/// The volume that a hand passes through in H: its body and its open fingers along the last `approach_m` of
/// the straight approach, then the fingers closing in steps of `step_deg`. Step k belongs to one angle for
/// every candidate; how far the closing goes is the candidate's: last_step(width).
///
/// Beside the exact test the class holds tables of H with the first step that can touch a cell, so that most
/// points and most buckets of points are settled by one look-up. The tables only ever err towards "may
/// touch". All fingers move alike in their own planes, so that one finer table in two dimensions serves them
/// all.
class HandSweep {
 public:
  HandSweep(const HandModel& hand, double approach_m, double step_deg, double cell_radius_m);

  /// Last closing step at which the fingers still leave `width_m` free between them; 0 when even the open
  /// hand does not.
  [[nodiscard]] int last_step(double width_m) const;
  [[nodiscard]] int steps() const { return static_cast<int>(half_gap_m_.size()) - 1; }

  /// First place, in the order of the motion, at which a part of the hand holds the point, up to closing step
  /// `last`. Asks every box of every step.
  [[nodiscard]] std::optional<SweepHit> first_hit(const Vec3& p_H, int last) const;

  /// The same from the tables, in a fraction of the time. May leave out a hit while closing that is less than
  /// `min_m` deep.
  [[nodiscard]] std::optional<SweepHit> quick_hit(const Vec3& p_H, int last, double min_m = 0.0) const;

  static constexpr std::uint8_t kNever = 255;

  /// First step that may hold the point itself, or any point within the cell radius of it; kNever if none.
  /// Points may be off by 10 um.
  [[nodiscard]] std::uint8_t point_step(float x, float y, float z) const { return point_table_.at(x, y, z); }
  [[nodiscard]] std::uint8_t cell_step(float x, float y, float z) const { return cell_table_.at(x, y, z); }

  /// Box in H that contains the whole volume.
  [[nodiscard]] const hal::Aabb& bounds() const { return bounds_; }

  /// How far the hand reaches below a plane (given in H) up to closing step `last`: the part and the height
  /// of its lowest corner, negative when it is below the plane. Approach included.
  struct Lowest {
    int part = -1;
    int step = 0;
    double height_m = 0;
  };
  [[nodiscard]] Lowest lowest(const hal::Plane& plane_H, int last) const;

  /// Lowest corner of bounds() over a plane in H; never above what lowest() says.
  [[nodiscard]] double bounds_height(const hal::Plane& plane_H) const {
    const Vec3 middle = bounds_.center(), half = 0.5 * bounds_.sizes();
    return plane_H.height(middle) - plane_H.normal.cwiseAbs().dot(half);
  }

  [[nodiscard]] const std::string& part_name(int part) const {
    return names_[static_cast<std::size_t>(part)];
  }
  [[nodiscard]] int fixed_parts() const { return static_cast<int>(fixed_.size()); }
  [[nodiscard]] int parts() const { return static_cast<int>(names_.size()); }
  [[nodiscard]] double approach_m() const { return approach_m_; }

  /// The boxes of closing step k, inner then outer link for each finger. Step 0 is the open hand.
  [[nodiscard]] const HandBox* finger_boxes(int step) const {
    return &boxes_[static_cast<std::size_t>(step) * links_];
  }
  [[nodiscard]] std::size_t links() const { return links_; }
  [[nodiscard]] const std::vector<HandBox>& fixed_boxes() const { return fixed_; }

 private:
  /// A grid over H with the first step that can touch each cell.
  struct Table {
    float cell_m = 0.0f, per_m = 0.0f;
    Eigen::Vector3f origin = Eigen::Vector3f::Zero();
    int nx = 0, ny = 0, nz = 0;
    std::vector<std::uint8_t> step;

    [[nodiscard]] std::uint8_t at(float x, float y, float z) const {
      const float fx = (x - origin.x()) * per_m, fy = (y - origin.y()) * per_m, fz = (z - origin.z()) * per_m;
      if (!(fx >= 0 && fy >= 0 && fz >= 0)) return kNever;
      const int ix = static_cast<int>(fx), iy = static_cast<int>(fy), iz = static_cast<int>(fz);
      if (ix >= nx || iy >= ny || iz >= nz) return kNever;
      return step[static_cast<std::size_t>((iz * ny + iy) * nx + ix)];
    }
    void mark(const HandBox& box, double radius, int first_step);
  };
  /// A finger's own plane: across (away from the middle of the hand) and along Hz.
  struct FingerTable {
    static constexpr double kCell =
        0.002;  ///< Resolution of the table (m); what it lets pass is tested exactly.
    double y0 = 0.0, z0 = 0.0;
    int ny = 0, nz = 0;
    std::vector<std::uint8_t> step;

    [[nodiscard]] std::uint8_t at(double out, double z) const {
      const double fy = (out - y0) * (1.0 / kCell), fz = (z - z0) * (1.0 / kCell);
      if (!(fy >= 0 && fz >= 0)) return kNever;
      const int iy = static_cast<int>(fy), iz = static_cast<int>(fz);
      return iy < ny && iz < nz ? step[static_cast<std::size_t>(iz * ny + iy)] : kNever;
    }
  };
  /// Where a finger moves: the middle of its plane and half its greatest width.
  struct Slab {
    double x, half, side;
  };
  [[nodiscard]] Table table(double cell_m, double radius_m) const;
  void make_finger_table();
  [[nodiscard]] std::optional<double> swept_depth(const HandBox& box, const Vec3& p) const;

  double approach_m_;
  std::size_t links_ = 0;
  std::vector<HandBox> fixed_;        ///< Body, where it stands at the end of the approach.
  std::vector<HandBox> fixed_swept_;  ///< The same, drawn out backwards along the approach.
  std::vector<HandBox> boxes_;        ///< links_ for each step.
  std::vector<double> half_gap_m_;    ///< For each step.
  std::vector<std::string> names_;    ///< Body parts, then fingers.
  std::vector<Slab> slabs_;           ///< Of the fingers.
  bool apart_ = true;                 ///< No two fingers ever hold the same point.
  double max_depth_ = 0.0;            ///< That a finger's box allows.
  hal::Aabb bounds_;
  FingerTable finger_table_;
  Table point_table_, cell_table_;
};

}  // namespace colift::planner
