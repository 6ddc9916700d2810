// The collision world as Foxglove's entities.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "planner/motion/collision/collision_scene.hpp"
#include "tools/telemetry/channels/scene_parts.hpp"

namespace colift::telemetry {
namespace {

using Cell = MapView::Cell;
using perception::CellState;

constexpr double kReach = 2.0;            // from the robot's axis, and up (m)
constexpr double kBelow = 0.2;            // under the robot's base (m)
constexpr double kMostCells = 4e6;        // of a message's grid
constexpr std::size_t kMostBoxes = 3000;  // of each kind; some 200 bytes each

/// What is drawn, and in which colour.
struct Kind {
  Cell cell;
  const char* id;
  Colour colour;
};
constexpr Kind kKinds[] = {{Cell::Obstacle, "obstacles", {0.84, 0.37, 0.0, 0.6}},
                           {Cell::Target, "target", {0.9, 0.75, 0.2, 0.35}},
                           {Cell::Hidden, "hidden", {0.5, 0.5, 0.6, 0.12}}};

/// Cells from `low` up to, not including, `high`.
struct Box {
  std::array<int, 3> low{}, high{};
  [[nodiscard]] std::size_t cells() const {
    std::size_t n = 1;
    for (std::size_t i = 0; i < 3; ++i) n *= static_cast<std::size_t>(high[i] - low[i]);
    return n;
  }
};

/// Takes the cells of one kind out of a grid as boxes: each grows along x, then y, then z as far as it can.
class Boxes {
 public:
  explicit Boxes(const MapView& map) : map_(map), left_(map.cells) {}

  [[nodiscard]] std::vector<Box> take(Cell kind) {
    std::vector<Box> all;
    const auto& n = map_.size;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x)
          if (left_[index(x, y, z)] == kind) all.push_back(grown({x, y, z}, kind));
    return all;
  }

 private:
  [[nodiscard]] std::size_t index(int x, int y, int z) const {
    return static_cast<std::size_t>((static_cast<std::ptrdiff_t>(z) * map_.size[1] + y) * map_.size[0] + x);
  }
  template <class Visit>
  void each(const Box& b, Visit visit) const {
    for (int z = b.low[2]; z < b.high[2]; ++z)
      for (int y = b.low[1]; y < b.high[1]; ++y)
        for (int x = b.low[0]; x < b.high[0]; ++x) visit(index(x, y, z));
  }
  [[nodiscard]] Box grown(const std::array<int, 3>& from, Cell kind) {
    Box box{from, {from[0] + 1, from[1] + 1, from[2] + 1}};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      while (box.high[axis] < map_.size[axis]) {
        Box next = box;
        next.low[axis] = box.high[axis];
        next.high[axis] = box.high[axis] + 1;
        bool whole = true;
        each(next, [&](std::size_t i) { whole = whole && left_[i] == kind; });
        if (!whole) break;
        ++box.high[axis];
      }
    }
    each(box, [&](std::size_t i) { left_[i] = Cell::Nothing; });
    return box;
  }

  const MapView& map_;
  std::vector<Cell> left_;
};

/// Corners are whole cells: written as short as they are.
double rounded(double metres) {
  return std::round(1e4 * metres) / 1e4;
}

hal::Vec3 corner(const MapView& map, const std::array<double, 3>& cells) {
  hal::Vec3 p = map.origin_W + map.cell_m * hal::Vec3(cells[0], cells[1], cells[2]);
  for (double& v : p) v = rounded(v);
  return p;
}

}  // namespace

MapView map_view(const perception::WorldMap& map, const hal::Plane& ground) {
  const perception::CellGrid& grid = map.grid();
  // whole cells of the map in the wanted box
  const hal::Vec3 low(-kReach, -kReach, -kBelow), high(kReach, kReach, kReach);
  const std::array<int, 3> have = {grid.nx, grid.ny, grid.nz};
  std::array<int, 3> first{}, count{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    const auto at = [&](double p) {
      return std::clamp(static_cast<int>(std::lround((p - grid.origin[axis]) / grid.cell_m)), 0, have[i]);
    };
    first[i] = at(low[axis]);
    count[i] = std::max(0, at(high[axis]) - first[i]);
  }
  // with too many of them, several make one
  int coarse = 1;
  const auto cells_with = [&](int edge) {
    double n = 1.0;
    for (const int c : count) n *= (c + edge - 1) / edge;
    return n;
  };
  while (cells_with(coarse) > kMostCells) ++coarse;
  MapView view;
  view.cell_m = coarse * grid.cell_m;
  view.origin_W = grid.origin + grid.cell_m * hal::Vec3(first[0], first[1], first[2]);
  for (std::size_t i = 0; i < 3; ++i) view.size[i] = (count[i] + coarse - 1) / coarse;
  view.cells.assign(static_cast<std::size_t>(cells_with(coarse)), Cell::Nothing);

  const auto place = [&](const std::array<int, 3>& c, Cell kind) {
    std::array<int, 3> in{};
    for (std::size_t i = 0; i < 3; ++i) {
      in[i] = c[i] - first[i];
      if (in[i] < 0 || in[i] >= count[i]) {
        if (kind != Cell::Hidden) ++view.cropped;
        return;
      }
      in[i] /= coarse;
    }
    Cell& cell = view.cells[static_cast<std::size_t>(
        (static_cast<std::ptrdiff_t>(in[2]) * view.size[1] + in[1]) * view.size[0] + in[0])];
    if (kind != Cell::Hidden || cell == Cell::Nothing) cell = kind;
  };
  std::size_t i = 0;
  for (int z = 0; z < grid.nz; ++z)
    for (int y = 0; y < grid.ny; ++y)
      for (int x = 0; x < grid.nx; ++x, ++i) {
        const CellState state = grid.cells[i];
        if (state != CellState::Occupied && state != CellState::Hidden) continue;
        if (ground.height(grid.middle(x, y, z)) < planner::kGroundCells * grid.cell_m) continue;
        place({x, y, z}, state == CellState::Occupied ? Cell::Obstacle : Cell::Hidden);
      }
  for (const hal::Vec3& middle : map.target_cells()) {
    const Eigen::Vector3i c = grid.cell_of(middle);
    place({c.x(), c.y(), c.z()}, Cell::Target);
  }
  return view;
}

std::string map_message(hal::Timestamp at, const MapView& map) {
  Entities out(at);
  Boxes boxes(map);
  const std::array<double, 3> none{}, all{static_cast<double>(map.size[0]), static_cast<double>(map.size[1]),
                                          static_cast<double>(map.size[2])};
  const hal::Vec3 from = corner(map, none), to = corner(map, all);
  const auto text = [](const hal::Vec3& p) { return fmt::format("{} {} {}", p.x(), p.y(), p.z()); };
  for (const Kind& kind : kKinds) {
    std::vector<Box> list = boxes.take(kind.cell);
    std::size_t cells = 0, left_out = 0;
    if (list.size() > kMostBoxes) {
      const auto distance = [&](const Box& b) {
        const hal::Vec3 p = corner(map, {0.5 * (b.low[0] + b.high[0]), 0.5 * (b.low[1] + b.high[1]), 0.0});
        return std::hypot(p.x(), p.y());
      };
      std::stable_sort(list.begin(), list.end(),
                       [&](const Box& a, const Box& b) { return distance(a) < distance(b); });
      for (std::size_t i = kMostBoxes; i < list.size(); ++i) left_out += list[i].cells();
      list.resize(kMostBoxes);
    }
    Json cubes = Json::array();
    for (const Box& b : list) {
      cells += b.cells();
      const auto middle = [&](std::size_t i) { return 0.5 * (b.low[i] + b.high[i]); };
      const auto edge = [&](std::size_t i) { return rounded(map.cell_m * (b.high[i] - b.low[i])); };
      cubes.push_back(solid_json(pose_of(corner(map, {middle(0), middle(1), middle(2)})),
                                 {edge(0), edge(1), edge(2)}, kind.colour));
    }
    Json& entity = out.add(kind.id, Json::array({pair_json("cell_m", fmt::format("{}", map.cell_m)),
                                                 pair_json("cells", std::to_string(cells)),
                                                 pair_json("left_out", std::to_string(left_out)),
                                                 pair_json("from", text(from)), pair_json("to", text(to))}));
    entity["cubes"] = std::move(cubes);
  }
  return dumped(out.take());
}

}  // namespace colift::telemetry
