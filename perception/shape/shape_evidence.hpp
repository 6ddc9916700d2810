#pragma once

#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "perception/shape/shape_completion.hpp"

namespace colift::perception {

/// Of one width at least (m).
[[nodiscard]] double median_width(std::vector<double> widths);

/// What one view says about parts of an object that were not seen: measures from its surfaces, its points and
/// the empty places beside them, on which complete_shape() decides. Refers to its arguments.
class ShapeEvidence {
 public:
  ShapeEvidence(const OrganisedCloud& cloud, const Target& target, const std::vector<Surface>& surfaces,
                const Ground& ground, const NoiseModel& noise, const CompletionConfig& config);

  /// The level face that may be the top of the whole; nullptr where there is none.
  [[nodiscard]] const Rectangle* find_top() const;

  /// A top and by how much (m) it was continued along its sides.
  struct Widened {
    Rectangle top;
    std::array<double, 2> added_m;
  };
  /// The top as far as the whole object goes: where part of it gave no data or is hidden by a back, the
  /// points below or beside it still tell. Nothing of tables, boxes and chairs sticks out under their tops.
  /// Only points up to `below_m` over the ground count.
  [[nodiscard]] Widened widened(const Rectangle& top, double below_m) const;

  /// Part of the points that lie clearly over a top.
  [[nodiscard]] double part_above(const Rectangle& top) const;

  /// What the camera saw at a point: nothing, so that it looked through; a surface; something nearer, or no
  /// data.
  enum class Sight { Empty, There, Unknown };
  [[nodiscard]] Sight at(const Vec3& point) const;
  /// Part of a face, or of a box, at which the camera looked through; Unknown does not count. NaN where all
  /// is unknown.
  [[nodiscard]] double gaps(const Rectangle& face) const;
  [[nodiscard]] double gaps(const OrientedBox& box) const;

  /// Part of what would be the visible sides of a solid below this top at which the camera saw a surface;
  /// where it saw nothing or something nearer does not count. NaN when no side faces the camera.
  [[nodiscard]] double seen_support(const Rectangle& top) const;

  /// Outer sides along a horizontal direction: from an outer face, from an inner face and the wall behind it,
  /// else from the outermost points.
  [[nodiscard]] std::array<double, 2> sides_along(const Vec3& e) const;

  /// How far the points go along a direction, without strays; of those up to `below_m` over the ground.
  [[nodiscard]] std::array<double, 2> points_along(
      const Vec3& e, double below_m = std::numeric_limits<double>::infinity()) const;

  /// Thickness of a plate from a narrow upright face along one of its sides.
  [[nodiscard]] std::optional<double> edge_of(const Rectangle& top) const;
  /// Width of legs from upright narrow faces and thin upright cylinders below a height.
  [[nodiscard]] std::optional<double> leg_width(double height) const;

  /// Standard deviation (m) of the middle between two edges.
  [[nodiscard]] double end_sigma(double length) const;
  /// The same for a top; where it had to be continued to points of other faces, by noise and rags of those.
  [[nodiscard]] double side_sigma(const Widened& top, int axis) const;
  /// Of a height that a plane of many pixels gives, times a part.
  [[nodiscard]] double level_sigma(double part) const;

  [[nodiscard]] const Target& target() const { return target_; }
  [[nodiscard]] const hal::Plane& ground() const { return ground_; }
  [[nodiscard]] const Vec3& up() const { return up_; }
  [[nodiscard]] Vec3 eye() const { return cloud_.X_WC.translation(); }
  [[nodiscard]] const std::vector<const Rectangle*>& level() const { return level_; }
  [[nodiscard]] const std::vector<const Rectangle*>& upright() const { return upright_; }
  [[nodiscard]] const std::vector<Surface>& surfaces() const { return surfaces_; }
  [[nodiscard]] const OrganisedCloud& cloud() const { return cloud_; }
  [[nodiscard]] const Cylinder* cylinder() const { return cylinder_; }  ///< The largest, or nullptr.
  [[nodiscard]] const OrientedBox& footprint() const { return footprint_; }
  [[nodiscard]] double total_area_m2() const { return total_area_; }
  [[nodiscard]] double pixel_m() const { return pixel_m_; }
  [[nodiscard]] double depth_sigma_m() const { return depth_sigma_m_; }

 private:
  /// Coordinate against `out` of the outermost face that looks along it, when one is near the given end.
  [[nodiscard]] double outer_face(const Vec3& out, double end) const;

  const OrganisedCloud& cloud_;
  const Target& target_;
  const std::vector<Surface>& surfaces_;
  hal::Plane ground_;
  Vec3 up_;
  const NoiseModel& noise_;
  const CompletionConfig& config_;
  std::vector<const Rectangle*> level_, upright_;
  const Cylinder* cylinder_ = nullptr;
  double total_area_ = 0, pixel_m_ = 0, depth_sigma_m_ = 0;
  OrientedBox footprint_;
};

}  // namespace colift::perception
