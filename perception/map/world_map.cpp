#include "perception/map/world_map.hpp"

#include <fmt/format.h>
#include <octomap/octomap.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <type_traits>
#include <utility>

#include "perception/map/cell_tree.hpp"
#include "perception/map/cell_view.hpp"
#include "perception/map/line_of_sight.hpp"

namespace colift::perception {
namespace {

using hal::Vec3;

// OctoMap's defaults: hit 0.7, miss 0.4, clamped at 0.12 and 0.97, as hundredths of log odds.
constexpr std::int16_t kHit = 85, kMiss = -40, kMin = -200, kMost = 350;
constexpr double kLargestGrid = 4e8;  // cells; beyond it a configuration is a mistake
constexpr std::size_t kMinGone = 12;  // cells: a mug has more

/// Whole cells around the mapped space, corners at multiples of the cell as OctoMap has them.
CellGrid lay_out(const WorldMapConfig& config) {
  CellGrid grid;
  grid.cell_m = config.cell_m;
  const auto first = (config.min_m / config.cell_m).array().floor();
  Vec3 last = (config.max_m / config.cell_m).array().ceil();
  Vec3 n = (last.array() - first).cwiseMax(1.0);
  if (n.prod() > kLargestGrid || !n.allFinite()) n = Vec3::Ones();
  grid.origin = config.cell_m * first.matrix();
  grid.nx = static_cast<int>(n.x());
  grid.ny = static_cast<int>(n.y());
  grid.nz = static_cast<int>(n.z());
  grid.cells.assign(grid.index(0, 0, grid.nz), CellState::OutOfView);
  return grid;
}

/// Half size of the box around a link's shape, in the shape's frame.
Vec3 half_size(const hal::LinkShape& shape) {
  switch (shape.kind) {
    case hal::LinkShape::Kind::Box:
      return 0.5 * shape.size;
    case hal::LinkShape::Kind::Cylinder:
      return {shape.size[0], shape.size[0], 0.5 * shape.size[1]};
    case hal::LinkShape::Kind::Sphere:
      break;
  }
  return Vec3::Constant(shape.size[0]);
}

/// Distance of a point in the shape's frame from the shape; 0 inside.
double distance_to(const hal::LinkShape& shape, const Vec3& p_S) {
  const Vec3 half = half_size(shape);
  if (shape.kind == hal::LinkShape::Kind::Sphere) return std::max(0.0, p_S.norm() - half.x());
  if (shape.kind == hal::LinkShape::Kind::Cylinder) {
    return std::hypot(std::max(0.0, p_S.head<2>().norm() - half.x()),
                      std::max(0.0, std::abs(p_S.z()) - half.z()));
  }
  return (p_S.cwiseAbs() - half).cwiseMax(0.0).norm();
}

}  // namespace

struct WorldMap::Impl {
  explicit Impl(const WorldMapConfig& settings)
      : config(settings),
        grid(lay_out(settings)),
        log_odds(grid.cells.size(), 0),
        view(grid.cells.size(), CellView::OutOfView) {}

  WorldMapConfig config;
  CellGrid grid;
  std::vector<std::int16_t> log_odds;
  std::vector<CellView> view;  // of the first frame; of later ones where they look
  std::vector<CellView> later;
  bool has_frame = false;
  std::vector<Vec3> target;

  std::mutex making_tree;
  std::unique_ptr<octomap::OcTree> tree;

  [[nodiscard]] CellState state_of(std::size_t cell) const {
    if (log_odds[cell] > 0) return CellState::Occupied;
    if (log_odds[cell] < 0) return CellState::Free;
    return view[cell] == CellView::OutOfView ? CellState::OutOfView : CellState::Hidden;
  }
  void set(std::size_t cell, std::int16_t odds) {
    log_odds[cell] = odds;
    grid.cells[cell] = state_of(cell);
  }
  /// Occupied cells that a frame looks past, and beside which there is no other occupied one.
  [[nodiscard]] std::vector<std::size_t> seen_past(const OrganisedCloud& cloud) const {
    const hal::Pose X_CW = cloud.X_WC.inverse();
    std::vector<std::array<int, 3>> past;
    std::vector<std::uint8_t> is_past(log_odds.size(), 0);
    std::size_t cell = 0;
    for (int z = 0; z < grid.nz; ++z)
      for (int y = 0; y < grid.ny; ++y)
        for (int x = 0; x < grid.nx; ++x, ++cell)
          if (log_odds[cell] > 0 && looks_past(cloud, X_CW, grid.middle(x, y, z), 0.5 * grid.cell_m)) {
            past.push_back({x, y, z});
            is_past[cell] = 1;
          }
    std::vector<std::size_t> gone;
    for (const auto& [x, y, z] : past) {
      bool beside = false;
      for (int around = 0; around < 27 && !beside; ++around) {
        const int bx = x + around % 3 - 1, by = y + around / 3 % 3 - 1, bz = z + around / 9 - 1;
        if (!grid.contains(bx, by, bz)) continue;
        const std::size_t b = grid.index(bx, by, bz);
        beside = log_odds[b] > 0 && is_past[b] == 0;
      }
      if (!beside) gone.push_back(grid.index(x, y, z));
    }
    return gone;
  }
  /// Calls `work(cell, middle)` for all cells with their middle in a box.
  template <class Work>
  void in_box(const hal::Aabb& box_W, Work work) {
    const Vec3 n(grid.nx, grid.ny, grid.nz), half = Vec3::Constant(0.5);
    const Vec3 low = (box_W.min() - grid.origin) / grid.cell_m - half,
               high = (box_W.max() - grid.origin) / grid.cell_m - half;
    const Eigen::Vector3i from = low.array().ceil().max(0.0).min(n.array()).matrix().cast<int>();
    const Eigen::Vector3i to = (high.array().floor() + 1.0).max(0.0).min(n.array()).matrix().cast<int>();
    for (int z = from.z(); z < to.z(); ++z) {
      for (int y = from.y(); y < to.y(); ++y) {
        for (int x = from.x(); x < to.x(); ++x) work(grid.index(x, y, z), grid.middle(x, y, z));
      }
    }
  }
};

WorldMap::WorldMap(const WorldMapConfig& config) : impl_(std::make_unique<Impl>(config)) {}
WorldMap::~WorldMap() = default;
WorldMap::WorldMap(WorldMap&&) noexcept = default;
WorldMap& WorldMap::operator=(WorldMap&&) noexcept = default;

void WorldMap::insert(const OrganisedCloud& cloud, std::span<const std::uint32_t> not_scene) {
  Impl& m = *impl_;
  m.tree.reset();
  const bool first = !std::exchange(m.has_frame, true);
  std::vector<CellView>& view = first ? m.view : m.later;
  view_cells(m.grid, cloud, not_scene, m.config.max_range_m, view, m.config.view);
  const auto enter = [&](auto of_first, const std::vector<CellView>& seen) {
    for (std::size_t i = 0; i < m.view.size(); ++i) {
      int odds = m.log_odds[i];
      if (seen[i] == CellView::Hit) odds = std::min<int>(odds + kHit, kMost);
      if (seen[i] == CellView::Through) odds = std::max<int>(odds + kMiss, kMin);
      if constexpr (!of_first)
        if (seen[i] != CellView::OutOfView) m.view[i] = seen[i];
      m.set(i, static_cast<std::int16_t>(odds));
    }
  };
  if (first)
    enter(std::true_type{}, m.view);
  else
    enter(std::false_type{}, m.later);
}

std::size_t WorldMap::free_carried_off(const OrganisedCloud& cloud) {
  Impl& m = *impl_;
  const std::vector<std::size_t> gone = m.seen_past(cloud);
  if (gone.size() < kMinGone) return 0;
  m.tree.reset();
  view_cells(m.grid, cloud, {}, m.config.max_range_m, m.later, m.config.view);
  for (std::size_t cell = 0; cell < m.later.size(); ++cell)
    if (m.later[cell] == CellView::Through && m.log_odds[cell] == 0) m.set(cell, kMiss);
  for (const std::size_t cell : gone) m.set(cell, kMin);
  return gone.size();
}

void WorldMap::carve(const hal::Aabb& box_W) {
  Impl& m = *impl_;
  m.tree.reset();
  m.in_box(box_W, [&](std::size_t cell, const Vec3&) { m.set(cell, kMin); });
}

void WorldMap::carve_robot(const hal::RobotModel& model, const hal::JointVector& q_rad,
                           const hal::HandPosture& hand) {
  Impl& m = *impl_;
  m.tree.reset();
  const double padding = m.config.robot_padding_m;
  std::vector<hal::Pose> X_WL;
  hal::link_poses(model, q_rad, hand, X_WL);
  for (std::size_t l = 0; l < model.links.size(); ++l) {
    for (const hal::LinkShape& shape : model.links[l].shapes) {
      const hal::Pose X_WS = X_WL[l] * shape.X_LS, X_SW = X_WS.inverse();
      const Vec3 reach = X_WS.linear().cwiseAbs() * half_size(shape) + Vec3::Constant(padding);
      m.in_box({X_WS.translation() - reach, X_WS.translation() + reach},
               [&](std::size_t cell, const Vec3& middle) {
                 if (distance_to(shape, X_SW * middle) <= padding) m.set(cell, kMin);
               });
    }
  }
}

void WorldMap::set_target(std::span<const Vec3> points_W) {
  Impl& m = *impl_;
  m.tree.reset();
  m.target.clear();
  std::vector<std::array<int, 3>> cells;  // z, y, x: in the grid's order
  cells.reserve(points_W.size());
  for (const Vec3& p : points_W) {
    if (!p.allFinite() || p.cwiseAbs().maxCoeff() > 1e3) continue;
    const Eigen::Vector3i c = m.grid.cell_of(p);
    if (cells.empty() || cells.back() != std::array{c.z(), c.y(), c.x()}) {
      cells.push_back({c.z(), c.y(), c.x()});
    }
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  const std::size_t own = cells.size();
  for (std::size_t i = 0; i < own; ++i) {
    for (int around = 0; around < 27; ++around) {
      const int z = cells[i][0] + around / 9 - 1, y = cells[i][1] + around / 3 % 3 - 1,
                x = cells[i][2] + around % 3 - 1;
      if (!m.grid.contains(x, y, z)) continue;
      const std::size_t cell = m.grid.index(x, y, z);
      if (m.log_odds[cell] <= 0) continue;
      m.set(cell, 0);
      cells.push_back({z, y, x});
    }
  }
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
  for (const auto& [z, y, x] : cells) m.target.push_back(m.grid.middle(x, y, z));
}

const std::vector<Vec3>& WorldMap::target_cells() const {
  return impl_->target;
}

const CellGrid& WorldMap::grid() const {
  return impl_->grid;
}

const octomap::OcTree& WorldMap::tree() const {
  const std::lock_guard lock(impl_->making_tree);
  if (!impl_->tree) impl_->tree = make_tree(impl_->grid);
  return *impl_->tree;
}

std::size_t WorldMap::occupied_cells() const {
  return static_cast<std::size_t>(
      std::count(impl_->grid.cells.begin(), impl_->grid.cells.end(), CellState::Occupied));
}

hal::Result<WorldMap> WorldMap::from_tree(const octomap::OcTree& tree, const WorldMapConfig& config) {
  if (!(std::abs(tree.getResolution() - config.cell_m) <= 1e-6)) {
    return hal::failure(hal::ErrorCode::BadInput, "octree",
                        fmt::format("has cells of {} m, expected {} m", tree.getResolution(), config.cell_m));
  }
  WorldMap map(config);
  Impl& m = *map.impl_;
  for (int z = 0; z < m.grid.nz; ++z) {
    for (int y = 0; y < m.grid.ny; ++y) {
      for (int x = 0; x < m.grid.nx; ++x) {
        const Vec3 p = m.grid.middle(x, y, z);
        if (const auto* node = tree.search(p.x(), p.y(), p.z()))
          m.set(m.grid.index(x, y, z), tree.isNodeOccupied(node) ? kMost : kMin);
      }
    }
  }
  return map;
}

}  // namespace colift::perception
