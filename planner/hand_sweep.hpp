#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "planner/hand_model.hpp"

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
/// touch".
class HandSweep {
 public:
  HandSweep(const HandModel& hand, double approach_m, double step_deg, double cell_radius_m);

  /// Last closing step at which the fingers still leave `width_m` free between them; 0 when even the open
  /// hand does not.
  [[nodiscard]] int last_step(double width_m) const;
  [[nodiscard]] int steps() const { return static_cast<int>(half_gap_m_.size()) - 1; }

  /// First place, in the order of the motion, at which a part of the hand holds the point, up to closing step
  /// `last`. `from` promises that no earlier step holds it.
  [[nodiscard]] std::optional<SweepHit> first_hit(const Vec3& p_H, int last, int from = 0) const;

  static constexpr std::uint8_t kNever = 255;

  /// First step that may hold the point itself, or any point within the cell radius of it; kNever if none.
  [[nodiscard]] std::uint8_t point_step(double x, double y, double z) const {
    return point_table_.at(x, y, z);
  }
  [[nodiscard]] std::uint8_t cell_step(double x, double y, double z) const { return cell_table_.at(x, y, z); }

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
    double cell_m = 0.0;
    Vec3 origin = Vec3::Zero();
    int nx = 0, ny = 0, nz = 0;
    std::vector<std::uint8_t> step;

    [[nodiscard]] std::uint8_t at(double x, double y, double z) const {
      const double scale = 1.0 / cell_m;
      const double fx = (x - origin.x()) * scale, fy = (y - origin.y()) * scale,
                   fz = (z - origin.z()) * scale;
      if (!(fx >= 0 && fy >= 0 && fz >= 0 && fx < nx && fy < ny && fz < nz)) return kNever;
      return step[static_cast<std::size_t>((static_cast<int>(fz) * ny + static_cast<int>(fy)) * nx +
                                           static_cast<int>(fx))];
    }
    void mark(const HandBox& box, double radius, int first_step);
  };
  [[nodiscard]] Table table(double cell_m, double radius_m) const;
  [[nodiscard]] std::optional<double> swept_depth(const HandBox& box, const Vec3& p) const;

  double approach_m_;
  std::size_t links_ = 0;
  std::vector<HandBox> fixed_;        ///< Body, where it stands at the end of the approach.
  std::vector<HandBox> fixed_swept_;  ///< The same, drawn out backwards along the approach.
  std::vector<HandBox> boxes_;        ///< links_ for each step.
  std::vector<double> half_gap_m_;    ///< For each step.
  std::vector<std::string> names_;    ///< Body parts, then fingers.
  hal::Aabb bounds_;
  Table point_table_, cell_table_;
};

}  // namespace colift::planner
