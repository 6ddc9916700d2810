#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "hal/config/range.hpp"
#include "hal/robot_model/robot_model.hpp"
#include "hal/types/geometry.hpp"
#include "hal/types/result.hpp"
#include "perception/organised_cloud.hpp"

namespace octomap {
class OcTree;
}

namespace colift::perception {

/// When a ray counts as evidence for a cell.
struct CellViewConfig {
  double free_beyond_cells = 0.6;
  double two_hit_pixels = 3.0;

  template <class Visitor>
  void visit(Visitor& v) {
    v("free_beyond_cells", free_beyond_cells, hal::Range{0, 10},
      "Distance beyond a cell's middle at which a ray has passed through the cell, in edges of a cell.");
    v("two_hit_pixels", two_hit_pixels, hal::Range{0, 1000},
      "Cells that are wider than this in the image (px) are occupied after two hits: a single one is a "
      "flying pixel.");
  }
};

/// Resolution and extent of the collision world, and the evidence of its cells.
struct WorldMapConfig {
  double cell_m = 0.02;
  double max_range_m = 3.5;
  double robot_padding_m = 0.03;
  hal::Vec3 min_m{-1.2, -1.2, -0.05}, max_m{1.8, 1.2, 1.5};
  CellViewConfig view;

  template <class Visitor>
  void visit(Visitor& v) {
    v("cell_m", cell_m, hal::Range{0.005, 0.1}, "Edge of the smallest cell (m).");
    v("max_range_m", max_range_m, hal::Range{0.5, 10}, "Max distance of measurements that are entered (m).");
    v("robot_padding_m", robot_padding_m, hal::Range{0, 0.2},
      "Distance around the robot within which cells are freed as its own (m).");
    v("min_m", min_m, hal::Range{-100, 100}, "Lower corner of the mapped space in W (m).");
    v("max_m", max_m, hal::Range{-100, 100}, "Upper corner of the mapped space in W (m).");
    v("view", view, "How one frame frees and occupies cells.");
  }
};

/// What a cell of the map is.
enum class CellState : std::uint8_t {
  Free,       ///< A ray went through it.
  Occupied,   ///< A measurement ended in it (target, partner and robot are carved out).
  Hidden,     ///< No ray reached it because something measured stands before it.
  OutOfView,  ///< The camera does not look there, or measured nothing in that direction.
};

/// The map's cells on a regular grid, row-major x fastest: index = (iz * ny + iy) * nx + ix.
struct CellGrid {
  double cell_m = 0.02;
  hal::Vec3 origin = hal::Vec3::Zero();  ///< Lower corner of cell (0, 0, 0) in W.
  int nx = 0, ny = 0, nz = 0;
  std::vector<CellState> cells;

  [[nodiscard]] std::size_t index(int ix, int iy, int iz) const {
    return (static_cast<std::size_t>(iz) * static_cast<std::size_t>(ny) + static_cast<std::size_t>(iy)) *
               static_cast<std::size_t>(nx) +
           static_cast<std::size_t>(ix);
  }
  [[nodiscard]] bool contains(int ix, int iy, int iz) const {
    return ix >= 0 && iy >= 0 && iz >= 0 && ix < nx && iy < ny && iz < nz;
  }
  [[nodiscard]] hal::Vec3 middle(int ix, int iy, int iz) const {
    return origin + cell_m * hal::Vec3(ix + 0.5, iy + 0.5, iz + 0.5);
  }
  /// Cell of a point, which may lie outside of the grid.
  [[nodiscard]] Eigen::Vector3i cell_of(const hal::Vec3& p_W) const {
    return ((p_W - origin) / cell_m).array().floor().matrix().cast<int>();
  }
};

/// The collision world: an OctoMap of the scene from depth with ray-cast freeing. The target is kept apart as
/// its own cells, so that the arm may not touch it but the fingers may.
///
/// Evidence is kept as clamped log odds with OctoMap's weights (Hornung et al., Autonomous Robots 2013), on a
/// regular grid over the mapped space: entering a frame is one pass over the cells, each looking along its
/// own ray, where OctoMap walks from its root for every cell of every ray. tree() is made from it.
class WorldMap {
 public:
  explicit WorldMap(const WorldMapConfig& config);
  ~WorldMap();
  WorldMap(WorldMap&&) noexcept;
  WorldMap& operator=(WorldMap&&) noexcept;

  /// Enters one frame: cells on the way of each ray become freer, those at its end more occupied. Pixels in
  /// `not_scene` (target, partner; ascending) end their rays without entering an obstacle.
  void insert(const OrganisedCloud& cloud, std::span<const std::uint32_t> not_scene);

  /// Something was carried off where this frame looks past occupied cells to what is clearly farther: they
  /// become free, and so does what they hid and the frame shows. Cells beside one that may still be there
  /// stay; a few alone are noise, and change nothing. Returns how many occupied ones became free.
  std::size_t free_carried_off(const OrganisedCloud& cloud);

  /// Frees the cells that the robot's own links take, padded.
  void carve_robot(const hal::RobotModel& model, const hal::JointVector& q_rad, const hal::HandPosture& hand);
  /// Frees the cells whose middle is in a box (m, W).
  void carve(const hal::Aabb& box_W);

  /// The target's points as cells of their own; replaces the last ones. Occupied cells of the map that are
  /// these or touch them (its edges, which no segmentation gets right to the pixel) become the target's.
  void set_target(std::span<const hal::Vec3> points_W);
  [[nodiscard]] const std::vector<hal::Vec3>& target_cells() const;  ///< Middles of its cells.

  /// The map as a regular grid over [min_m, max_m]; an unknown cell is hidden where any of the frames looks.
  /// Valid until the map changes.
  [[nodiscard]] const CellGrid& grid() const;
  /// Most likely state of the known cells, pruned; without the target. Made when it is asked for: the first
  /// call after a change takes some milliseconds. Any thread, until the map changes.
  [[nodiscard]] const octomap::OcTree& tree() const;
  [[nodiscard]] std::size_t occupied_cells() const;

  /// The map that a tree describes, as tree() gave it or as OctoMap read it from a file (writeBinary and
  /// readBinary; the latter believes what it reads and recurses as deep as a damaged file says: read only
  /// files that are trusted). What lies outside of the mapped space is left out. Errors: BadInput (cells of
  /// another size).
  [[nodiscard]] static hal::Result<WorldMap> from_tree(const octomap::OcTree& tree,
                                                       const WorldMapConfig& config);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace colift::perception
